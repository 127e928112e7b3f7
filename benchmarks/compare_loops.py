#!/usr/bin/env python3
"""Ours beside KISS-SLAM, both closing loops, on drives with truth.

    compare_loops.py DRIVE... --out DIR [--binary tvl] [--threads N] [--lidar-only] [--keep]

DRIVE: `sim:city?seed=4&frames=0&trajectory=POSES.txt`, written to DIR by `tvl simulate` and removed
again unless --keep is given, or a KITTI folder with poses.txt. Same points for both, same cores, reading
not counted in ms a frame. Columns:

  ATE      all frames, camera 0, aligned (m); t_err in % as KITTI has it
  loops    accepted, and of them false (off by more than 1 m or 5 degrees); p95 of their errors
  closed   what sees a place again (within 10 m, > 30 s and > 50 m of path later) and has a right loop,
           of all that do: keyframes of ours, local maps of 100 m of KISS-SLAM. A keyframe and a map are
           not the same thing; its loops are compared with truth where the two maps come nearest. By
           design it never compares a map with the three before it: no loops within some 300 m of path
  ms       wall time a frame: mean, p95, worst. KISS-SLAM searches in line; ours beside the odometry from
           two threads on, in line with one
  cpu      processor time a frame, of all threads; ours with reading scans and writing maps and pictures
  end      seconds after the last frame (KISS-SLAM: last map and final optimisation; ours: the second
           look at the end and the polish)
  MiB      peak memory; in brackets what is taken before the first scan (Python and its libraries)
"""

import argparse
import dataclasses
import json
import pathlib
import shutil
import sys

import numpy as np

import peers as peer_runner
from bench import closures, drives, kiss_slam, metrics, ours, poses, registrars, scores


@dataclasses.dataclass(frozen=True)
class Row:
    label: str
    t_err: float
    ate_m: float
    ms: np.ndarray | None = None      # of each frame
    cpu_ms: float = float("nan")      # a frame
    end_s: float = float("nan")
    memory_mib: float = float("nan")
    loaded_mib: float = float("nan")
    loops: closures.Score | None = None


def errors(drive, truth_lidar, T_world_lidar):
    found = scores.figures(truth_lidar, T_world_lidar, drive.T_cam0_lidar)
    return found["t_err_pct"], found["ate_m"]


def our_loops(report):
    """Score of run.json's loops, None without loops."""
    truth = report.get("loops", {}).get("against_truth")
    if truth is None:
        return None
    p95 = [truth[k] if truth["accepted"] > 0 else np.nan for k in ("error_p95_m", "error_p95_deg")]
    return closures.Score(truth["accepted"], truth["false_accepted"], *p95,
                          truth["revisit_keyframes"], truth["closed_keyframes"])


def our_end_s(report):
    timing = report.get("loops", {}).get("timing_per_keyframe", {})
    return 1e-3 * (timing.get("second_look_ms", np.nan) + timing.get("polish_ms", np.nan))


def our_rows(args, drive):
    truth = poses.to_lidar(drive.truth_cam0, drive.T_cam0_lidar)
    sensors = [("lidar-only", ["--lidar-only"])]
    if drive.has_camera and not args.lidar_only:
        sensors.append(("with camera", []))
    rows = []
    for sensor, sensor_options in sensors:
        for loops, loop_options in (("", []), (", no loops", ["--no-loops"])):
            label = f"ours {sensor}{loops}"
            run = ours.run(args.binary, drive.folder, args.out / f"{drive.name}_runs" / label,
                           "--deskew", drive.spin or "none", "--threads", args.threads,
                           *sensor_options, *loop_options)
            rows.append(Row(label, *errors(drive, truth, run.T_world_lidar),
                            ours.total_ms(run.report), 1e3 * run.cpu_s / len(drive.files),
                            our_end_s(run.report), run.report["peak_memory_mib"],
                            loops=our_loops(run.report)))
    return rows


