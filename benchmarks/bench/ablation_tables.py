"""Tables of benchmarks/ablation.py: a row for each variant, a column for each drive or recording."""

from .ablation import VARIANTS
from .accuracy_tables import header, line, number

BEGIN, END = "<!-- ablation:begin -->", "<!-- ablation:end -->"


def variants_in(scenes):
    """In the order of VARIANTS, those that any scene has a run of."""
    found = {run["variant"] for scene in scenes for run in scene["runs"]}
    return [name for name in VARIANTS if name in found]


def run_of(scene, variant):
    return next((run for run in scene["runs"] if run["variant"] == variant), None)


def cell(scene, variant, names):
    """Figures apart by commas; a dash where the variant changes nothing."""
    run = run_of(scene, variant)
    if run is None:
        return "-"
    if "error" in run:
        return "failed"
    values = [number(run["figures"].get(name), digits) for name, digits in names]
    lost = run["figures"]["frames"] - run["figures"]["tracked"] - 1  # the first is never tracked
    return ", ".join(values) + (f" ({lost})" if lost > 0 and names != TIME else "")


def table(scenes, names):
    """names: (figure, digits) of every cell."""
    rows = header(["variant"] + [scene["label"] for scene in scenes])
    for variant in variants_in(scenes):
        rows.append(line([VARIANTS[variant].label] + [cell(scene, variant, names) for scene in scenes]))
    return rows


def made_with(made):
    commit = (made["binary"].get("commit") or made["checkout"]["commit"] or "unknown")[:7]
    if made["checkout"]["dirty"] and not made["binary"].get("commit"):
        commit += " with changes"
    return (f"Made by `benchmarks/ablation.py` on {made['date'][:10]}: tvl {made['binary']['version']}, "
            f"commit {commit}; {made['machine']['cpu']}, one thread; `--no-loops`. In brackets: frames, but the "
            "first, that were not `tracked`. A dash: the variant changes nothing there, or was not run. Load "
            f"{made['machine']['load_average'][0]:.1f} when it began: with other work on the machine times are "
            "upper bounds.")


SIMULATED = (("t_err_pct", 3), ("ate_m", 3))
REAL = (("from_median_m", 3), ("thickness_mm", 2), ("entropy", 3))
TRUE = (("ate_m", 3),)
TIME = (("cpu_ms", 0),)


def markdown(result):
    """Everything between the markers."""
    simulated = [scene for scene in result["scenes"] if scene["simulated"]]
    real = [scene for scene in result["scenes"] if not scene["simulated"]]
    with_truth = [scene for scene in real if scene["path_m"] is not None]
    lines = [made_with(result["made"]), ""]
    for title, scenes, names in (
            ("Simulated drives: t_err %, ATE m (camera: the city drives; all others lidar-only)", simulated, SIMULATED),
            ("Real recordings, `--deskew cw`: end from the peers' median m, plane thickness mm, map entropy",
             real, REAL),
            ("Real recordings with truth: ATE m", with_truth, TRUE),
            ("Processor time a frame, ms, reading included", result["scenes"], TIME)):
        if scenes:
            lines += [f"**{title}**", "", *table(scenes, names), ""]
    return "\n".join(lines).rstrip() + "\n"
