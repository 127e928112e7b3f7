"""Tests of the benchmark metrics on worlds with known answers: python bench_test.py."""

import pathlib
import tempfile
import unittest

import numpy as np

from bench import clouds, metrics, poses, registrars


def step(x_m, yaw_deg=0.0):
    T = np.eye(4)
    T[:3, :3] = poses.rotation(np.deg2rad([0.0, 0.0, yaw_deg]))
    T[0, 3] = x_m
    return T


def chain(T, count):
    out = [np.eye(4)]
    for _ in range(count - 1):
        out.append(out[-1] @ T)
    return np.array(out)


def write_room(folder, trajectory, noise_m):
    """Scans of the plane y = 10 seen along a trajectory; returns the files."""
    rng = np.random.default_rng(1)
    files = []
    for k, T in enumerate(trajectory):
        wall = np.stack([rng.uniform(0, 20, 20000), np.full(20000, 10.0) + 0.25,
                         rng.uniform(-2, 2, 20000)], axis=1)
        wall[:, 1] += rng.normal(0, noise_m, len(wall))
        local = (wall - T[:3, 3]) @ T[:3, :3]
        cloud = np.zeros((len(local), 4), dtype=np.float32)
        cloud[:, :3] = local
        files.append(pathlib.Path(folder) / f"{k:06d}.bin")
        cloud.tofile(files[-1])
    return files


class Clouds(unittest.TestCase):
    def test_correction_raises_points_and_keeps_range(self):
        p = np.array([[10.0, 0.0, 0.0], [0.0, -20.0, -1.0]])
        raised = clouds.raise_elevation(p, 0.205)
        np.testing.assert_allclose(np.linalg.norm(raised, axis=1), np.linalg.norm(p, axis=1))
        elevation = [np.arctan2(q[:, 2], np.hypot(q[:, 0], q[:, 1])) for q in (p, raised)]
        np.testing.assert_allclose(np.rad2deg(elevation[1] - elevation[0]), 0.205)

    def test_correction_is_that_of_the_peers(self):
        from kiss_icp.pybind import kiss_icp_pybind as core
        p = np.random.default_rng(0).normal(0, 20, (100, 3))
        theirs = np.asarray(core._correct_kitti_scan(core._Vector3dVector(p)))
        np.testing.assert_allclose(clouds.raise_elevation(p, 0.205), theirs, atol=1e-9)

    def test_sweep_faces_forward_in_the_middle(self):
        p = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        np.testing.assert_allclose(clouds.sweep_share(p, "ccw"), [0.5, 0.75])
        np.testing.assert_allclose(clouds.sweep_share(p, "cw"), [0.5, 0.25])


class Metrics(unittest.TestCase):
    def test_kitti_errors_of_a_known_scale_and_turn(self):
        truth, estimate = chain(step(1.0), 301), chain(step(1.01), 301)
        t_err, r_err = metrics.kitti_errors(truth, estimate)
        # Segments end at the first frame beyond the length, as in the devkit: 101 steps for 100 m.
        self.assertAlmostEqual(t_err, 1.0, delta=0.02)
        self.assertAlmostEqual(r_err, 0.0)
        _, r_err = metrics.kitti_errors(truth, chain(step(1.0, 0.01), 301))
        self.assertAlmostEqual(r_err, 1.0, delta=0.02)

    def test_ate_ignores_a_rigid_motion(self):
        truth = chain(step(1.0, 1.0), 100)
        moved = step(3.0, 40.0) @ truth
        self.assertAlmostEqual(metrics.ate_m(truth, moved), 0.0, places=9)
        bent = truth.copy()
        bent[50:, 2, 3] += 1.0
        self.assertGreater(metrics.ate_m(truth, bent), 0.1)

    def test_motion_difference(self):
        t, r = metrics.motion_difference(chain(step(1.0), 10), chain(step(1.1, 2.0), 10))
        self.assertAlmostEqual(t, 0.1, delta=1e-3)
        self.assertAlmostEqual(r, 2.0)

    def test_thickness_is_the_mean_of_the_noise_and_grows_with_wrong_poses(self):
        truth = chain(step(0.5), 6)
        with tempfile.TemporaryDirectory() as folder:
            files = write_room(folder, truth, noise_m=0.02)
            right = metrics.thickness(files, truth)
            wrong = truth.copy()
            wrong[::2, 1, 3] += 0.06
            self.assertAlmostEqual(right.mean_m, 0.02 * np.sqrt(2 / np.pi), delta=5e-4)
            self.assertGreater(metrics.thickness(files, wrong).mean_m, 1.5 * right.mean_m)


class Poses(unittest.TestCase):
    def test_half_a_frame_later(self):
        truth = chain(step(1.0, 2.0), 10)
        later = poses.shifted(truth, 0.5)
        np.testing.assert_allclose(poses.motions(later)[0][:3, 3],
                                   poses.motions(truth)[0][:3, 3], atol=0.02)
        np.testing.assert_allclose(poses.shifted(truth, 0.0), truth, atol=1e-12)

    def test_frames_cancel(self):
        T_cam0_lidar = step(0.3, 90.0)
        lidar = chain(step(1.0, 2.0), 5)
        there = poses.to_camera(lidar, T_cam0_lidar)
        np.testing.assert_allclose(poses.to_lidar(there, T_cam0_lidar), lidar, atol=1e-12)


class Peers(unittest.TestCase):
    def test_instants_of_deskewing(self):
        self.assertAlmostEqual(registrars.deskew_reference(registrars.Kiss), 1.0)
        self.assertAlmostEqual(registrars.deskew_reference(registrars.GenZ), 0.5)


if __name__ == "__main__":
    unittest.main()
