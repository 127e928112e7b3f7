"""The runs of benchmarks/ablation.py: options left out or changed, one at a time, over the same scans."""

import dataclasses
import json
import pathlib
import shutil

import numpy as np

from . import comparison, drives, machine, metrics, ours, scores, trials
from . import poses as se3

ROOT = pathlib.Path(__file__).resolve().parents[2]
PEERS = ("kiss", "genz")   # whose median end the recordings are compared with


# What is changed ----------------------------------------------------------------------------------
@dataclasses.dataclass(frozen=True)
class Variant:
    label: str
    overrides: tuple = ()        # (option, value) of docs/options.md
    file: str | None = None      # of config/
    needs_camera: bool = False   # without one nothing would be changed

    def config(self):
        """The text of --config; empty for the defaults."""
        if self.file is not None:
            return (ROOT / "config" / self.file).read_text()
        return "".join(f"{key}: {value}\n" for key, value in self.overrides)


NO_EDGES_M = 1000.0  # one standard deviation: what is weighted by its inverse square says nothing
VARIANTS = {
    "default": Variant("default"),
    "no-odometry": Variant("no scan-to-scan odometry", (("odometry.enabled", "false"),)),
    "no-odometry-full-prior": Variant(
        "no scan-to-scan odometry, prediction in full",
        (("odometry.enabled", "false"), ("mapping.scan_to_map.prior_share", "1.0"))),
    "odometry-laser": Variant("odometry without visual terms", (("odometry.use_camera", "false"),),
                              needs_camera=True),
    "no-landmarks": Variant("map step without landmarks",
                            (("mapping.scan_to_map.use_camera", "false"),), needs_camera=True),
    "no-edges": Variant("no edges", (("odometry.laser.edge_sigma_m", NO_EDGES_M),
                                     ("mapping.scan_to_map.edge_sigma_m", NO_EDGES_M))),
    "no-beam-calibration": Variant("no beam calibration", (("mapping.beams.enabled", "false"),)),
    "independent-points": Variant("points of a beam independent",
                                  (("mapping.scan_to_map.common_beam_sigma_deg", "0.0"),)),
    "given-extrinsics": Variant("extrinsics as given", (("extrinsics.enabled", "false"),),
                                needs_camera=True),
    "wide-beam-prior": Variant("beam errors of 3 times the size expected",
                               (("mapping.beams.prior_elevation_deg", "0.24"),
                                ("mapping.beams.prior_range_m", "0.09"))),
    "fine-source": Variant("one point each 0.5 m", (("mapping.scan_to_map.source_voxel_m", "0.5"),)),
    "coarse-source": Variant("one point each 2 m", (("mapping.scan_to_map.source_voxel_m", "2.0"),)),
    "paper": Variant("config/paper.yaml", file="paper.yaml"),
}


# What it is tried on ------------------------------------------------------------------------------
@dataclasses.dataclass(frozen=True)
class Scene:
    label: str
    source: str               # sim: input, or the name of a recording
    with_camera: bool
    trajectory: str | None = None   # of TVL_TEST_DATA/trajectories
    spin: str | None = None         # of a recording

    @property
    def is_simulated(self):
        return drives.is_simulated(self.source)


SCENES = {
    "city131": Scene("city, seed 131", "sim:city?seed=131&frames=250", True),
    "city132": Scene("city, seed 132", "sim:city?seed=132&frames=250", True),
    "route08": Scene("raw route 08, seed 141", "sim:city?seed=141&frames=400&raw=cw&camera=0", False,
                     trajectory="kitti_08.txt"),
    "beams-none": Scene("beams without errors",
                        "sim:city?seed=133&frames=400&camera=0&beam_errors=0", False),
    "beams-usual": Scene("usual beam errors", "sim:city?seed=133&frames=400&camera=0", False),
    "beams-three": Scene("3 times the usual", "sim:city?seed=133&frames=400&camera=0&beam_errors=3",
                         False),
    "beams-sine": Scene("a sine over the rings",
                        "sim:city?seed=133&frames=400&camera=0&beam_error_shape=sine", False),
    "kitti360": Scene("kitti360_3000", "kitti360_3000", True, spin="cw"),
    "kitti360-lidar": Scene("kitti360_3000, lidar-only", "kitti360_3000", False, spin="cw"),
    "0052": Scene("0052", "kitti_2011_09_26_0052", True, spin="cw"),
    "0052-lidar": Scene("0052, lidar-only", "kitti_2011_09_26_0052", False, spin="cw"),
    "0013": Scene("0013_first16, lidar-only", "kitti_2011_09_26_0013_first16", False, spin="cw"),
}


def uri_of(scene, data):
    if scene.trajectory is None:
        return scene.source
    return f"{scene.source}&trajectory={data / 'trajectories' / scene.trajectory}"


def scans_of(args, scene):
    """Writes a simulated drive if it is not there."""
    if not scene.is_simulated:
        return trials.scans_of(args.data / "sequences" / scene.source, scene.spin,
                               comparison.clouds.KITTI_CORRECTION_DEG, judge_map=True)
    uri = uri_of(scene, args.data)
    folder = args.out / "drives" / drives.name_of(uri)
    drives.write(args.binary, uri, folder, lidar_only=not scene.with_camera, threads=trials.THREADS)
    return trials.simulated(folder)


