"""The peers behind one interface: register(points, share) -> T_world_lidar.

Each runs with its own published KITTI parameters. `share` (0..1 of the sweep, one a point) is given
only when the peer is to de-skew by itself; None turns that off.
"""

import importlib.metadata
import pathlib
import time

import numpy as np

from . import clouds


class Kiss:
    name, package = "KISS-ICP", "kiss-icp"

    def __init__(self, threads, deskew):
        from kiss_icp.config import KISSConfig
        from kiss_icp.kiss_icp import KissICP
        config = KISSConfig()
        config.mapping.voxel_size = config.data.max_range / 100.0  # what its load_config does
        config.data.deskew = deskew
        config.registration.max_num_threads = threads
        self._odometry = KissICP(config)

    def register(self, points, share):
        self._odometry.register_frame(points, np.zeros(0) if share is None else share)
        return np.array(self._odometry.last_pose)

    @staticmethod
    def deskewed(points, share, T_delta):
        from kiss_icp.config import KISSConfig
        from kiss_icp.preprocess import get_preprocessor
        return get_preprocessor(KISSConfig()).preprocess(points, share, T_delta)


class GenZ:
    name, package = "GenZ-ICP", "genz-icp"

    def __init__(self, threads, deskew):
        del threads  # takes what the process may use: see limit_cores
        import genz_icp
        from genz_icp.config import load_config
        from genz_icp.genz_icp import GenZICP
        config = load_config(pathlib.Path(genz_icp.__file__).parent / "config/pretuned/kitti.yaml")
        config.data.deskew = deskew
        self._odometry = GenZICP(config)

    def register(self, points, share):
        # The class's own register_frame adds conversions that only its viewer needs.
        from genz_icp.pybind import genz_icp_pybind as core
        cloud = core._Vector3dVector(points)
        native = self._odometry._odometry
        native._register_frame(cloud) if share is None else native._register_frame(cloud, share)
        return np.array(native._last_pose())

    @staticmethod
    def deskewed(points, share, T_delta):
        from genz_icp.config import GenZConfig
        from genz_icp.preprocess import get_preprocessor
        config = GenZConfig()
        config.data.deskew = True
        return get_preprocessor(config).preprocess(points, share, T_delta)


class SmallGicp:
    """VGICP scan to model, as its own odometry benchmark does it; no de-skewing of its own."""
    name, package = "small_gicp", "small-gicp"
    DOWNSAMPLING_M, VOXEL_M, NEIGHBOURS = 0.25, 1.0, 10

    def __init__(self, threads, deskew):
        import small_gicp
        if deskew:
            raise ValueError("small_gicp does not de-skew")
        self._lib, self._threads = small_gicp, threads
        self._map = small_gicp.GaussianVoxelMap(self.VOXEL_M)
        self._map.set_lru(horizon=100, clear_cycle=10)
        self._pose, self._delta, self._empty = np.eye(4), np.eye(4), True

    def register(self, points, share):
        del share
        cloud, _ = self._lib.preprocess_points(
            points, self.DOWNSAMPLING_M, self.NEIGHBOURS, self._threads)
        if not self._empty:
            result = self._lib.align(self._map, cloud, self._pose @ self._delta,
                                     num_threads=self._threads)
            pose = np.array(result.T_target_source)
            self._delta, self._pose = np.linalg.inv(self._pose) @ pose, pose
        self._map.insert(cloud, self._pose)
        self._empty = False
        return self._pose.copy()


PEERS = {"kiss": Kiss, "genz": GenZ, "gicp": SmallGicp}


def run_peer(key, files, correction_deg, threads, spin=None):
    """(poses, ms a frame). Reading files is not counted."""
    peer = PEERS[key](threads, deskew=spin is not None)
    trajectory, elapsed_ms = [], []
    for path in files:
        points, share = clouds.for_peer(path, correction_deg, spin)
        start = time.perf_counter()
        trajectory.append(peer.register(points, share))
        elapsed_ms.append(1e3 * (time.perf_counter() - start))
    return np.array(trajectory), np.array(elapsed_ms)


def version(peer):
    return importlib.metadata.version(peer.package)


def deskew_reference(peer):
    """The instant (0..1 of the sweep) a peer's own de-skewing moves points to, found by asking it.

    One point, seen at three instants while the sensor moves 1 m: the one that stays where it is
    was seen at the reference instant.
    """
    T_delta = np.eye(4)
    T_delta[0, 3] = 1.0
    share = np.array([0.0, 0.5, 1.0])
    moved = peer.deskewed(np.tile([20.0, 0.0, 0.0], (3, 1)), share, T_delta)
    shift = np.asarray(moved)[:, 0] - 20.0
    return float(np.interp(0.0, shift, share))


def pose_instants(key, spin, count):
    """The instant of the sweep that each of `count` poses belongs to: its middle, but for peers that
    de-skew to another.

    Where a sweep was compensated already, and where nobody de-skews, all mean the middle; so do the
    first two poses of every peer, which knows no motion to de-skew by before it has registered two
    scans. KISS-SLAM takes its poses from KISS-ICP; anything that is no peer is ours.
    """
    peer = PEERS.get("kiss" if key.startswith("kiss") else key)
    instants = np.full(count, 0.5)
    if spin is not None and peer is not None:
        instants[2:] = deskew_reference(peer)
    return instants
