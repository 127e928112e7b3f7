"""Scans in the KITTI .bin layout (float32 x y z intensity), as the peers get them."""

import pathlib

import numpy as np

from bench import poses as se3

KITTI_CORRECTION_DEG = 0.205  # the stored points lie this much too low


def scan_files(folder):
    """The .bin files of a folder, or of its velodyne/ subfolder, in order."""
    folder = pathlib.Path(folder)
    if (folder / "velodyne").is_dir():
        folder = folder / "velodyne"
    files = sorted(folder.glob("*.bin"))
    if not files:
        raise FileNotFoundError(f"no .bin scans in {folder}")
    return files


def read_scan(path):
    """(n, 3) float64, m. Points that are not finite are dropped."""
    raw = np.fromfile(path, dtype=np.float32)
    points = raw[: len(raw) // 4 * 4].reshape(-1, 4)[:, :3].astype(np.float64)
    return points[np.isfinite(points).all(axis=1)]


def raise_elevation(points, angle_deg):
    """Rotates every point upwards about p x z: its elevation grows, its range stays."""
    axis = np.cross(points, [0.0, 0.0, 1.0])
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = np.divide(axis, length, out=np.zeros_like(axis), where=length > 0)
    angle = np.deg2rad(angle_deg)
    return points * np.cos(angle) + np.cross(axis, points) * np.sin(angle)


def sweep_share(points, spin):
    """When each point was measured, 0..1 of the sweep: it starts behind and faces +x in the middle.

    spin: 'cw' (azimuth falls with time, seen from above) or 'ccw'.
    """
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    share = 0.5 + azimuth / (2 * np.pi)
    return np.clip(1.0 - share if spin == "cw" else share, 0.0, 1.0)


def for_peer(path, correction_deg, spin):
    """(points, share of the sweep): what every peer gets of a scan; no share of compensated ones."""
    points = read_scan(path)
    share = None if spin is None else sweep_share(points, spin)
    return raise_elevation(points, correction_deg), share


def deskew(points, spin, step):
    """Points moved to the middle of the sweep; step: (4, 4) motion T_prev_cur over one sweep."""
    share = (sweep_share(points, spin) - 0.5)[:, None]
    turn = se3.rotation_vector(step[:3, :3])
    shift = np.cross(turn, points) + step[:3, 3]
    return points + share * shift + 0.5 * share**2 * np.cross(turn, shift)
