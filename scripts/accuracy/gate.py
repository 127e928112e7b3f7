"""The accuracy gate: drives and recordings, figures of their runs, and the bounds these must keep.

Bounds are made from figures by RULES and kept in tests/accuracy/bounds.txt; `scripts/accuracy_gate
--update` writes it.
"""

import dataclasses
import fnmatch
import json
import math
import pathlib
import subprocess

from . import fault_cases, faulty, figures, judge, poses

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOUNDS = ROOT / "tests/accuracy/bounds.txt"
BULK = ("map.pcd", "map.ply", "map.png")


@dataclasses.dataclass(frozen=True)
class Rule:
    """How a figure may differ from what it was when the bounds were made."""
    pattern: str          # of the figure's name
    upper: float | None   # factor
    lower: float | None   # factor
    margin: float         # added on top: the figure's resolution, for figures near zero
    why: str


# First match wins.
RULES = (
    Rule("silent_errors", 0.0, None, 0.0, "none are allowed, whatever they were"),
    Rule("not_tracked", 1.0, None, 2.0, "frames without a claim: faults cost few more than they must"),
    Rule("nees_*", 1.3, 0.77, 0.02, "too confident or too timid: goes with the square of the weights"),
    Rule("claimed_*", 1.05, 0.95, 0.0, "hardly any noise: changes with the weights alone"),
    Rule("map_*_rms_*", 1.05, 0.95, 0.0, "residuals: hardly any noise"),
    Rule("map_*", 1.15, 0.87, 5.0, "how many residuals take part"),
    Rule("planar_share", None, 0.97, 0.0, "a smeared map has fewer planes, and these look thin"),
    Rule("thickness_mm", 1.1, None, 0.1, "noise of the scans is most of it: 10 % are a lot"),
    Rule("step_*", 1.3, None, 0.0, ""),
    Rule("t_err_pct", 1.3, None, 0.02, ""),
    Rule("r_err_*", 1.3, None, 0.005, ""),
    Rule("*_m", 1.3, None, 0.02, "distances of end points"),
)


@dataclasses.dataclass(frozen=True)
class Bound:
    scene: str
    figure: str
    value: float   # when the bounds were made
    lower: float
    upper: float


def rule_of(figure):
    for rule in RULES:
        if fnmatch.fnmatch(figure, rule.pattern):
            return rule
    raise ValueError(f"no rule for the figure {figure}")


def bound_of(scene, figure, value):
    rule = rule_of(figure)
    upper = math.inf if rule.upper is None else rule.upper * value + rule.margin
    lower = -math.inf if rule.lower is None else rule.lower * value - rule.margin
    return Bound(scene, figure, value, lower, upper)


def read_bounds(path=BOUNDS):
    bounds = []
    for line in path.read_text().splitlines():
        words = line.split("#")[0].split()
        if words:
            bounds.append(Bound(words[0], words[1], *map(float, words[2:])))
    return bounds


def write_bounds(bounds, path=BOUNDS):
    rules = "".join(f"#   {r.pattern:<16} {r.why}\n" for r in RULES if r.why)
    lines = [f"{b.scene:<42} {b.figure:<20} {b.value:10.4g} {b.lower:10.4g} {b.upper:10.4g}"
             for b in sorted(bounds, key=lambda b: b.scene)]
    path.write_text(
        "# Figures of accuracy and their bounds, from the rules in scripts/accuracy/gate.py:\n"
        f"{rules}"
        "# Made by:  scripts/accuracy_gate --update  (--scenes NAME,... for some of them)\n"
        f"# {'scene':<40} {'figure':<20} {'figure':>10} {'at least':>10} {'at most':>10}\n"
        + "\n".join(lines) + "\n")


def broken(scene, found, bounds):
    """A message for each figure of the scene that is out of bounds, or has none."""
    mine = {b.figure: b for b in bounds if b.scene == scene}
    messages = [f"{scene}: no figure {name}" for name in mine if name not in found]
    for name, value in found.items():
        if name not in mine:
            messages.append(f"{scene}: no bound for {name}")
        elif not mine[name].lower <= value <= mine[name].upper:
            b = mine[name]
            messages.append(f"{scene}: {name} {value:.4g}, was {b.value:.4g}, "
                            f"bounds {b.lower:.4g} to {b.upper:.4g}")
    return messages


# Scenes -----------------------------------------------------------------------------------------
@dataclasses.dataclass(frozen=True)
class Tools:
    tvl: pathlib.Path
    thickness: pathlib.Path           # tvl_map_thickness
    data: pathlib.Path | None = None  # TVL_TEST_DATA
    options: tuple = ()               # added to every run


def tools_in(build, data=None, options=()):
    return Tools(build / "tvl", build / "tvl_map_thickness", data, options)


@dataclasses.dataclass(frozen=True)
class Drive:
    """A simulated drive, on the disk."""
    name: str
    arguments: tuple     # of tvl simulate
    deskew: str
    faults: bool = False


DRIVES = (
    Drive("drive", ("--preset", "city", "--seed", "61", "--frames", "320"), "none"),
    Drive("faults", ("--preset", "traffic", "--seed", "62", "--frames", "320", "--raw", "cw"), "cw",
          faults=True),
)
# (recording, --deskew, with the camera, too)
RECORDINGS = (
    ("kitti360_3000", "cw", True),
    ("kitti_2011_09_26_0052_jam", "none", True),
    ("kitti_2011_09_26_0013_first16", "cw", False),
    ("kitti_2011_09_26_0013_first16", "none", False),
    ("kitti_odometry_00_first10", "none", False),
)
# A weight worse by a fifth, as a configuration: the gate must notice it.
WORSE_WEIGHT = "mapping.scan_to_map.sensor_sigma_m: 0.036\n"
JAM_END_X_M = 4.38  # lidar-only runs and GenZ-ICP agree on it


