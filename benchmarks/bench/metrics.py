"""The same metrics for every set of poses, ours and the peers'."""

import dataclasses

import numpy as np

from . import clouds, poses as se3

# Quality of the map -----------------------------------------------------------------------------
VOXEL_M = 0.5           # small enough for facades to be flat in it, large enough to hold several rings
MIN_POINTS = 20         # of a voxel
MIN_FRAMES = 3          # a voxel seen by fewer scans says nothing of their alignment
RANGE_M = (5.0, 40.0)   # nearer: the car; farther: beam divergence exceeds the errors looked for
MAX_FLATNESS = 0.1      # smallest to middle eigenvalue: flat ...
MAX_LINEARITY = 0.9     # ... and 1 - middle to largest eigenvalue: not a single scan line
MAX_POINTS = 6_000_000  # of the accumulated map; more are thinned evenly
ENTROPY_RADIUS_M = 0.3         # of a neighbourhood: several rings, one surface
ENTROPY_MIN_NEIGHBOURS = 10     # fewer make no covariance
ENTROPY_MAP_POINTS = 2_000_000  # of the map whose neighbourhoods are looked at ...
ENTROPY_QUERIES = 20_000        # ... of so many points, evenly chosen
ENTROPY_CHUNK = 2_000           # neighbourhoods held in memory at a time


@dataclasses.dataclass(frozen=True)
class Thickness:
    mean_m: float    # mean absolute distance of the points to the plane of their voxel
    median_m: float
    planar_voxels: int
    planar_points: int


@dataclasses.dataclass(frozen=True)
class Entropy:
    mean: float   # nats; lower is crisper, only differences on the same scans mean anything
    points: int   # that have the neighbours for it, of ENTROPY_QUERIES


def _accumulate(files, poses, correction_deg, spin=None):
    """Points of all scans in the world, and the frame of each.

    With a spin scans are raw: they are de-skewed to the middle of the sweep by the motions of the
    poses, the first as the second.
    """
    per_scan = max(1, MAX_POINTS // len(files))
    steps = se3.motions(poses)
    steps = np.concatenate([steps[:1], steps])
    points, frames = [], []
    for k, (path, T) in enumerate(zip(files, poses)):
        p = clouds.read_scan(path)
        if spin is not None:
            p = clouds.deskew(p, spin, steps[k])
        p = clouds.raise_elevation(p, correction_deg)
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


def thickness(files, poses, correction_deg=0.0, spin=None):
    """How thin the surfaces of the accumulated map are.

    Scans are moved to the world by `poses`; every 0.5 m voxel with at least 20 points from at least
    3 scans gets a plane by least squares; of those that are flat and not a line, the mean distance
    of the points to their plane. Voxels smeared beyond about 45 mm rms do not count as flat, so a map
    with fewer planar voxels can look thinner than it is: the count is reported beside it.
    """
    return _thickness(*_accumulate(files, poses, correction_deg, spin))


def _thickness(points, frames):
    points, frames, starts = _voxel_starts(points, frames)
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
        return Thickness(float("nan"), float("nan"), 0, 0)
    return Thickness(float(residual.mean()), float(np.median(residual)), int(planar.sum()),
                     len(residual))


def _neighbourhood_entropies(points, frames, neighbours, centres):
    """0.5 ln |2 pi e Sigma| of those neighbourhoods that have enough points and scans."""
    counts = np.array([len(n) for n in neighbours])
    flat, group = np.concatenate(neighbours).astype(int), np.repeat(np.arange(len(counts)), counts)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    seen = np.unique(group * (int(frames.max()) + 1) + frames[flat]) // (int(frames.max()) + 1)
    enough = (counts >= ENTROPY_MIN_NEIGHBOURS) & (
        np.bincount(seen, minlength=len(counts)) >= MIN_FRAMES)
    d = points[flat] - centres[group]  # near zero, so that squares keep their digits
    mean = np.add.reduceat(d, starts) / counts[:, None]
    scatter = np.add.reduceat(d[:, :, None] * d[:, None, :], starts) / counts[:, None, None]
    covariance = scatter - mean[:, :, None] * mean[:, None, :]
    sign, log_det = np.linalg.slogdet(2 * np.pi * np.e * covariance)
    return 0.5 * log_det[enough & (sign > 0)]


def _entropy(points, frames):
    from scipy.spatial import cKDTree
    thin = max(1, -(-len(points) // ENTROPY_MAP_POINTS))
    points, frames = points[::thin], frames[::thin]
    centres = points[:: max(1, -(-len(points) // ENTROPY_QUERIES))]
    tree, found = cKDTree(points), []
    for first in range(0, len(centres), ENTROPY_CHUNK):
        chunk = centres[first: first + ENTROPY_CHUNK]
        neighbours = tree.query_ball_point(chunk, ENTROPY_RADIUS_M, return_sorted=False)
        found.append(_neighbourhood_entropies(points, frames, neighbours, chunk))
    found = np.concatenate(found)
    return Entropy(float(found.mean()) if len(found) > 0 else float("nan"), len(found))


def map_quality(files, poses, correction_deg=0.0, spin=None):
    """(Thickness, Entropy) of the map that the poses make of the scans.

    Mean map entropy (Droeschel and Behnke 2014, Razlaw et al. 2015): the mean over points of
    0.5 ln |2 pi e Sigma| of the points within 0.3 m. Taken of neighbourhoods with at least 10 points
    from at least 3 scans, since a single scan says nothing of the poses.
    """
    points, frames = _accumulate(files, poses, correction_deg, spin)
    return _thickness(points, frames), _entropy(points, frames)


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


def ate_first_m(truth, estimate):
    """RMSE of positions with the first poses laid on each other."""
    moved = truth[0] @ se3.inverse(estimate[0]) @ estimate
    return float(np.sqrt(np.mean(np.sum((moved[:, :3, 3] - truth[:, :3, 3])**2, axis=1))))


def end_error(truth, estimate):
    """(m, deg) of D = (G_0^-1 G_N)^-1 (E_0^-1 E_N)."""
    D = se3.inverse(se3.inverse(truth[0]) @ truth[-1]) @ se3.inverse(estimate[0]) @ estimate[-1]
    return float(np.linalg.norm(D[:3, 3])), float(np.rad2deg(se3.angle_rad(D)))


def heading_deg_per_km(truth, estimate):
    """Error of the heading gained from first to last pose, a kilometre of path; left is positive.

    Poses of the lidar, whose z axis is up.
    """
    def turned(poses):
        return poses[-1, :3, :3] @ poses[0, :3, :3].T
    R = turned(estimate) @ turned(truth).T
    return float(np.rad2deg(np.arctan2(R[1, 0], R[0, 0])) / (1e-3 * path_m(truth)[-1]))


def ate_m(truth, estimate):
    """RMSE of positions after the best rigid alignment (no scale)."""
    a, b = estimate[:, :3, 3], truth[:, :3, 3]
    u, _, vt = np.linalg.svd((b - b.mean(0)).T @ (a - a.mean(0)))
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    R = u @ sign @ vt
    residual = (b - b.mean(0)) - (a - a.mean(0)) @ R.T
    return float(np.sqrt(np.mean(np.sum(residual**2, axis=1))))
