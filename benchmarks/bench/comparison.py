"""The runs of benchmarks/accuracy: which drives, which recordings, which figures."""

import concurrent.futures
import dataclasses
import math
import multiprocessing
import os
import sys

import numpy as np

from . import accuracy_tables, clouds, drives, metrics, poses, registrars, scores, trials


@dataclasses.dataclass(frozen=True)
class Kind:
    label: str
    query: str
    preset: str = "city"
    trajectory: str | None = None   # of TVL_TEST_DATA/trajectories


KINDS = {
    "city": Kind("simulated city, compensated scans", ""),
    "cityraw": Kind("simulated city, raw scans, clockwise, each system de-skews", "&raw=cw"),
    "route06": Kind("the vehicle's way on KITTI 06 through the simulated city", "",
                    trajectory="kitti_06.txt"),
    "highway": Kind("simulated highway, little upright beside it", "", preset="highway"),
    "country": Kind("simulated open country", "", preset="open"),
    "traffic": Kind("simulated city with dense traffic", "", preset="traffic"),
}
DEFAULT_KINDS = ("city", "cityraw", "route06", "highway")
ALWAYS_RAW = ("kitti360_3000", "kitti_2011_09_26_0052", "kitti_2011_09_26_0052_jam",
              "kitti_2011_09_26_0013_first16")   # without a meta.json nothing else says so
NO_CORRECTION = ("hdl32_unordered",)             # not the lidar that the correction is for
SMOOTHED_TRUTH = ("kitti_odometry_00_first10",)  # not good enough over its first frames
QUICK_RECORDING_FRAMES = 16


# Runs -------------------------------------------------------------------------------------------
def pin(cores):
    """Each worker has a core of its own: some peers use every one they see."""
    os.sched_setaffinity(0, {cores.get()})


def make_pool(jobs):
    context = multiprocessing.get_context("spawn")
    cores = context.Queue()
    available = sorted(os.sched_getaffinity(0))
    if jobs > len(available):
        sys.exit(f"error: --jobs: there are {len(available)} cores")
    for core in available[:jobs]:
        cores.put(core)
    return concurrent.futures.ProcessPoolExecutor(jobs, context, initializer=pin, initargs=(cores,))


def run_all(args, pool, scans, systems):
    """system -> (trial, result), in the order asked for."""
    done, running = {}, {}
    for system in dict.fromkeys(trials.SECOND_OF.get(s, s) for s in systems):
        if trials.SYSTEMS[system].needs_camera and not scans.has_camera:
            continue
        trial = trials.Trial(scans, system, args.binary.resolve(),
                             args.out / "runs" / scans.name / system)
        result = trials.stored(trial) if args.resume else None
        if result is None:
            running[pool.submit(trials.run, trial)] = trial
        else:
            done[system] = (trial, result)
    for future in concurrent.futures.as_completed(running):
        trial = running[future]
        done[trial.system] = (trial, future.result())
        said = done[trial.system][1].get("error", "done")
        print(f"{scans.name:<44} {trials.SYSTEMS[trial.system].label:<24} {said}", flush=True)
    return done


def deskewing_instants():
    """Where in the sweep (0..1) each system moves the points of raw scans to; asked of the packages."""
    found = {"ours": 0.5}
    for key, peer in registrars.PEERS.items():
        if hasattr(peer, "deskewed"):
            found[key] = registrars.deskew_reference(peer)
    return found | {"kiss-slam": found["kiss"]}


def rows_of(done, systems):
    """(system, trial, row or None, error or None) for each row of the tables."""
    for system in systems:
        if trials.SECOND_OF.get(system, system) in done:
            trial, result = done[trials.SECOND_OF.get(system, system)]
            yield system, trial, result["rows"].get(system), result.get("error")


def with_time(figures, row):
    """Adds the median time of a frame; numbers that do not exist become null."""
    figures["ms_p50"] = None if row["ms"] is None else float(np.median(row["ms"]))
    return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in figures.items()}


# Simulated drives -------------------------------------------------------------------------------
def uri_of(args, kind, seed):
    uri = f"sim:{kind.preset}?seed={seed}&frames={args.frames}{kind.query}"
    return uri + (f"&trajectory={args.data / 'trajectories' / kind.trajectory}" if kind.trajectory else "")


