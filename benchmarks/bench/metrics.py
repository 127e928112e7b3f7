"""The same metrics for every set of poses, ours and the peers'."""

import dataclasses

import numpy as np

from . import clouds, poses as se3

# Map thickness ----------------------------------------------------------------------------------
VOXEL_M = 0.5           # small enough for facades to be flat in it, large enough to hold several rings
MIN_POINTS = 20         # of a voxel
MIN_FRAMES = 3          # a voxel seen by fewer scans says nothing of their alignment
RANGE_M = (5.0, 40.0)   # nearer: the car; farther: beam divergence exceeds the errors looked for
MAX_FLATNESS = 0.1      # smallest to middle eigenvalue: flat ...
MAX_LINEARITY = 0.9     # ... and 1 - middle to largest eigenvalue: not a single scan line
MAX_POINTS = 6_000_000  # of the accumulated map; more are thinned evenly


@dataclasses.dataclass(frozen=True)
class Thickness:
    mean_m: float    # mean absolute distance of the points to the plane of their voxel
    median_m: float
    planar_voxels: int


def _accumulate(files, poses, correction_deg):
    """Points of all scans in the world, and the frame of each."""
    per_scan = max(1, MAX_POINTS // len(files))
    points, frames = [], []
    for k, (path, T) in enumerate(zip(files, poses)):
        p = clouds.raise_elevation(clouds.read_scan(path), correction_deg)
        distance = np.linalg.norm(p, axis=1)
        p = p[(distance > RANGE_M[0]) & (distance < RANGE_M[1])]
        p = p[:: max(1, -(-len(p) // per_scan))]
        points.append(p @ T[:3, :3].T + T[:3, 3])
        frames.append(np.full(len(p), k))
    return np.concatenate(points), np.concatenate(frames)


def _voxel_starts(points, frames):
    """Points and frames sorted by voxel, and where each voxel starts."""
    cell = np.floor(points / VOXEL_M).astype(np.int64) + (1 << 20)
    key = (cell[:, 0] << 42) | (cell[:, 1] << 21) | cell[:, 2]
    order = np.lexsort((frames, key))
    key = key[order]
    starts = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    return points[order], frames[order], starts


def thickness(files, poses, correction_deg=0.0):
    """How thin the surfaces of the accumulated map are.

    Scans are moved to the world by `poses`; every 0.5 m voxel with at least 20 points from at least
    3 scans gets a plane by least squares; of those that are flat and not a line, the mean distance
    of the points to their plane. Voxels smeared beyond about 45 mm rms do not count as flat, so a map
    with fewer planar voxels can look thinner than it is: the count is reported beside it.
    """
    points, frames, starts = _voxel_starts(*_accumulate(files, poses, correction_deg))
    counts = np.diff(np.append(starts, len(points)))
    new_frame = np.concatenate([[1], (np.diff(frames) != 0).astype(int)])
    new_frame[starts] = 1
    enough = (counts >= MIN_POINTS) & (np.add.reduceat(new_frame, starts) >= MIN_FRAMES)
    voxel = np.repeat(np.arange(len(starts)), counts)
    centre = np.add.reduceat(points, starts) / counts[:, None]
    d = points - centre[voxel]
    scatter = np.empty((len(starts), 3, 3))
    for i in range(3):
        for j in range(i, 3):
            scatter[:, i, j] = scatter[:, j, i] = np.add.reduceat(d[:, i] * d[:, j], starts) / counts
    values, vectors = np.linalg.eigh(scatter)
    planar = enough & (values[:, 0] < MAX_FLATNESS * values[:, 1]) & (
        values[:, 1] > (1 - MAX_LINEARITY) * values[:, 2])
    residual = np.abs(np.einsum("ij,ij->i", d, vectors[voxel, :, 0]))[planar[voxel]]
    if len(residual) == 0:
        return Thickness(float("nan"), float("nan"), 0)
    return Thickness(float(residual.mean()), float(np.median(residual)), int(planar.sum()))


# Agreement between trajectories -----------------------------------------------------------------
def median_end(trajectories):
    """Component-wise median of the end points, m."""
    return np.median([t[-1][:3, 3] for t in trajectories], axis=0)


def motion_difference(a, b):
    """RMS difference of per-frame motions: (translation m, rotation deg)."""
    difference = se3.inverse(se3.motions(a)) @ se3.motions(b)
    translation = np.linalg.norm(difference[:, :3, 3], axis=1)
    rotation = np.rad2deg(se3.angle_rad(difference))
    return float(np.sqrt(np.mean(translation**2))), float(np.sqrt(np.mean(rotation**2)))


# Against truth ----------------------------------------------------------------------------------
LENGTHS_M = (100, 200, 300, 400, 500, 600, 700, 800)
START_STEP = 10


def path_m(poses):
    """Length of the path up to each pose, m."""
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def kitti_errors(truth, estimate):
    """(t_err %, r_err deg/100 m), segment-weighted mean of the KITTI devkit; NaN if under 100 m."""
    length = path_m(truth)
    t_errors, r_errors = [], []
    for first in range(0, len(truth), START_STEP):
        for segment in LENGTHS_M:
            last = int(np.searchsorted(length, length[first] + segment, side="right"))
            if last >= len(truth):
                continue
            d_truth = se3.inverse(truth[first]) @ truth[last]
            d_estimate = se3.inverse(estimate[first]) @ estimate[last]
            error = se3.inverse(d_estimate) @ d_truth
            t_errors.append(np.linalg.norm(error[:3, 3]) / segment)
            r_errors.append(se3.angle_rad(error) / segment)
    if not t_errors:
        return float("nan"), float("nan")
    return 100 * float(np.mean(t_errors)), 100 * float(np.rad2deg(np.mean(r_errors)))


def ate_m(truth, estimate):
    """RMSE of positions after the best rigid alignment (no scale)."""
    a, b = estimate[:, :3, 3], truth[:, :3, 3]
    u, _, vt = np.linalg.svd((b - b.mean(0)).T @ (a - a.mean(0)))
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    R = u @ sign @ vt
    residual = (b - b.mean(0)) - (a - a.mean(0)) @ R.T
    return float(np.sqrt(np.mean(np.sum(residual**2, axis=1))))
