"""Rigid transforms as 4x4 arrays and the pose files of KITTI."""

import pathlib

import numpy as np


def read_poses(path):
    """3x4 row-major, one a line -> (n, 4, 4)."""
    rows = np.loadtxt(path, ndmin=2)
    if rows.shape[1] != 12:
        raise ValueError(f"{path}: {rows.shape[1]} numbers a line, not 12")
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    poses[:, :3, :] = rows.reshape(-1, 3, 4)
    return poses


def write_poses(path, poses):
    pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, np.asarray(poses)[:, :3, :].reshape(len(poses), 12), fmt="%.9e")


def read_calibration(sequence):
    """T_cam0_lidar of a KITTI odometry folder; the identity where there is no calib.txt."""
    path = pathlib.Path(sequence) / "calib.txt"
    if not path.exists():
        return np.eye(4)
    for line in path.read_text().splitlines():
        if line.startswith("Tr"):
            T_cam0_lidar = np.eye(4)
            T_cam0_lidar[:3, :] = np.array(line.split()[1:], dtype=float).reshape(3, 4)
            return T_cam0_lidar
    raise ValueError(f"{sequence}/calib.txt: no line Tr")


def inverse(T):
    """Of one transform or a stack of them."""
    R_t = np.swapaxes(T[..., :3, :3], -1, -2)
    out = np.zeros_like(T)
    out[..., :3, :3] = R_t
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", R_t, T[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def to_lidar(T_world_cam0, T_cam0_lidar):
    """Camera-0 poses (first identity) to lidar poses (first identity)."""
    return inverse(T_cam0_lidar) @ T_world_cam0 @ T_cam0_lidar


def to_camera(T_world_lidar, T_cam0_lidar):
    return T_cam0_lidar @ T_world_lidar @ inverse(T_cam0_lidar)


def motions(poses):
    """T_prev_cur of consecutive poses."""
    return inverse(poses[:-1]) @ poses[1:]


def angle_rad(T):
    """Rotation angle; exact near zero, unlike the arc cosine of the trace."""
    R = T[..., :3, :3]
    v = np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0],
                  R[..., 1, 0] - R[..., 0, 1]], axis=-1)
    return np.arctan2(np.linalg.norm(v, axis=-1), np.trace(R, axis1=-2, axis2=-1) - 1.0)


def rotation_vector(R):
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    norm = np.linalg.norm(v)
    return np.zeros(3) if norm < 1e-15 else v / norm * np.arctan2(norm, np.trace(R) - 1.0)


def rotation(vector):
    """Exponential map (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle < 1e-15:
        return np.eye(3)
    x, y, z = vector / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def shifted(poses, share):
    """Poses `share` (-1..1) of a frame later, interpolated; beyond the ends they are extrapolated.

    share: one number, or one a pose.
    """
    share = np.broadcast_to(share, len(poses))
    steps = motions(poses)
    before, after = np.concatenate([steps[:1], steps]), np.concatenate([steps, steps[-1:]])
    out = poses.copy()
    for k, s in enumerate(share):
        step = after[k] if s >= 0 else before[k]
        part = np.eye(4)
        part[:3, :3] = rotation(s * rotation_vector(step[:3, :3]))
        part[:3, 3] = s * step[:3, 3]
        out[k] = poses[k] @ part
    return inverse(out[:1]) @ out
