"""The tables of docs/evaluation.md out of accuracy.json."""

import math
import statistics

from .trials import SYSTEMS

BEGIN, END = "<!-- accuracy:begin -->", "<!-- accuracy:end -->"
# figure -> heading of its column, digits, whether it is compared with the best peer
FIGURES = {
    "t_err_pct": ("t_err %", 3, True),
    "r_err_deg_per_100m": ("r_err deg/100 m", 4, True),
    "ate_m": ("ATE m", 3, True),
    "ate_first_m": ("ATE m, first pose", 3, True),
    "heading_deg_per_km": ("heading deg/km", 2, True),
    "heading_signed_deg_per_km": ("signed", 2, False),
    "end_m": ("end m", 2, True),
    "end_deg": ("end deg", 3, True),
    "ms_p50": ("ms", 0, False),
}
LEADING = ("t_err_pct", "r_err_deg_per_100m", "ate_m", "heading_deg_per_km", "end_m")


# Numbers ----------------------------------------------------------------------------------------
def summary(runs):
    """system -> figure -> {mean, sd, count} over the seeds; sd is null for a single one."""
    out = {}
    for system in SYSTEMS:
        figures = [r["figures"] for r in runs if r["system"] == system and "figures" in r]
        out[system] = {}
        for name in FIGURES:
            values = [f[name] for f in figures if f.get(name) is not None]
            if values:
                out[system][name] = {
                    "mean": statistics.fmean(values), "count": len(values),
                    "sd": statistics.stdev(values) if len(values) > 1 else None}
    return {system: figures for system, figures in out.items() if figures}


def best_peer(summary_of_drive, figure, with_loops):
    """(mean, system) of the peer with the lowest mean, None without one.

    Odometry is compared with odometry; a system that closes loops with every peer.
    """
    means = [(figures[figure]["mean"], system) for system, figures in summary_of_drive.items()
             if not SYSTEMS[system].is_ours and figure in figures
             and (with_loops or not SYSTEMS[system].closes_loops)]
    return min(means, default=None)


def ratio(summary_of_drive, system, figure):
    """Of the mean to that of the best peer; None where there is none, or nothing is measured."""
    value = summary_of_drive[system].get(figure)
    best = best_peer(summary_of_drive, figure, SYSTEMS[system].closes_loops)
    if value is None or best is None or best[0] <= 0.0:
        return None
    return value["mean"] / best[0]


def number(value, digits):
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}f}"


# Tables -----------------------------------------------------------------------------------------
def line(cells):
    return "| " + " | ".join(cells) + " |"


def header(cells):
    return [line(cells), "|" + "---|" * len(cells)]


def figure_cell(summary_of_drive, system, figure):
    """mean +- sd (ratio to the best peer)."""
    _, digits, compared = FIGURES[figure]
    value = summary_of_drive[system].get(figure)
    if value is None:
        return "-"
    text = number(value["mean"], digits)
    if value["sd"] is not None:
        text += f" ± {number(value['sd'], digits)}"
    share = ratio(summary_of_drive, system, figure) if compared else None
    return text if share is None else f"{text} ({share:.2f})"


def drive_title(drive):
    seeds = "seed" + "s" * (len(drive["seeds"]) > 1) + " " + ", ".join(map(str, drive["seeds"]))
    lengths = drive["path_m"]
    metres = f"{min(lengths):.0f} to {max(lengths):.0f} m" if len(lengths) > 1 else f"{lengths[0]:.0f} m"
    return (f"**{drive['kind']}**: {drive['label']}; {drive['frames']} frames, {metres}, "
            f"{seeds}")


def drive_table(drive):
    rows = header(["system"] + [title for title, _, _ in FIGURES.values()])
    for system in drive["summary"]:
        rows.append(line([SYSTEMS[system].label] + [
            figure_cell(drive["summary"], system, figure) for figure in FIGURES]))
    failed = [f"Seed {r['seed']}, {SYSTEMS[r['system']].label}: {r['error']}"
              for r in drive["runs"] if "error" in r]
    return [drive_title(drive), ""] + rows + [""] + failed + [""] * bool(failed)


