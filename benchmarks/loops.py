#!/usr/bin/env python3
"""Loop closing on simulated drives with exact truth: what was found, accepted, wrong and missed.

    loops.py DRIVE... --out DIR [--binary tvl] [--threads N] [--alone] [--lidar-only] [--skip-no-loops]

DRIVE is anything `tvl run` takes and knows the truth of: `sim:city?seed=4&frames=0&trajectory=POSES.txt`,
`sim:nightloop?seed=5&frames=700`, a KITTI folder with poses. Prints, per drive, the absolute trajectory
error (all frames, camera 0, aligned) of a run with --no-loops, of the odometry of the run with loops, and
with loops; accepted, dropped and false loops, their errors, how much larger the odometry's errors are, in
variance, than it says, the share of revisiting keyframes closed, precision and recall of each proposer, and
milliseconds a keyframe. The odometry of a run with loops is not what the odometry alone would do: once a
loop is accepted it sees the old place, too, in its local map. --skip-no-loops saves the run without.
--alone runs every drive four times: all proposers, and each one alone. How bad odometry may be:
loops_with_drift.cc.
"""

import argparse
import json
import pathlib

import yaml

from bench import ours

PROPOSERS = ("visual", "vicinity", "lidar")


def write_config(path, proposers):
    options = {f"use_{p}": p in proposers for p in PROPOSERS}
    path.write_text(yaml.safe_dump({"loops": options}))
    return path


def error_m(binary, folder, trajectory):
    out = folder / "evaluation.json"
    ours.execute(binary, "evaluate", "--truth", folder / "truth_kitti.txt", "--estimate",
                 folder / trajectory, "--json", out)
    return json.loads(out.read_text())["drives"][0]["ate_se3"]["rmse_m"]


def run(args, folder, drive, proposers, *extra):
    """The folder with the results of one run."""
    folder.mkdir(parents=True, exist_ok=True)
    config = write_config(folder / "config.yaml", proposers)
    if args.lidar_only:
        extra = (*extra, "--lidar-only")
    ours.execute(args.binary, "run", drive, "--out", folder, "--config", config, "--deskew", "none",
                 "--threads", args.threads, *extra)
    return folder


def counts(loops):
    """What was accepted, dropped and false, in one line."""
    truth = loops["against_truth"]
    return (f"{loops['proposals']} proposals, {truth['accepted']} accepted, {truth['false_accepted']} "
            f"of them false; {truth['dropped']} dropped in the end, {truth['false_dropped']} of them "
            f"false; odometry variance factor {loops['odometry_variance_factor']:.2f}")


def measure(args, number, drive, proposers, alone_m):
    """Runs a drive with loops and prints what there is to say. alone_m: error without, as text."""
    name = "all" if len(proposers) == len(PROPOSERS) else proposers[0]
    folder = run(args, args.out / f"{number}_{name}", drive, proposers)
    report = json.loads((folder / "run.json").read_text())
    loops = report["loops"]
    truth = loops["against_truth"]
    print(f"{drive}\n  proposers: {', '.join(proposers)}")
    print(f"  ATE {alone_m} with --no-loops, "
          f"{error_m(args.binary, folder, 'trajectory_kitti.txt'):.3f} m with loops, "
          f"{error_m(args.binary, folder, 'odometry_kitti.txt'):.3f} m of the odometry beside them; "
          f"peak memory {report['peak_memory_mib']:.0f} MiB")
    print(f"  {counts(loops)}")
    print(f"  closed {truth['closed_keyframes']} of {truth['revisit_keyframes']} revisiting "
          f"keyframes; error p95 {truth['error_p95_m']:.3f} m, {truth['error_p95_deg']:.3f} deg")
    for proposer in proposers:
        score = truth["by_proposer"][proposer]
        print(f"  {proposer:9s} {score['proposals']:5d} proposals, precision "
              f"{score['precision']:.3f}, recall {score['recall']:.3f}, {score['accepted']} accepted")
    for stage, ms in loops["timing_per_keyframe"].items():
        if isinstance(ms, dict):
            print(f"  {stage:17s} mean {ms['mean_ms']:6.2f}  p95 {ms['p95_ms']:7.2f}  "
                  f"max {ms['max_ms']:7.2f} ms a keyframe")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", nargs="+", metavar="DRIVE")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--alone", action="store_true")
    parser.add_argument("--lidar-only", action="store_true")
    parser.add_argument("--skip-no-loops", action="store_true")
    args = parser.parse_args()
    sets = [PROPOSERS] + ([(p,) for p in PROPOSERS] if args.alone else [])
    for number, drive in enumerate(args.drives):
        alone_m = "?"
        if not args.skip_no_loops:
            folder = run(args, args.out / f"{number}_no_loops", drive, PROPOSERS, "--no-loops")
            alone_m = f"{error_m(args.binary, folder, 'trajectory_kitti.txt'):.3f} m"
        for proposers in sets:
            measure(args, number, drive, proposers, alone_m)


if __name__ == "__main__":
    main()
