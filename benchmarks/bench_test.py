"""Tests of the benchmark metrics on worlds with known answers: python bench_test.py."""

import dataclasses
import pathlib
import tempfile
import unittest

import numpy as np

import compare_loops
import loops
from bench import closures, clouds, drives, kiss_slam, metrics, poses, registrars


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


def skew(path, motion):
    """Rewrites a scan as a scanner spinning clockwise measures it while it moves by `motion`."""
    raw = np.fromfile(path, dtype=np.float32).reshape(-1, 4)
    points = raw[:, :3].astype(float)
    measured = points.copy()
    for _ in range(5):  # the azimuth at which a point is seen depends on when it is seen
        back = clouds.deskew(measured, "cw", motion) - measured
        measured = points - back
    raw[:, :3] = measured
    raw.tofile(path)


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

    def test_errors_with_first_poses_aligned_and_at_the_end(self):
        truth = chain(step(1.0), 101)
        estimate = step(3.0, 40.0) @ chain(step(1.01), 101)  # k cm off after k frames
        self.assertAlmostEqual(metrics.ate_first_m(truth, estimate),
                               0.01 * np.sqrt(np.mean(np.arange(101)**2)))
        end_m, end_deg = metrics.end_error(truth, estimate)
        self.assertAlmostEqual(end_m, 1.0)
        self.assertAlmostEqual(end_deg, 0.0)

    def test_heading_drift_has_a_sign_and_leaves_tilt_out(self):
        truth = chain(step(1.0, 0.5), 501)
        left, right = chain(step(1.0, 0.501), 501), chain(step(1.0, 0.499), 501)
        self.assertAlmostEqual(metrics.heading_deg_per_km(truth, left), 1.0)
        self.assertAlmostEqual(metrics.heading_deg_per_km(truth, right), -1.0)
        tilted = truth.copy()
        tilted[-1, :3, :3] = truth[-1, :3, :3] @ poses.rotation(np.array([0.02, 0.01, 0.0]))
        self.assertLess(abs(metrics.heading_deg_per_km(truth, tilted)), 0.02)

    def test_thickness_is_the_mean_of_the_noise_and_grows_with_wrong_poses(self):
        truth = chain(step(0.5), 6)
        with tempfile.TemporaryDirectory() as folder:
            files = write_room(folder, truth, noise_m=0.02)
            right = metrics.thickness(files, truth)
            wrong = truth.copy()
            wrong[::2, 1, 3] += 0.06
            self.assertAlmostEqual(right.mean_m, 0.02 * np.sqrt(2 / np.pi), delta=5e-4)
            self.assertGreater(metrics.thickness(files, wrong).mean_m, 1.5 * right.mean_m)

    def test_entropy_is_that_of_the_wall_and_grows_with_wrong_poses(self):
        truth = chain(step(0.5), 6)
        with tempfile.TemporaryDirectory() as folder:
            files = write_room(folder, truth, noise_m=0.02)
            _, right = metrics.map_quality(files, truth)
            wrong = truth.copy()
            wrong[::2, 1, 3] += 0.06
            _, smeared = metrics.map_quality(files, wrong)
        # A disc of radius r has the variance r^2 / 4 along each of its axes.
        expected = 0.5 * np.log((2 * np.pi * np.e)**3 * (0.3**2 / 4)**2 * 0.02**2)
        self.assertAlmostEqual(right.mean, expected, delta=0.08)
        self.assertAlmostEqual(smeared.mean - right.mean, np.log(np.hypot(0.02, 0.03) / 0.02),
                               delta=0.1)
        self.assertGreater(right.points, 15000)

    def test_neighbourhoods_of_too_few_scans_do_not_count(self):
        truth = chain(step(0.5), 2)
        with tempfile.TemporaryDirectory() as folder:
            thick, entropy = metrics.map_quality(write_room(folder, truth, noise_m=0.02), truth)
        self.assertEqual((thick.planar_points, entropy.points), (0, 0))
        self.assertTrue(np.isnan(entropy.mean))

    def test_raw_scans_are_deskewed_by_the_poses(self):
        truth = chain(step(2.0, 3.0), 6)
        with tempfile.TemporaryDirectory() as folder:
            files = write_room(folder, truth, noise_m=0.01)
            sharp = metrics.thickness(files, truth)
            for path, motion in zip(files, [step(2.0, 3.0)] * len(files)):
                skew(path, motion)
            self.assertAlmostEqual(metrics.thickness(files, truth, spin="cw").mean_m, sharp.mean_m,
                                   delta=1e-3)
            self.assertGreater(metrics.thickness(files, truth).mean_m, 1.3 * sharp.mean_m)


