#!/usr/bin/env python3
"""The real recordings with and without the camera, under each answer to the de-skewing question.

    TVL_TEST_DATA=FOLDER real_recordings.py --out DIR [--binary tvl] [--peers kiss,genz]

One line a run: end point and length of the path, distance of the end points with and without the
camera (also as a share of the path), worst and rms step error against poses.txt where there is one
(camera 0), map thickness (scans de-skewed by the run's own motions), frames by status, and what the
run costs. Peers get the same scans as recorded, without de-skewing. Expected: the end of ..._0052_jam
lies at x = 4.38 m, as lidar-only runs and GenZ-ICP agree. Exit code 1 if a limit is broken: jam
within 0.05 m, the camera changes the end by no more than 2 % of the path, nor thickens the map or
worsens the rms step error by more than 2 %.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np

from bench import clouds, drives, metrics, ours, registrars
from bench import poses as se3

RECORDINGS = {  # name -> answers to the de-skewing question worth trying
    "kitti360_3000": ("none", "cw", "ccw"),
    "kitti_2011_09_26_0052": ("none", "cw", "ccw"),
    "kitti_2011_09_26_0052_jam": ("none", "cw", "ccw"),
    "kitti_2011_09_26_0013_first16": ("none", "cw", "ccw"),
    "kitti_odometry_00_first10": ("none",),
    "hdl32_unordered": ("none",),
}
EXPECTED_X_M = {"kitti_2011_09_26_0052_jam": (4.38, 0.05)}
MAX_SHARE = 0.02  # of the path, by which the camera may move the end
MAX_WORSE = 1.02  # factor by which it may thicken the map, or worsen the steps


def thickness(files, trajectory, spin):
    """Of the map; raw scans are de-skewed by the motions of the trajectory."""
    return metrics.thickness(files, trajectory, clouds.KITTI_CORRECTION_DEG,
                             None if spin == "none" else spin)


def step_errors_m(folder, T_world_cam0):
    """Of each step against poses.txt; None without it."""
    if not (folder / "poses.txt").exists():
        return None
    truth = se3.read_poses(folder / "poses.txt")
    difference = se3.inverse(se3.motions(truth)) @ se3.motions(T_world_cam0)
    return np.linalg.norm(difference[:, :3, 3], axis=1)


def our_row(args, folder, spin, camera):
    """One run as a dict; of a refused input only its message."""
    row = {"recording": folder.name, "deskew": spin, "system": "ours, camera" if camera else "ours, lidar"}
    out = args.out / f"{folder.name}_{spin}_{'camera' if camera else 'lidar'}"
    options = ["--deskew", spin, "--no-loops", "--threads", 1] + ([] if camera else ["--lidar-only"])
    try:
        run = ours.run(args.binary, folder, out, *options)
    except RuntimeError as error:
        return row | {"error": str(error).splitlines()[-1]}
    T_cam0_lidar = se3.read_calibration(folder)
    errors = step_errors_m(folder, se3.to_camera(run.T_world_lidar, T_cam0_lidar))
    thick = thickness(clouds.scan_files(folder), run.T_world_lidar, spin)
    statuses = [frame["status"] for frame in run.report["frames"]]
    return row | pose_figures(run.T_world_lidar, errors, thick) | {
        "statuses": {s: statuses.count(s) for s in sorted(set(statuses))},
        "ms": float(np.median(ours.total_ms(run.report)))}


def pose_figures(trajectory, errors, thick):
    return {"end_m": trajectory[-1][:3, 3].tolist(), "path_m": float(metrics.path_m(trajectory)[-1]),
            "step_worst_m": None if errors is None else float(errors.max()),
            "step_rms_m": None if errors is None else float(np.sqrt(np.mean(errors**2))),
            "thickness_mm": 1e3 * thick.mean_m, "planar_voxels": thick.planar_voxels}


def peer_row(args, folder, key):
    files = clouds.scan_files(folder)
    trajectory, ms = registrars.run_peer(key, files, clouds.KITTI_CORRECTION_DEG, args.threads)
    errors = None
    if (folder / "calib.txt").exists():
        T_cam0_lidar = se3.read_calibration(folder)
        errors = step_errors_m(folder, se3.to_camera(trajectory, T_cam0_lidar))
    row = {"recording": folder.name, "deskew": "none", "system": registrars.PEERS[key].name}
    return row | pose_figures(trajectory, errors, thickness(files, trajectory, "none")) | {
        "ms": float(np.median(ms))}


def compare_camera(with_camera, without):
    """Adds how far the camera moved the end; returns the limits it breaks."""
    if "error" in with_camera or "error" in without:
        return []
    apart_m = float(np.linalg.norm(np.subtract(with_camera["end_m"], without["end_m"])))
    share = apart_m / max(without["path_m"], 1e-9)
    with_camera.update(apart_m=apart_m, apart_share=share)
    name = f"{with_camera['recording']} {with_camera['deskew']}"
    broken = [f"{name}: the camera moves the end by {100 * share:.1f} % of the path"] * (
        share > MAX_SHARE)
    for key in ("thickness_mm", "step_rms_m"):
        if with_camera[key] is not None and with_camera[key] > MAX_WORSE * without[key]:
            broken.append(f"{name}: {key} {with_camera[key]:.4g} with camera, {without[key]:.4g} without")
    return broken


def expectations(row):
    """Limits broken by one row of ours."""
    if row["recording"] not in EXPECTED_X_M or "error" in row:
        return []
    expected_m, limit_m = EXPECTED_X_M[row["recording"]]
    off_m = abs(row["end_m"][0] - expected_m)
    return [f"{row['recording']} {row['deskew']} {row['system']}: ends at x = {row['end_m'][0]:.3f}, "
            f"not {expected_m}"] * (off_m > limit_m)


HEADER = (f"{'recording':<30} {'deskew':<6} {'system':<12} {'end x':>8} {'y':>7} {'z (m)':>7} "
          f"{'path':>7} {'on-off m':>8} {'%':>5} {'step rms':>8} {'worst':>6} {'thick mm':>8} "
          f"{'voxels':>6} {'ms':>6}  statuses")


def text_of(row):
    head = f"{row['recording']:<30} {row['deskew']:<6} {row['system']:<12} "
    if "error" in row:
        return head + row["error"]

    def number(value, width, digits):
        return f"{'-' if value is None else format(value, f'.{digits}f'):>{width}}"
    share = row.get("apart_share")
    x, y, z = row["end_m"]
    return (head + f"{x:8.3f} {y:7.3f} {z:7.3f} {row['path_m']:7.2f} {number(row.get('apart_m'), 8, 3)} "
            f"{number(None if share is None else 100 * share, 5, 2)} {number(row['step_rms_m'], 8, 3)} "
            f"{number(row['step_worst_m'], 6, 3)} {row['thickness_mm']:8.1f} "
            f"{row['planar_voxels']:6d} {row['ms']:6.0f}  "
            + " ".join(f"{k} {v}" for k, v in row.get("statuses", {}).items()))


def compare(args, folder):
    """(rows, broken limits) of one recording."""
    rows, broken = [], []
    for spin in RECORDINGS[folder.name]:
        without = our_row(args, folder, spin, camera=False)
        found = [without]
        if drives.has_images(folder):
            found.append(our_row(args, folder, spin, camera=True))
            broken += compare_camera(found[1], without)
        for row in found:
            broken += expectations(row)
            print(text_of(row), flush=True)
        rows += found
    for key in args.peers:
        rows.append(peer_row(args, folder, key))
        print(text_of(rows[-1]), flush=True)
    return rows, broken


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("TVL_TEST_DATA"))
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    parser.add_argument("--recordings", default=",".join(RECORDINGS))
    parser.add_argument("--peers", default="", help="of kiss, genz, gicp; see setup.sh")
    args = parser.parse_args()
    if args.data is None:
        parser.error("set TVL_TEST_DATA or --data")
    args.data, args.threads = pathlib.Path(args.data), 1
    args.peers = [key for key in args.peers.split(",") if key]
    args.out.mkdir(parents=True, exist_ok=True)
    rows, broken = [], []
    print(HEADER)
    for name in args.recordings.split(","):
        found, limits = compare(args, args.data / "sequences" / name)
        rows, broken = rows + found, broken + limits
    (args.out / "real_recordings.json").write_text(json.dumps(rows, indent=1) + "\n")
    for line in broken:
        print("beyond the limit: " + line)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
