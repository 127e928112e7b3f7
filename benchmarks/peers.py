#!/usr/bin/env python3
"""Runs peers over a folder of scans, frame by frame, and measures what they return.

    peers.py SCANS --out DIR [--peers kiss,genz,gicp] [--no-correction] [--spin cw|ccw]

SCANS: a folder of .bin files (KITTI layout) or a sequence folder. The peers get exactly these
points, with their own de-skewing off unless --spin is given. Writes DIR/PEER.txt (lidar poses, 3x4
a line) and DIR/peers.json.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np

from bench import clouds, kiss_slam, metrics, poses, registrars


def limit_cores(threads):
    """Some peers use every core they see; the process sees only this many."""
    cores = sorted(os.sched_getaffinity(0))[:threads]
    os.sched_setaffinity(0, set(cores))


def run_peers(keys, files, correction_deg, threads=1, spin=None):
    """key -> (poses, ms a frame); peers that cannot de-skew are left out when spin is given."""
    keys = [k for k in keys if spin is None or k != "gicp"]
    return {key: registrars.run_peer(key, files, correction_deg, threads, spin) for key in keys}


def print_row(name, trajectory, ms, thick, median, end="\n"):
    last = trajectory[-1][:3, 3]
    away = np.linalg.norm(last - median)
    print(f"{name:<22} {last[0]:9.3f} {last[1]:8.3f} {last[2]:8.3f} {away:9.3f} "
          f"{1e3 * thick.mean_m:9.1f} {1e3 * thick.median_m:7.1f} {thick.planar_voxels:7d} "
          f"{np.median(ms):8.1f} {np.percentile(ms, 95):7.1f}", end=end)


HEADER = (f"{'':<22} {'end x':>9} {'y':>8} {'z (m)':>8} {'to median':>9} "
          f"{'thick mm':>9} {'median':>7} {'voxels':>7} {'ms p50':>8} {'p95':>7}")


def parse():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", nargs="?")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--peers", default="kiss,genz,gicp")
    parser.add_argument("--no-correction", action="store_true",
                        help="leave out the 0.205 deg vertical correction")
    parser.add_argument("--spin", choices=("cw", "ccw"), help="let the peers de-skew by themselves")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--frames", type=int, default=None)
    parser.add_argument("--list", action="store_true", help="print versions and de-skewing instants")
    args = parser.parse_args()
    if not args.list and (args.scans is None or args.out is None):
        parser.error("SCANS and --out are needed")
    return args


def list_peers():
    for peer in registrars.PEERS.values():
        instant = (f"de-skews to {registrars.deskew_reference(peer):.2f} of the sweep"
                   if hasattr(peer, "deskewed") else "no de-skewing of its own")
        print(f"{peer.name:<12} {registrars.version(peer):<8} {instant}")
    kiss_slam.KissSlam(threads=1, deskew=False)  # its libraries are many: do they load?
    print(f"{'KISS-SLAM':<12} {kiss_slam.version():<8} for compare_loops.py and accuracy; de-skews as KISS-ICP")


def main():
    args = parse()
    if args.list:
        list_peers()
        return 0
    limit_cores(args.threads)
    files = clouds.scan_files(args.scans)[: args.frames]
    correction_deg = 0.0 if args.no_correction else clouds.KITTI_CORRECTION_DEG
    results = run_peers(args.peers.split(","), files, correction_deg, args.threads, args.spin)
    median = metrics.median_end([t for t, _ in results.values()])
    print(HEADER)
    summary = {}
    for key, (trajectory, ms) in results.items():
        thick = metrics.thickness(files, trajectory, correction_deg)
        print_row(registrars.PEERS[key].name, trajectory, ms, thick, median)
        poses.write_poses(args.out / f"{key}.txt", trajectory)
        summary[key] = {"version": registrars.version(registrars.PEERS[key]),
                        "end_m": trajectory[-1][:3, 3].tolist(), "ms": ms.tolist(),
                        "thickness_m": thick.mean_m, "planar_voxels": thick.planar_voxels}
    (args.out / "peers.json").write_text(json.dumps(summary, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