def kiss_rows(args, drive):
    result = kiss_slam.run(drive.files, drive.correction_deg, args.threads, drive.spin)
    truth = scores.truth_at(drive.truth_cam0, drive.T_cam0_lidar,
                            registrars.pose_instants("kiss-slam", drive.spin, len(drive.files)))
    scored = closures.score(truth, result.stretches, result.closures)
    return [Row("KISS-SLAM", *errors(drive, truth, result.T_world_lidar), result.ms, result.cpu_ms,
                result.end_s, result.memory_mib, result.loaded_mib, scored),
            Row("KISS-SLAM, no loops", *errors(drive, truth, result.T_odom_lidar))]


HEADER = (f"{'':<26} {'ATE m':>7} {'t_err %':>8} {'loops':>6} {'false':>6} {'p95 m':>7} "
          f"{'p95 deg':>8} {'closed':>10} {'ms mean':>8} {'p95':>7} {'worst':>7} {'cpu ms':>7} "
          f"{'end s':>6} {'MiB':>12}")


def number(value, width, digits=0):
    return f"{'-' if np.isnan(value) else f'{value:.{digits}f}':>{width}}"


def text(row):
    """One line below HEADER."""
    if row.loops is None:
        loops = f"{'-':>6} {'-':>6} {'-':>7} {'-':>8} {'-':>10}"
    else:
        s = row.loops
        loops = (f"{s.accepted:6d} {s.false:6d} {number(s.error_p95_m, 7, 3)} "
                 f"{number(s.error_p95_deg, 8, 3)} {f'{s.closed}/{s.revisits}':>10}")
    ms = [np.nan] * 3 if row.ms is None else [row.ms.mean(), np.percentile(row.ms, 95), row.ms.max()]
    times = f"{number(ms[0], 8, 1)} {number(ms[1], 7, 1)} {number(ms[2], 7)}"
    memory = "-" if np.isnan(row.memory_mib) else f"{row.memory_mib:.0f}"
    loaded = "" if np.isnan(row.loaded_mib) else f" ({row.loaded_mib:.0f})"
    return (f"{row.label:<26} {row.ate_m:7.3f} {row.t_err:8.3f} {loops} {times} "
            f"{number(row.cpu_ms, 7, 1)} {number(row.end_s, 6, 2)} {memory + loaded:>12}")


def as_json(value):
    """Rows as JSON has them; what was not measured is null."""
    if isinstance(value, dict):
        return {key: as_json(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return None if isinstance(value, float) and np.isnan(value) else value


def compare(args, spec):
    name = drives.name_of(spec) + ("_lidar" if args.lidar_only else "")
    simulated = args.out / name if drives.is_simulated(spec) else None
    folder = pathlib.Path(spec)
    if simulated is not None:
        folder = drives.write(args.binary, spec, simulated, args.lidar_only, args.threads)
    drive = drives.load(name, folder)
    print(f"\n{name}: {len(drive.files)} frames, {metrics.path_m(drive.truth_cam0)[-1]:.0f} m, "
          f"{'raw ' + drive.spin if drive.spin else 'compensated'}, {args.threads} threads\n{HEADER}")
    rows = []
    for system in ([] if args.ours_only else [kiss_rows]) + [our_rows]:
        for row in system(args, drive):
            print(text(row), flush=True)
            rows.append(row)
    results = args.out / f"{name}_{args.threads}.json"
    results.write_text(json.dumps([as_json(dataclasses.asdict(row)) for row in rows], indent=1) + "\n")
    if simulated is not None and not args.keep:
        shutil.rmtree(simulated)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", nargs="+", metavar="DRIVE")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--lidar-only", action="store_true", help="simulate and run without camera")
    parser.add_argument("--ours-only", action="store_true")
    parser.add_argument("--keep", action="store_true", help="keep simulated scans")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    peer_runner.limit_cores(args.threads)
    print(f"KISS-SLAM {kiss_slam.version()}" if not args.ours_only else "")
    for spec in args.drives:
        compare(args, spec)
    return 0


if __name__ == "__main__":
    sys.exit(main())
