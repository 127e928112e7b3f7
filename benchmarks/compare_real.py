#!/usr/bin/env python3
"""Ours beside the peers on the real recordings, same point arrays, no truth needed.

    TVL_TEST_DATA=FOLDER compare_real.py --out DIR [--binary tvl]

For each sequence and variant: raw scans (our de-skewing off), and for raw recordings also the scans
as we de-skew them to the image instant, which tvl exports and the peers then get. Prints the
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

RAW = ("kitti360_3000", "kitti_2011_09_26_0052")
SEQUENCES = RAW + ("kitti_odometry_00_first10",)
SPINS = ("cw", "ccw")


def variants(sequence, spins):
    """Our --deskew values to compare under."""
    return ("none",) + tuple(spins) if sequence in RAW else ("none",)


def scans_for(args, folder, deskew, work):
    """(folder of scans for the peers, correction they still need)."""
    if deskew == "none":
        return folder, clouds.KITTI_CORRECTION_DEG
    exported = work / "scans"
    ours.execute(args.binary, "run", folder, "--out", work / "export", "--deskew", deskew,
                 "--no-loops", args.export_option, exported)
    return exported, 0.0 if args.exported_corrected else clouds.KITTI_CORRECTION_DEG


def compare(args, sequence, deskew):
    """One table."""
    folder = args.data / "sequences" / sequence
    work = args.out / f"{sequence}_{deskew}"
    scans, correction_deg = scans_for(args, folder, deskew, work)
    files = clouds.scan_files(scans)
    results = peer_runner.run_peers(list(registrars.PEERS), files, correction_deg)
    own = {"ours": ["--deskew", deskew], "ours, lidar-only": ["--deskew", deskew, "--lidar-only"]}
    rows = {registrars.PEERS[k].name: v for k, v in results.items()}
    peer_names = list(rows)
    median = metrics.median_end([rows[n][0] for n in peer_names])
    for name, options in own.items():
        if "lidar" not in name and not any((folder / f"image_{i}").is_dir() for i in range(4)):
            continue
        run = ours.run(args.binary, folder, work / name.replace(", ", "_"), "--threads", 1, *options)
        rows[name] = (run.T_world_lidar, total_ms(run.report))
    print(f"\n{sequence}, {len(files)} frames, de-skewed: {deskew}")
    print(peer_runner.HEADER + "   RMS of motions to " + ", ".join(peer_names) + " (mm / deg)")
    for name, (trajectory, ms) in rows.items():
        peer_runner.print_row(name, trajectory, ms,
                              metrics.thickness(files, trajectory, correction_deg), median,
                              end="   ")
        differences = [metrics.motion_difference(trajectory, rows[n][0]) for n in peer_names]
        print("  ".join(f"{1e3 * t:6.1f} / {r:.3f}" for t, r in differences))
    return np.linalg.norm(rows.get("ours", rows["ours, lidar-only"])[0][-1][:3, 3] - median)


def total_ms(report):
    """Milliseconds of each frame if run.json has them, else its percentiles as a small sample."""
    frames = [f["total_ms"] for f in report.get("frames", ())
              if isinstance(f, dict) and "total_ms" in f]
    if frames:
        return np.array(frames)
    total = ours.stage_ms(report).get("total", {})
    return np.array([total.get("p50", np.nan)] * 9 + [total.get("p95", np.nan)])


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("TVL_TEST_DATA"))
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    parser.add_argument("--sequences", default=",".join(SEQUENCES))
    parser.add_argument("--spins", default="cw", help="de-skewing directions to compare under")
    parser.add_argument("--export-option", default="--export-scans")
    parser.add_argument("--exported-corrected", action="store_true",
                        help="the exported scans already carry the vertical correction")
    args = parser.parse_args()
    if args.data is None:
        parser.error("set TVL_TEST_DATA or --data")
    args.data = pathlib.Path(args.data)
    peer_runner.limit_cores(1)
    spins = [s for s in args.spins.split(",") if s]
    for sequence in args.sequences.split(","):
        for deskew in variants(sequence, spins):
            distance = compare(args, sequence, deskew)
            print(f"-> our end point is {distance:.3f} m from the peers' median")
    return 0


if __name__ == "__main__":
    sys.exit(main())