class Poses(unittest.TestCase):
    def test_each_pose_by_its_own_share(self):
        truth = chain(step(1.0), 5)
        moved = poses.shifted(truth, [0.0, 0.5, -0.5, 0.25, 0.5])
        np.testing.assert_allclose(moved[:, 0, 3], [0.0, 1.5, 1.5, 3.25, 4.5])

    def test_earlier_goes_back_along_the_step_that_led_there(self):
        truth = np.array([step(0.5 * k**2) for k in range(5)])  # 0, 0.5, 2, 4.5, 8 m
        moved = poses.shifted(truth, [0.0, -0.5, -0.5, -0.5, -0.5])
        np.testing.assert_allclose(moved[:, 0, 3], [0.0, 0.25, 1.25, 3.25, 6.25])

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


def two_laps(yaw_deg=1.0, speed_m=1.0):
    """Twice around a circle of 360 frames, truth of the lidar, and its stretches of 90 frames."""
    truth = chain(step(speed_m, yaw_deg), 720)
    stretches = [closures.Stretch(first, poses.inverse(truth[first]) @ truth[first: first + 91])
                 for first in range(0, 720, 90)]
    return truth, stretches


def true_closure(truth, stretches, query, reference, T_error=np.eye(4)):
    T = poses.inverse(truth[stretches[query].first]) @ truth[stretches[reference].first]
    return closures.Closure(query, reference, T @ T_error)


class Closures(unittest.TestCase):
    def test_a_second_lap_revisits_a_first_does_not(self):
        truth, stretches = two_laps()
        # The fourth stretch ends where the first begins.
        self.assertEqual(closures.revisits(truth, stretches), [3, 4, 5, 6, 7])
        slow = chain(step(0.01, 1.0), 720)  # within 10 m always, but never 50 m of path later
        self.assertEqual(closures.revisits(slow, stretches), [])

    def test_near_in_time_is_no_revisit(self):
        truth = chain(step(2.0, 3.0), 200)  # around in 120 frames: 12 s
        stretches = [closures.Stretch(0, truth)]
        self.assertEqual(closures.revisits(truth, stretches), [])

    def test_true_closures_have_no_error_and_false_ones_theirs(self):
        truth, stretches = two_laps()
        np.testing.assert_allclose(
            closures.error(truth, stretches, true_closure(truth, stretches, 5, 1)), 0, atol=1e-9)
        _, off_deg = closures.error(truth, stretches,
                                    true_closure(truth, stretches, 5, 1, step(0.0, 2.0)))
        self.assertAlmostEqual(off_deg, 2.0)
        off_m, off_deg = closures.error(truth, stretches,
                                        true_closure(truth, stretches, 5, 1, step(1.5)))
        self.assertAlmostEqual(off_m, 1.5)
        self.assertAlmostEqual(off_deg, 0.0)

    def test_errors_count_where_stretches_meet(self):
        truth, stretches = two_laps()
        # The fourth stretch ends where the first begins, 81 m from its own first frame.
        i, j, distance = closures.nearest(truth, stretches[3], stretches[0])
        self.assertEqual((i, j), (90, 0))
        self.assertAlmostEqual(distance, 0.0, delta=1e-6)
        right = true_closure(truth, stretches, 3, 0)
        turn = step(0.0, 1.0)
        there = closures.Closure(3, 0, right.T_query_reference @ turn)
        off_m, off_deg = closures.error(truth, stretches, there)
        self.assertAlmostEqual(off_m, 0.0, delta=1e-6)
        self.assertAlmostEqual(off_deg, 1.0)
        far = closures.Closure(3, 0, turn @ right.T_query_reference)
        off_m, off_deg = closures.error(truth, stretches, far)
        self.assertAlmostEqual(off_m, 81.0 * np.deg2rad(1.0), delta=0.01)
        self.assertAlmostEqual(off_deg, 1.0)

    def test_score_counts_accepted_false_and_closed(self):
        truth, stretches = two_laps()
        found = [true_closure(truth, stretches, 4, 0),
                 true_closure(truth, stretches, 5, 1, step(1.01)),
                 true_closure(truth, stretches, 3, 0, step(0.0, 5.1)),
                 true_closure(truth, stretches, 2, 0, step(0.5))]  # right, but no revisit
        score = closures.score(truth, stretches, found)
        self.assertEqual((score.accepted, score.false), (4, 2))
        self.assertEqual((score.closed, score.revisits), (1, 5))
        nothing = closures.score(truth, stretches, [])
        self.assertEqual((nothing.accepted, nothing.false, nothing.closed), (0, 0, 0))
        self.assertTrue(np.isnan(nothing.error_p95_m))

    def test_stretches_chain_to_the_drive(self):
        truth, stretches = two_laps()
        local = [s.T_first_frame for s in stretches]
        np.testing.assert_allclose(kiss_slam.chained(local), truth, atol=1e-9)


