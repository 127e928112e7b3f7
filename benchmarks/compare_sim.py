#!/usr/bin/env python3
"""Ours beside KISS-ICP and GenZ-ICP on simulated drives with exact truth.

    compare_sim.py DRIVE... --out DIR [--binary tvl]

DRIVE: folders written by `tvl simulate`. Prints t_err (%), r_err (deg/100 m) and ATE (m) for ours
lidar-only and with camera (no loops) and for the peers, with and without the 0.205 deg correction.
On raw drives (meta.json: raw cw or ccw) the peers de-skew by themselves. KISS-ICP 1.2.3 and later
moves points to the END of the sweep, truth belongs to its middle: its poses are compared with the
truth half a frame later, interpolated. The instant of each peer is asked of the peer, not assumed.
"""

import argparse
import pathlib
import re
import sys

import numpy as np

import peers as peer_runner
from bench import clouds, drives, metrics, ours, poses, registrars

KITTI_PROFILE = pathlib.Path(__file__).resolve().parent.parent / "config/profiles/kitti.yaml"


def truth_at(truth_cam0, T_cam0_lidar, key, spin):
    """Lidar truth at the instant the poses of `key` belong to."""
    truth = poses.to_lidar(truth_cam0, T_cam0_lidar)
    if spin is None or key == "ours":
        return truth
    return poses.shifted(truth, registrars.deskew_reference(registrars.PEERS[key]) - 0.5)


def score(truth_lidar, estimate_lidar, T_cam0_lidar):
    """(t_err %, r_err deg/100 m, ATE m) in the camera frame, as KITTI does."""
    truth = poses.to_camera(truth_lidar, T_cam0_lidar)
    estimate = poses.to_camera(estimate_lidar, T_cam0_lidar)
    return (*metrics.kitti_errors(truth, estimate), metrics.ate_m(truth, estimate))


def our_rows(args, drive, spin, truth, T_cam0_lidar, work):
    rows = {}
    deskew = ["--deskew", spin or "none", "--no-loops"]
    for corrected in (True, False):
        profile = [] if corrected else ["--profile", write_uncorrected(work)]
        for name, options in (("lidar-only", ["--lidar-only"]), ("with camera", [])):
            label = f"ours {name}" + ("" if corrected else ", no correction")
            run = ours.run(args.binary, drive, work / label.replace(" ", "_"),
                           *deskew, *options, *profile)
            rows[label] = score(truth, run.T_world_lidar, T_cam0_lidar)
    return rows


def write_uncorrected(work):
    """The kitti profile without its vertical correction."""
    lines = KITTI_PROFILE.read_text().splitlines()
    lines = [re.sub(r"(vertical_correction_deg:).*", r"\1 0.0", line) for line in lines]
    work.mkdir(parents=True, exist_ok=True)
    path = work / "uncorrected.yaml"
    path.write_text("\n".join(lines) + "\n")
    return path


def peer_rows(args, files, spin, truth_of, T_cam0_lidar):
    rows = {}
    for corrected in (True, False):
        correction_deg = clouds.KITTI_CORRECTION_DEG if corrected else 0.0
        for key in ("kiss", "genz"):
            trajectory, _ = peer_runner.run_peer(key, files, correction_deg, args.threads, spin)
            label = registrars.PEERS[key].name + ("" if corrected else ", no correction")
            rows[label] = score(truth_of(key), trajectory, T_cam0_lidar)
    return rows


def compare(args, drive):
    """label -> scores of one drive."""
    T_cam0_lidar = poses.read_calibration(drive)
    truth_cam0 = poses.read_poses(drive / "poses.txt")[: args.frames]
    files = clouds.scan_files(drive)[: args.frames]
    spin = drives.spin_of(drive)

    def truth_of(key):
        return truth_at(truth_cam0, T_cam0_lidar, key, spin)

    rows = peer_rows(args, files, spin, truth_of, T_cam0_lidar)
    if not args.peers_only:
        rows.update(our_rows(args, drive, spin, truth_of("ours"), T_cam0_lidar,
                             args.out / drive.name))
    print(f"\n{drive.name}: {len(files)} frames, {metrics.path_m(truth_cam0)[-1]:.0f} m, "
          f"{'raw ' + spin if spin else 'compensated'}")
    print_table(rows)
    return rows


def print_table(rows):
    print(f"{'':<36} {'t_err %':>8} {'r_err deg/100m':>15} {'ATE m':>8}")
    for label, (t_err, r_err, ate) in rows.items():
        print(f"{label:<36} {t_err:8.3f} {r_err:15.4f} {ate:8.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", nargs="+", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--frames", type=int, default=None)
    parser.add_argument("--peers-only", action="store_true")
    args = parser.parse_args()
    peer_runner.limit_cores(args.threads)
    tables = [compare(args, drive) for drive in args.drives]
    if len(tables) > 1:
        print(f"\nmean of {len(tables)} drives")
        print_table({label: np.mean([t[label] for t in tables], axis=0) for label in tables[0]})
    return 0


if __name__ == "__main__":
    sys.exit(main())