def faulty_frames(plain):
    """Late and jittering stamps, lost, repeated and dark frames, with healthy stretches between."""
    frames = list(plain)
    frames[60] = dataclasses.replace(frames[60], stamp_s=frames[60].stamp_s + 0.09)
    for k in range(80, 90, 2):
        frames[k] = dataclasses.replace(frames[k], stamp_s=frames[k].stamp_s + 0.06)
    for k in range(180, 185):
        frames[k] = dataclasses.replace(frames[k], scan=faulty.EMPTY, image=faulty.EMPTY)
    # From the end, so that the numbers above stay right.
    frames = frames[:290] + [frames[290]] + frames[290:]            # delivered twice
    frames = frames[:260] + frames[263:]                            # 3 lost, stamps right
    frames = frames[:220] + frames[222:]                            # 2 lost
    frames = frames[:120] + [frames[120]] + frames[120:]
    for k in (150, 151):
        frames[k] = dataclasses.replace(frames[k], scan=faulty.ABSENT, image=faulty.ABSENT)
    return frames


def run(tools, sequence, out, deskew, lidar_only=False):
    command = [tools.tvl, "run", sequence, "--out", out, "--deskew", deskew, "--no-loops",
               "--threads", "1", *tools.options, *(["--lidar-only"] if lidar_only else [])]
    result = subprocess.run(command, check=False, capture_output=True, text=True,
                            stdin=subprocess.DEVNULL)
    if result.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}: exit code {result.returncode}\n"
                           + result.stderr)
    for name in BULK:
        (out / name).unlink(missing_ok=True)
    return judge.read_run(out)


def thickness_figures(tools, sequence, out, deskew):
    said = subprocess.run([tools.thickness, sequence, out / "trajectory_kitti.txt", deskew],
                          check=True, capture_output=True, text=True).stdout
    measured = json.loads(said)
    return {"thickness_mm": measured["thickness_mm"],
            "planar_share": measured["planar_voxels"] / max(1, measured["filled_voxels"])}


def truth_figures(truth, result, T_cam0_lidar):
    """Against poses of the delivered frames."""
    verdict = judge.judge(truth, result)
    t_err, r_err = figures.kitti_errors(truth, result.poses)
    found = {"silent_errors": verdict.silent,
             "not_tracked": sum(s not in judge.CLAIMS for s in result.statuses[1:]),
             "end_m": verdict.end_m, **figures.step_figures(truth, result, T_cam0_lidar)}
    if not math.isnan(t_err):
        found |= {"t_err_pct": t_err, "r_err_deg_per_100m": r_err}
    return found


def make_drive(tools, drive, folder):
    """The drive with its faults, on the disk; its frames and their true poses."""
    original = folder / "original"
    if not (original / "meta.json").exists():  # written last
        subprocess.run([tools.tvl, "simulate", "--out", original, "--threads", "2",
                        *drive.arguments], check=True, capture_output=True, stdin=subprocess.DEVNULL)
    recording = faulty.open_recording(original)
    frames = faulty.plain(recording)
    if drive.faults:
        frames = faulty_frames(frames)
        if not (folder / "sequence").exists():
            faulty.write(recording, frames, folder / "sequence")
    truth = judge.reference_of(poses.read(original / "poses.txt"), frames)
    return (folder / "sequence" if drive.faults else original), truth


def drive_figures(tools, drive, folder, name="run"):
    """{scene: figures} of a drive with camera; the drive is written to `folder` if it is not there."""
    sequence, truth = make_drive(tools, drive, folder)
    out = folder / name
    result = run(tools, sequence, out, drive.deskew)
    found = truth_figures(truth, result, figures.read_T_cam0_lidar(sequence))
    if not drive.faults:
        found |= figures.evidence_figures(result)
        found |= thickness_figures(tools, sequence, out, drive.deskew)
    return {drive.name: found}


def recording_figures(tools, name, deskew, camera, folder):
    """{scene: figures} of a recording, lidar-only and with the camera."""
    sequence = tools.data / "sequences" / name
    scenes, ends = {}, []
    for lidar_only in (True, False)[:1 + camera]:
        scene = f"{name}/{deskew}/{'lidar' if lidar_only else 'camera'}"
        out = folder / scene.replace("/", "_")
        result = run(tools, sequence, out, deskew, lidar_only)
        found = {"not_tracked": sum(s not in judge.CLAIMS for s in result.statuses[1:]),
                 **thickness_figures(tools, sequence, out, deskew)}
        T_cam0_lidar = figures.read_T_cam0_lidar(sequence)
        ends.append(figures.to_lidar(result.poses, T_cam0_lidar)[-1])
        if name.endswith("_jam"):
            found["end_off_m"] = abs(ends[-1][3] - JAM_END_X_M)
        if name.endswith("_first16"):
            truth = poses.read(sequence / "poses.txt")
            found |= {"silent_errors": judge.judge(truth, result).silent,
                      "step_worst_m": judge.judge(truth, result).worst_m}
        scenes[scene] = found
    if camera:
        scenes[scene]["camera_moves_end_m"] = poses.distance_m(*ends)
    return scenes