# Figures ------------------------------------------------------------------------------------------
def options_of(scene, scans, config_file):
    """Of tvl run."""
    options = ["--deskew", scans.spin or "none", "--threads", trials.THREADS, "--no-loops"]
    return options + ([] if scene.with_camera else ["--lidar-only"]) + (
        [] if config_file is None else ["--config", config_file])


def truth_of(scans):
    """Lidar truth at the middle of each sweep, None where there is none that is good enough."""
    if not (scans.folder / "poses.txt").exists() or scans.folder.name in comparison.SMOOTHED_TRUTH:
        return None
    truth_cam0 = se3.read_poses(scans.folder / "poses.txt")
    return scores.truth_at(se3.inverse(truth_cam0[:1]) @ truth_cam0,
                           se3.read_calibration(scans.folder), 0.5)


def figures_of(run, scans):
    """Of a finished run. cpu_ms: processor time a frame, reading included; unlike the time on the
    clock it hardly changes with what else the machine does."""
    frames = len(scans.files)
    statuses = [frame["status"] for frame in run.report["frames"]]
    stages = ours.stage_ms(run.report)
    figures = {"cpu_ms": 1e3 * run.cpu_s / frames, "ms_p50": float(np.median(ours.total_ms(run.report))),
               "stage_p50_ms": {name: stage["p50_ms"] for name, stage in stages.items()},
               "tracked": statuses.count("tracked"), "frames": frames,
               "end_xyz_m": run.T_world_lidar[-1][:3, 3].tolist()}
    truth = truth_of(scans)
    if truth is not None:
        figures |= scores.figures(truth, run.T_world_lidar, se3.read_calibration(scans.folder))
    if scans.judge_map:
        figures |= trials.map_figures(scans, run.T_world_lidar)
    return {k: None if isinstance(v, float) and np.isnan(v) else v for k, v in figures.items()}


def measure(args, scene, scans, variant, out):
    """Figures of one run, or what it failed with; --resume takes those made of the same things."""
    system = "ours" if scene.with_camera else "ours-lidar"
    key = trials.key_of(trials.Trial(scans, system, args.binary, out)) | {"config": variant.config()}
    path = out / "result.json"
    if args.resume and path.exists():
        result = json.loads(path.read_text())
        if result["key"] == key and "error" not in result:
            return result
    out.mkdir(parents=True, exist_ok=True)
    config_file = None
    if key["config"]:
        config_file = out / "config.yaml"
        config_file.write_text(key["config"])
    result = {"key": key}
    try:
        run = ours.run(args.binary, scans.folder, out / "run", *options_of(scene, scans, config_file))
        result["figures"] = figures_of(run, scans)
    except RuntimeError as error:
        result["error"] = str(error).splitlines()[-1].replace(str(scans.folder), scans.folder.name)
    shutil.rmtree(out / "run", ignore_errors=True)
    path.write_text(json.dumps(result, indent=1) + "\n")
    return result


def peers_median(args, scans):
    """Median of the ends of those peers that are installed, None without any."""
    ends = {}
    for system in PEERS:
        if machine.version({"kiss": "kiss-icp", "genz": "genz-icp"}[system]) is None:
            continue
        trial = trials.Trial(scans, system, args.binary,
                             args.out / "peers" / f"{scans.name}_{scans.spin}" / system)
        result = (trials.stored(trial) if args.resume else None) or trials.run(trial)
        if "error" not in result:
            poses = trials.trajectory_of(trial, result["rows"][system])
            ends[system] = trials.at_middle(scans, system, poses)
    return comparison.peers_median(ends)


def with_distances(runs, median):
    """Adds how far each end lies from the peers' median and from that of the defaults."""
    default = next((r["figures"]["end_xyz_m"] for r in runs
                    if r["variant"] == "default" and "figures" in r), None)
    for run in runs:
        for name, end in (("from_median_m", median), ("from_default_m", default)):
            if "figures" in run and end is not None:
                run["figures"][name] = float(np.linalg.norm(np.subtract(run["figures"]["end_xyz_m"], end)))
    return runs


def measure_scene(args, name, variants):
    scene = SCENES[name]
    scans, runs = scans_of(args, scene), []
    for variant in variants:
        if VARIANTS[variant].needs_camera and not scene.with_camera:
            continue
        result = measure(args, scene, scans, VARIANTS[variant], args.out / "runs" / name / variant)
        print(f"{name:<16} {variant:<24} {result.get('error', 'done')}", flush=True)
        runs.append({"variant": variant} | {k: v for k, v in result.items() if k != "key"})
    median = None if scene.is_simulated else peers_median(args, scans)
    truth = truth_of(scans)
    return {"scene": name, "label": scene.label, "source": scene.source, "camera": scene.with_camera,
            "simulated": scene.is_simulated, "frames": len(scans.files), "spin": scans.spin,
            "path_m": None if truth is None else float(metrics.path_m(truth)[-1]),
            "runs": with_distances(runs, median)}