class Drives(unittest.TestCase):
    URI = "sim:city?seed=4&frames=0&trajectory=some/kitti_06.txt"

    def test_arguments_of_a_simulated_drive(self):
        self.assertEqual(drives.simulate_arguments(self.URI, lidar_only=True),
                         ["--preset", "city", "--seed", "4", "--frames", "0", "--trajectory",
                          "some/kitti_06.txt", "--no-camera"])
        self.assertEqual(drives.simulate_arguments("sim:loop?clean=1&camera=0", lidar_only=False),
                         ["--preset", "loop", "--clean", "--no-camera"])
        self.assertEqual(drives.simulate_arguments("sim:loop?clean=0&camera=1", lidar_only=False),
                         ["--preset", "loop"])
        with self.assertRaises(ValueError):
            drives.simulate_arguments("sim:loop?rings=1", lidar_only=False)

    def test_names_are_names_of_folders(self):
        self.assertEqual(drives.name_of(self.URI), "city_seed4_frames0_kitti_06")
        self.assertEqual(drives.name_of("sim:city?night=5:9"), "city_night5-9")
        self.assertEqual(drives.name_of("a/b/"), "b")

    def test_what_a_drive_says_of_its_scans(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertIsNone(drives.spin_of(folder))
            self.assertEqual(drives.correction_of(folder), 0.205)
            (pathlib.Path(folder) / "meta.json").write_text(
                '{"raw": "ccw", "vertical_correction_rad": 0.0}')
            self.assertEqual(drives.spin_of(folder), "ccw")
            self.assertEqual(drives.correction_of(folder), 0.0)


class Rows(unittest.TestCase):
    REPORT = {"loops": {"timing_per_keyframe": {"second_look_ms": 500.0, "polish_ms": 250.0},
                        "against_truth": {"accepted": 7, "false_accepted": 1, "error_p95_m": 0.5,
                                          "error_p95_deg": 0.25, "revisit_keyframes": 9,
                                          "closed_keyframes": 6}}}

    def test_our_report_is_read(self):
        self.assertEqual(compare_loops.our_loops(self.REPORT),
                         closures.Score(7, 1, 0.5, 0.25, 9, 6))
        self.assertEqual(compare_loops.our_end_s(self.REPORT), 0.75)
        self.assertIsNone(compare_loops.our_loops({}))

    def test_what_was_in_the_graph_meanwhile_is_said(self):
        truth = {"accepted": 7, "false_accepted": 0, "dropped": 3, "false_dropped": 2}
        line = loops.counts({"proposals": 30, "odometry_variance_factor": 2.5,
                             "against_truth": truth})
        self.assertIn("7 accepted, 0 of them false; 3 dropped in the end, 2 of them false", line)
        self.assertIn("2.50", line)

    def test_errors_of_no_loops_are_not_zero(self):
        truth = dict(self.REPORT["loops"]["against_truth"], accepted=0, error_p95_m=0.0)
        score = compare_loops.our_loops({"loops": {"against_truth": truth}})
        self.assertTrue(np.isnan(score.error_p95_m))

    def test_what_was_not_measured_is_null(self):
        row = compare_loops.Row("x", 0.1, 0.2, np.array([1.0]))
        out = compare_loops.as_json(dataclasses.asdict(row))
        self.assertEqual(out["ms"], [1.0])
        self.assertIsNone(out["end_s"])

    def test_a_line_has_the_columns_of_the_header(self):
        full = compare_loops.Row("x", 0.1, 0.2, np.array([1.0, 2.0, 30.0]), 4.0, 0.5, 600.0, 200.0,
                                 compare_loops.our_loops(self.REPORT))
        line = compare_loops.text(full)
        self.assertEqual(len(line), len(compare_loops.HEADER))
        self.assertIn("6/9", line)
        self.assertIn("600 (200)", line)
        bare = compare_loops.text(compare_loops.Row("x", 0.1, 0.2))
        self.assertEqual(len(bare), len(compare_loops.HEADER))
        self.assertNotIn("nan", bare)


class Peers(unittest.TestCase):
    def test_instants_of_deskewing(self):
        self.assertAlmostEqual(registrars.deskew_reference(registrars.Kiss), 1.0)
        self.assertAlmostEqual(registrars.deskew_reference(registrars.GenZ), 0.5)

    def test_poses_belong_to_the_instant_deskewed_to_once_there_is_a_motion(self):
        np.testing.assert_allclose(registrars.pose_instants("kiss", "cw", 4), [0.5, 0.5, 1.0, 1.0])
        np.testing.assert_allclose(registrars.pose_instants("kiss-slam-odometry", "cw", 3), [0.5, 0.5, 1.0])
        for key, spin in (("genz", "cw"), ("ours", "cw"), ("kiss", None), ("gicp", None)):
            np.testing.assert_allclose(registrars.pose_instants(key, spin, 3), 0.5, atol=1e-9)


if __name__ == "__main__":
    unittest.main()
