#!/usr/bin/env python3
"""Ours beside the peers on the real recordings, same point arrays, no truth needed.

    TVL_TEST_DATA=FOLDER compare_real.py --out DIR [--binary tvl]

For each sequence and variant: raw scans (our de-skewing off), and for raw recordings also the scans
as our motions de-skew them to the image instant: peers get those, we get the raw ones. Prints the
distance of each end point to the component-wise median of the peers, the RMS difference of
per-frame motions to each peer, map thickness and milliseconds a frame (one thread).
"""

import argparse
import os
import pathlib
import sys

import numpy as np

import peers as peer_runner
from bench import clouds, metrics, ours, registrars
from bench import poses as se3

RAW = ("kitti360_3000", "kitti_2011_09_26_0052")
SEQUENCES = RAW + ("kitti_odometry_00_first10",)
SPINS = ("cw", "ccw")


def variants(sequence, spins):
    """Our --deskew values to compare under."""
    return ("none",) + tuple(spins) if sequence in RAW else ("none",)


def scans_for(args, folder, deskew, work):
    """Folder of scans for the peers: as recorded, or de-skewed with our motions."""
    if deskew == "none":
        return folder
    run = ours.run(args.binary, folder, work / "for_deskewing", "--deskew", deskew, "--no-loops")
    scans = work / "scans"
    scans.mkdir(parents=True, exist_ok=True)
    steps = se3.motions(run.T_world_lidar)
    steps = np.concatenate([steps[:1], steps])  # the first frame moves as the second
    for file, step in zip(clouds.scan_files(folder), steps):
        points = clouds.deskew(clouds.read_scan(file), deskew, step)
        padded = np.column_stack([points, np.zeros(len(points))]).astype(np.float32)
        padded.tofile(scans / file.name)
    return scans


def has_images(folder):
    return any((folder / f"image_{i}").is_dir() for i in range(4))


def our_runs(args, folder, deskew, work):
    """name -> Run, with the camera where there is one and without."""
    options = ["--threads", 1, "--no-loops", "--deskew", deskew]
    runs = {}
    if has_images(folder):
        runs["ours"] = ours.run(args.binary, folder, work / "ours", *options)
    runs["ours, lidar-only"] = ours.run(args.binary, folder, work / "ours_lidar_only", *options,
                                        "--lidar-only")
    return runs


def print_comparison(rows, peer_names, files, correction_deg):
    """rows: name -> (poses, ms). Returns the median end point of the peers."""
    median = metrics.median_end([rows[n][0] for n in peer_names])
    print(peer_runner.HEADER + "   RMS of motions to " + ", ".join(peer_names) + " (mm / deg)")
    for name, (trajectory, ms) in rows.items():
        peer_runner.print_row(name, trajectory, ms,
                              metrics.thickness(files, trajectory, correction_deg), median,
                              end="   ")
        differences = [metrics.motion_difference(trajectory, rows[n][0]) for n in peer_names]
        print("  ".join(f"{1e3 * t:6.1f} / {r:.3f}" for t, r in differences))
    return median


def compare(args, sequence, deskew):
    """One table."""
    folder = args.data / "sequences" / sequence
    work = args.out / f"{sequence}_{deskew}"
    scans, correction_deg = scans_for(args, folder, deskew, work), clouds.KITTI_CORRECTION_DEG
    files = clouds.scan_files(scans)
    results = peer_runner.run_peers(list(registrars.PEERS), files, correction_deg)
    rows = {registrars.PEERS[k].name: v for k, v in results.items()}
    peer_names = list(rows)
    runs = our_runs(args, folder, deskew, work)
    rows.update({name: (r.T_world_lidar, ours.total_ms(r.report)) for name, r in runs.items()})
    print(f"\n{sequence}, {len(files)} frames, de-skewed: {deskew}")
    median = print_comparison(rows, peer_names, files, correction_deg)
    for name, run in runs.items():
        distance = np.linalg.norm(run.T_world_lidar[-1][:3, 3] - median)
        print(f"{name}: end point {distance:.3f} m from the peers' median; milliseconds a frame:")
        print_stages(run.report)


def print_stages(report):
    """Our milliseconds by stage (one thread)."""
    for stage, ms in ours.stage_ms(report).items():
        print(f"    {stage:<16} p50 {ms['p50_ms']:6.1f}  p95 {ms['p95_ms']:6.1f}  mean {ms['mean_ms']:6.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("TVL_TEST_DATA"))
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    parser.add_argument("--sequences", default=",".join(SEQUENCES))
    parser.add_argument("--spins", default="cw", help="de-skewing directions to compare under")
    args = parser.parse_args()
    if args.data is None:
        parser.error("set TVL_TEST_DATA or --data")
    args.data = pathlib.Path(args.data)
    peer_runner.limit_cores(1)
    spins = [s for s in args.spins.split(",") if s]
    for sequence in args.sequences.split(","):
        for deskew in variants(sequence, spins):
            compare(args, sequence, deskew)
    return 0


if __name__ == "__main__":
    sys.exit(main())