def drive_runs(args, pool, kind, seed, systems):
    """(runs, frames, path in m, de-skewing) of one drive."""
    uri = uri_of(args, kind, seed)
    folder = args.out / "drives" / drives.name_of(uri)
    drives.write(args.binary, uri, folder, lidar_only=False, threads=os.cpu_count())
    scans = trials.simulated(folder)
    truth_cam0, T_cam0_lidar = poses.read_poses(folder / "poses.txt"), poses.read_calibration(folder)
    runs = []
    for system, trial, row, error in rows_of(run_all(args, pool, scans, systems), systems):
        run = {"seed": seed, "system": system}
        if error is None:
            truth = scores.truth_at(truth_cam0, T_cam0_lidar, trials.instants_of(scans, system))
            run["figures"] = with_time(
                scores.figures(truth, trials.trajectory_of(trial, row), T_cam0_lidar), row)
        else:
            run["error"] = error
        runs.append(run)
    return runs, len(scans.files), float(metrics.path_m(truth_cam0)[-1]), scans.spin


def measure_kind(args, pool, name, systems):
    kind, runs, lengths = KINDS[name], [], []
    for seed in args.seeds:
        found, frames, path_m, spin = drive_runs(args, pool, kind, seed, systems)
        runs, lengths = runs + found, lengths + [path_m]
    return {"kind": name, "label": kind.label, "preset": kind.preset, "trajectory": kind.trajectory,
            "seeds": args.seeds, "frames": frames, "path_m": lengths, "spin": spin, "runs": runs,
            "summary": accuracy_tables.summary(runs)}


def measure_drives(args, pool, systems):
    found = []
    for name in args.drives:
        trajectory = KINDS[name].trajectory
        if trajectory and (args.data is None or not (args.data / "trajectories" / trajectory).exists()):
            print(f"notice: {name} is left out: no trajectories/{trajectory}, set TVL_TEST_DATA")
            continue
        found.append(measure_kind(args, pool, name, systems))
    return found


# Real recordings --------------------------------------------------------------------------------
def peers_median(trajectories):
    """Median end point of the peers' odometry; KISS-SLAM's is that of KISS-ICP and would count twice."""
    ends = [t for system, t in trajectories.items() if system in ("kiss", "genz", "gicp")]
    return metrics.median_end(ends) if ends else None


def recording_figures(folder, trajectory, median, row):
    """Of one run, the poses at the middle of the sweep."""
    figures = {"end_xyz_m": trajectory[-1][:3, 3].tolist(), "from_median_m": None}
    if median is not None:
        figures["from_median_m"] = float(np.linalg.norm(trajectory[-1][:3, 3] - median))
    if (folder / "poses.txt").exists() and folder.name not in SMOOTHED_TRUTH:
        T_cam0_lidar = poses.read_calibration(folder)
        truth_cam0 = poses.read_poses(folder / "poses.txt")
        truth = scores.truth_at(poses.inverse(truth_cam0[:1]) @ truth_cam0, T_cam0_lidar, 0.5)
        figures |= scores.figures(truth, trajectory, T_cam0_lidar)
    return with_time(figures | row["map"], row)


def measure_recording(args, pool, folder, spin, systems):
    correction_deg = 0.0 if folder.name in NO_CORRECTION else clouds.KITTI_CORRECTION_DEG
    scans = trials.scans_of(folder, spin, correction_deg, True, f"{folder.name}_{spin or 'none'}")
    rows = list(rows_of(run_all(args, pool, scans, systems), systems))
    trajectories = {system: trials.at_middle(scans, system, trials.trajectory_of(trial, row))
                    for system, trial, row, error in rows if error is None}
    median, runs = peers_median(trajectories), []
    for system, _, row, error in rows:
        run = {"system": system}
        runs.append(run | ({"error": error} if error else {"figures": recording_figures(
            folder, trajectories[system], median, row)}))
    return {"name": folder.name, "frames": len(scans.files), "spin": spin, "runs": runs}


def chosen_recordings(args):
    if args.recordings is not None:
        return [args.data / "sequences" / name for name in args.recordings.split(",")]
    folders = sorted(p for p in (args.data / "sequences").iterdir() if (p / "velodyne").is_dir())
    return [f for f in folders
            if not args.quick or len(clouds.scan_files(f)) <= QUICK_RECORDING_FRAMES]


def measure_recordings(args, pool, systems):
    if args.recordings == "":
        return []
    if args.data is None:
        print("notice: real recordings are left out: set TVL_TEST_DATA")
        return []
    return [measure_recording(args, pool, folder, spin, systems) for folder in chosen_recordings(args)
            for spin in ((None, "cw") if folder.name in ALWAYS_RAW else (None,))]
