#!/usr/bin/env python3
"""Are the covariances of run.json honest over 1, 10, 100 and 400 m?

    uncertainty.py RUN [RUN ...]      folders that `tvl run --no-loops` has written, with truth

One line a distance: the mean squared error of relative poses T_i_j, whitened by their covariance
and divided by the dimension (NEES; 1 is honest, less is too careful), of rotation and translation
together and alone, and each axis alone. The covariance of T_i_j is put together from what run.json
says of each frame, as in src/tvl/slam/pose_uncertainty.h: noise_covariance at both ends,
walk_covariance of the steps between, and the options uncertainty.bias_*.
"""

import argparse
import json
import pathlib
import sys

import numpy as np

from bench import poses

DISTANCES_M = (1, 10, 100, 400)
STRIDE = 10      # frames between the windows' starts
FIRST_FRAME = 5  # poses against a map of a few scans are not what the model is about


def adjoint(T):
    """Of [rotation, translation]."""
    R, t = T[:3, :3], T[:3, 3]
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = R
    out[3:, :3] = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]]) @ R
    return out


def bias_of(options):
    """Standard deviations of roll, pitch and yaw (rad / m) and of the scale."""
    level = np.radians(float(options["bias_level_deg_per_m"]))
    yaw = np.radians(float(options["bias_yaw_deg_per_m"]))
    return np.array([level, level, yaw, float(options["bias_scale"])])


class Window:
    """What has come together since its start."""

    def __init__(self):
        self.walk = np.zeros((6, 6))
        self.bias = np.zeros((6, 4))

    def add(self, T_prev_cur, walk):
        back = poses.inverse(T_prev_cur)
        ad = adjoint(back)
        self.walk = ad @ self.walk @ ad.T + walk
        self.bias = ad @ self.bias
        self.bias[:3, :3] += np.linalg.norm(T_prev_cur[:3, 3]) * np.eye(3)
        self.bias[3:, 3] -= back[:3, 3]

    def covariance(self, T_start_now, noise_start, noise_now, bias_sigma):
        ad = adjoint(poses.inverse(T_start_now))
        of_bias = self.bias * bias_sigma
        return noise_now + ad @ noise_start @ ad.T + self.walk + of_bias @ of_bias.T


def error_of(truth, estimate, i, j):
    E = poses.inverse(poses.inverse(truth[i]) @ truth[j]) @ (poses.inverse(estimate[i]) @ estimate[j])
    return np.concatenate([poses.rotation_vector(E[:3, :3]), E[:3, 3]])


def whitened(error, covariance):
    """NEES of all, rotation, translation, and of each axis."""
    def nees(part):
        e, C = error[part], covariance[part, part]
        return e @ np.linalg.solve(C, e) / len(e)
    return [nees(slice(0, 6)), nees(slice(0, 3)), nees(slice(3, 6)),
            *(error**2 / np.diag(covariance))]


def judge(truth, estimate, noise, walk, bias_sigma):
    """{distance: rows of whitened()} of one run; poses of the lidar."""
    path_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(poses.motions(truth)[:, :3, 3], axis=1))])
    rows = {distance: [] for distance in DISTANCES_M}
    for i in range(FIRST_FRAME, len(truth), STRIDE):
        window, j = Window(), i
        for distance in DISTANCES_M:
            while j < len(truth) - 1 and path_m[j] < path_m[i] + distance:
                j += 1
                window.add(poses.inverse(estimate[j - 1]) @ estimate[j], walk[j])
            if path_m[j] < path_m[i] + distance:
                break
            covariance = window.covariance(poses.inverse(estimate[i]) @ estimate[j], noise[i],
                                           noise[j], bias_sigma)
            rows[distance].append(whitened(error_of(truth, estimate, i, j), covariance))
    return rows


def read(run):
    run = pathlib.Path(run)
    report = json.loads((run / "run.json").read_text())
    recording = pathlib.Path(report["input"])
    if not (recording / "calib.txt").is_file():
        sys.exit(f"{run}/run.json: its input {recording} has no calib.txt; a relative path is meant "
                 "from where tvl was run")
    T_cam0_lidar = poses.read_calibration(recording)
    truth = poses.to_lidar(poses.read_poses(run / "truth_kitti.txt"), T_cam0_lidar)
    estimate = poses.to_lidar(poses.read_poses(run / "odometry_kitti.txt"), T_cam0_lidar)
    matrices = {name: [np.reshape(frame[name], (6, 6)) for frame in report["frames"]]
                for name in ("noise_covariance", "walk_covariance")}
    return (truth, estimate, matrices["noise_covariance"], matrices["walk_covariance"],
            bias_of(report["options"]["uncertainty"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("runs", nargs="+")
    arguments = parser.parse_args()
    rows = {distance: [] for distance in DISTANCES_M}
    for run in arguments.runs:
        for distance, found in judge(*read(run)).items():
            rows[distance] += found
    print("    m  windows  NEES  rotation  translation   roll pitch  yaw    x    y    z")
    for distance, found in rows.items():
        if found:
            mean = np.mean(found, axis=0)
            print(f"{distance:5d}  {len(found):7d}  {mean[0]:4.2f}  {mean[1]:8.2f}  {mean[2]:11.2f}  ",
                  " ".join(f"{value:4.2f}" for value in mean[3:]))


if __name__ == "__main__":
    main()