def ratio_table(drives):
    """Ours over the best peer, one line a drive and variant."""
    rows = header(["drive", "system"] + [FIGURES[f][0] for f in LEADING])
    for drive in drives:
        for system in drive["summary"]:
            if SYSTEMS[system].is_ours:
                shares = [(ratio(drive["summary"], system, f),
                           best_peer(drive["summary"], f, SYSTEMS[system].closes_loops))
                          for f in LEADING]
                rows.append(line([drive["kind"], SYSTEMS[system].label] + [
                    "-" if share is None else f"{share:.2f} ({SYSTEMS[best[1]].label})"
                    for share, best in shares]))
    return ["Ours over the best peer of each figure (below 1: ours is the better), means over the seeds:",
            "", *rows, ""]


RECORDING_COLUMNS = ("recording", "de-skewing", "system", "end from the peers' median m",
                     "against truth: end m, end deg, rms m (aligned, first pose)",
                     "map entropy (points)", "plane thickness mm (voxels, points)", "ms")


def truth_cell(figures):
    if "ate_m" not in figures:
        return "-"
    return (f"{figures['end_m']:.3f}, {figures['end_deg']:.3f}, {figures['ate_m']:.3f}, "
            f"{figures['ate_first_m']:.3f}")


def recording_cells(run):
    if "error" in run:
        return [f"refused: {run['error']}", "-", "-", "-", "-"]
    f = run["figures"]
    return [number(f["from_median_m"], 3), truth_cell(f),
            f"{number(f['entropy'], 3)} ({f['entropy_points']})",
            f"{number(f['thickness_mm'], 1)} ({f['planar_voxels']}, {f['planar_points']})",
            number(f.get("ms_p50"), 0)]


def recording_table(recordings):
    rows = header(RECORDING_COLUMNS)
    for recording in recordings:
        head = [f"{recording['name']}, {recording['frames']} frames", recording["spin"] or "none"]
        for run in recording["runs"]:
            rows.append(line(head + [SYSTEMS[run["system"]].label] + recording_cells(run)))
            head = ["", ""]
    return ["**Real recordings**", "", *rows, ""]


def deskewing_text(instants):
    moved = ", ".join(f"{SYSTEMS[key].label} {share:.2f}" for key, share in instants.items())
    return f"Raw scans: each system de-skews by itself, to this share of the sweep: {moved}."


def made_with(made):
    commit = (made["binary"].get("commit") or made["checkout"]["commit"] or "unknown")[:7]
    if made["checkout"]["dirty"] and not made["binary"].get("commit"):
        commit += " with changes"
    versions = ", ".join(f"{name} {version}" for name, version in made["packages"].items()
                         if version and name in ("kiss-icp", "genz-icp", "small-gicp", "kiss-slam"))
    load = made["machine"]["load_average"][0]
    return (f"Made by `benchmarks/accuracy` on {made['date'][:10]}: tvl {made['binary']['version']}, "
            f"commit {commit}; {versions}; {made['machine']['cpu']}, {made['machine']['cores']} cores, "
            f"of which each run had one; load {load:.1f} when it began: with other work on the machine "
            "times are upper bounds.")


def markdown(result):
    """Everything between the markers."""
    lines = [made_with(result["made"]), ""]
    if result["drives"]:
        lines += ratio_table(result["drives"])
        lines += ["Mean ± standard deviation over the seeds; in brackets the ratio to the best peer "
                  "(odometry to odometry; what closes loops to all). "
                  + deskewing_text(result["made"]["deskews_to"]), ""]
    for drive in result["drives"]:
        lines += drive_table(drive)
    if result["recordings"]:
        lines += recording_table(result["recordings"])
    return "\n".join(lines).rstrip() + "\n"


def replaced(document, tables, markers=(BEGIN, END)):
    """The document with the tables between its markers."""
    before, begin, rest = document.partition(markers[0])
    _, end, after = rest.partition(markers[1])
    if not begin or not end:
        raise ValueError(f"the document has no {markers[0]} ... {markers[1]}")
    return f"{before}{begin}\n{tables.strip()}\n{end}{after}"
