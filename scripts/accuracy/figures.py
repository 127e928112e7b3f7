"""Figures of accuracy of a run against truth. Pose files are those of camera 0; steps are judged in
the lidar frame, x forward, y left, z up."""

import math

from . import judge, poses

LENGTHS_M = (100, 200, 300, 400, 500, 600, 700, 800)
START_STEP = 10
AXES = ("forward", "left", "up")
TURNS = ("roll", "pitch", "yaw")


def read_T_cam0_lidar(sequence):
    for line in (sequence / "calib.txt").read_text().splitlines():
        if line.startswith("Tr"):
            return tuple(float(word) for word in line.split()[1:13])
    raise ValueError(f"{sequence}/calib.txt: no line Tr")


def to_lidar(line, T_cam0_lidar):
    T_lidar_cam0 = poses.inverse(T_cam0_lidar)
    return [poses.product(poses.product(T_lidar_cam0, pose), T_cam0_lidar) for pose in line]


def kitti_errors(truth, estimate):
    """(t_err %, r_err deg/100 m), segment-weighted mean of the KITTI devkit; NaN if under 100 m."""
    way_m = [0.0]
    for a, b in zip(truth, truth[1:]):
        way_m.append(way_m[-1] + poses.distance_m(a, b))
    t_errors, r_errors = [], []
    for first in range(0, len(truth), START_STEP):
        for length_m in LENGTHS_M:
            last = next((k for k in range(first, len(truth))
                         if way_m[k] - way_m[first] > length_m), None)
            if last is None:
                break
            error = poses.between(poses.between(estimate[first], estimate[last]),
                                  poses.between(truth[first], truth[last]))
            t_errors.append(poses.length_m(error) / length_m)
            r_errors.append(poses.angle_deg(error) / length_m)
    if not t_errors:
        return math.nan, math.nan
    return (100 * sum(t_errors) / len(t_errors), 100 * sum(r_errors) / len(r_errors))


def step_error(truth, estimate, k):
    """xi of T_true = T_estimated Exp(xi) for the step to frame k: rotation (rad), translation (m)."""
    error = poses.between(poses.between(estimate[k - 1], estimate[k]),
                          poses.between(truth[k - 1], truth[k]))
    return [*poses.rotation_vector(error), *poses.position(error)]


def solve(matrix, vector):
    """x of A x = b by Gaussian elimination with pivoting; A is small."""
    n = len(vector)
    rows = [list(matrix[i]) + [vector[i]] for i in range(n)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda r, i=i: abs(rows[r][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for r in range(i + 1, n):
            factor = rows[r][i] / rows[i][i]
            rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - sum(rows[i][j] * x[j] for j in range(i + 1, n))) / rows[i][i]
    return x


def nees(error, covariance):
    """e' C^-1 e per degree of freedom: 1 where the covariance tells the truth."""
    return sum(a * b for a, b in zip(error, solve(covariance, error))) / len(error)


def _rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def _block(covariance, first):
    return [row[first:first + 3] for row in covariance[first:first + 3]]


def step_figures(truth, run, T_cam0_lidar):
    """rms of the step errors by direction (mm, mdeg), and how honest the covariances are, of the
    frames that claim to be tracked after one that does. A frame that was delivered twice is exactly
    where it was: it says so with a covariance of zero and is no measurement."""
    truth, estimate = to_lidar(truth, T_cam0_lidar), to_lidar(run.poses, T_cam0_lidar)
    claims = [k for k in range(1, len(truth)) if run.statuses[k] in judge.CLAIMS and
              (k == 1 or run.statuses[k - 1] in judge.CLAIMS) and
              any(run.report["frames"][k]["step_covariance"])]
    errors = [step_error(truth, estimate, k) for k in claims]
    flat = [run.report["frames"][k]["step_covariance"] for k in claims]
    covariances = [[c[6 * i:6 * i + 6] for i in range(6)] for c in flat]
    figures = {}
    for i, name in enumerate(TURNS):
        figures[f"step_{name}_mdeg"] = 1e3 * math.degrees(_rms([e[i] for e in errors]))
    for i, name in enumerate(AXES):
        figures[f"step_{name}_mm"] = 1e3 * _rms([e[3 + i] for e in errors])
    n = len(claims)
    figures["nees_rotation"] = sum(nees(e[:3], _block(c, 0)) for e, c in zip(errors, covariances)) / n
    figures["nees_translation"] = sum(nees(e[3:], _block(c, 3))
                                      for e, c in zip(errors, covariances)) / n
    for name, scale, axes in (("mdeg", math.degrees(1e3), (0, 1, 2)), ("mm", 1e3, (3, 4, 5))):
        figures["claimed_" + name] = scale * _rms([math.sqrt(c[i][i]) for c in covariances
                                                   for i in axes])
    return figures


def evidence_figures(run):
    """What the map step found on average: residuals and how many of them."""
    frames = [frame["map_step"] for frame in run.report["frames"]
              if frame["map_step"]["status"] == "converged"]
    figures = {}
    for key in ("plane_rms_m", "edge_rms_m", "visual_rms_px", "planes", "edges", "visual"):
        values = [frame[key] for frame in frames]
        name, scale = (key.replace("_m", "_mm"), 1e3) if key.endswith("_m") else (key, 1.0)
        figures["map_" + name] = scale * sum(values) / max(1, len(values))
    return figures
