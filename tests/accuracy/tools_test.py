"""Tests of scripts/accuracy: faulty copies, judgement of runs, figures and bounds, on known answers."""

import math
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from accuracy import fault_cases, faulty, figures, gate, judge, poses  # noqa: E402


def straight(count, step_m=1.0):
    """Poses of camera 0 (z forward) along a straight line."""
    return [(1, 0, 0, 0.0, 0, 1, 0, 0.0, 0, 0, 1, step_m * k) for k in range(count)]


def turned(degrees):
    """A rotation about camera 0's y axis."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (c, 0.0, s, 0.0, 0.0, 1.0, 0.0, 0.0, -s, 0.0, c, 0.0)


def plain(count):
    return [faulty.Frame(k, 0.1 * k, k, k) for k in range(count)]


def moved(line, first, aside_m):
    """The poses with all from `first` on moved along the line."""
    return [p[:11] + (p[11] + aside_m * (k >= first),) for k, p in enumerate(line)]


def run_of(line, statuses):
    return judge.Run(line, statuses, {})


class Poses(unittest.TestCase):
    def test_products_and_inverses(self):
        a = poses.product(turned(30), straight(4)[3])
        self.assertAlmostEqual(poses.length_m(poses.between(a, a)), 0.0)
        self.assertAlmostEqual(poses.angle_deg(a), 30.0)
        self.assertAlmostEqual(poses.length_m(a), 3.0)
        self.assertAlmostEqual(poses.rotation_vector(a)[1], math.radians(30))

    def test_files_come_back(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "poses.txt"
            poses.write(path, straight(3))
            self.assertEqual(poses.read(path), [tuple(map(float, p)) for p in straight(3)])


class Judgement(unittest.TestCase):
    TRUTH = straight(20)

    def test_a_right_run(self):
        verdict = judge.judge(self.TRUTH, run_of(self.TRUTH, ["first"] + 19 * ["tracked"]))
        self.assertEqual((verdict.silent, verdict.found_after), (0, 1))
        self.assertAlmostEqual(verdict.end_m, 0.0)
        self.assertAlmostEqual(verdict.path_m, 19.0)

    def test_one_wrong_step_is_one_silent_error(self):
        run = run_of(moved(self.TRUTH, 10, 0.4), ["first"] + 19 * ["degraded"])
        verdict = judge.judge(self.TRUTH, run)
        self.assertEqual(verdict.silent_frames, [10])
        self.assertAlmostEqual(verdict.worst_m, 0.4)
        self.assertAlmostEqual(verdict.end_m, 0.4)
        small = run_of(moved(self.TRUTH, 10, 0.2), run.statuses)
        self.assertEqual(judge.judge(self.TRUTH, small).silent, 0)

    def test_a_wrong_turn_is_a_silent_error(self):
        line = self.TRUTH[:10] + [poses.product(p, turned(4)) for p in self.TRUTH[10:]]
        verdict = judge.judge(self.TRUTH, run_of(line, ["first"] + 19 * ["tracked"]))
        # The steps after the turn start from a wrong heading: their motion is off, too.
        self.assertIn(10, verdict.silent_frames)
        self.assertAlmostEqual(verdict.worst_deg, 4.0)

    def test_what_is_said_to_be_lost_is_not_silent(self):
        line = moved(self.TRUTH, 8, 5.0)
        line[12:] = self.TRUTH[12:]
        statuses = ["first"] + 7 * ["tracked"] + 2 * ["predicted"] + 2 * ["lost"] + 8 * ["tracked"]
        verdict = judge.judge(self.TRUTH, run_of(line, statuses), fault_frame=8)
        self.assertEqual((verdict.silent, verdict.found_after), (0, 4))

    def test_found_at_a_wrong_place_is_silent(self):
        line = moved(self.TRUTH, 8, 5.0)
        statuses = ["first"] + 7 * ["tracked"] + 4 * ["lost"] + 8 * ["tracked"]
        verdict = judge.judge(self.TRUTH, run_of(line, statuses), fault_frame=8)
        self.assertEqual(verdict.silent_frames, [12])

    def test_where_the_map_begins_anew_a_step_may_begin(self):
        line = moved(self.TRUTH, 8, 5.0)
        statuses = ["first"] + 7 * ["tracked"] + 4 * ["lost"] + 8 * ["tracked"]
        frames = [{"map_begins_anew": k == 11} for k in range(20)]
        run = judge.Run(line, statuses, {"frames": frames})
        self.assertEqual(judge.judge(self.TRUTH, run).silent_frames, [])
        wrong = moved(line, 14, 1.0)  # a wrong step after it is silent all the same
        run = judge.Run(wrong, statuses, {"frames": frames})
        self.assertEqual(judge.judge(self.TRUTH, run).silent_frames, [14])

    def test_dead_reckoning_that_says_so_may_drift(self):
        line = moved(self.TRUTH, 8, 0.5)  # half a metre, where nothing is claimed
        for status, silent in (("predicted", []), ("lost", list(range(12, 13)))):
            statuses = ["first"] + 7 * ["tracked"] + 4 * [status] + 8 * ["tracked"]
            verdict = judge.judge(self.TRUTH, run_of(line, statuses))
            self.assertEqual(verdict.silent_frames, silent, status)
        wrong = moved(line, 12, 1.0)  # the step after it is wrong itself
        statuses = ["first"] + 7 * ["tracked"] + 4 * ["predicted"] + 8 * ["tracked"]
        self.assertEqual(judge.judge(self.TRUTH, run_of(wrong, statuses)).silent_frames, [12])

    def test_found_by_the_absolute_pose_after_drift(self):
        # Frame 7 was already wrong, and said to be tracked: one error, not two.
        line = moved(self.TRUTH, 7, 1.0)
        line[12:] = self.TRUTH[12:]
        statuses = ["first"] + 7 * ["tracked"] + 4 * ["lost"] + 8 * ["tracked"]
        self.assertEqual(judge.judge(self.TRUTH, run_of(line, statuses)).silent_frames, [7])

    def test_delivered_frames_keep_their_physical_pose(self):
        frames = [f for f in plain(10) for _ in range(2)][4:]
        reference = judge.reference_of(self.TRUTH, frames)
        self.assertEqual([p[11] for p in reference[:4]], [0.0, 0.0, 1.0, 1.0])


class Cases(unittest.TestCase):
    def setUp(self):
        self.plain = plain(200)
        self.way_m = [1.2 * k for k in range(200)]

    def test_stamps_change_nothing_else(self):
        for case in fault_cases.stamps(self.plain):
            self.assertEqual([f.scan for f in case.frames], list(range(200)), case.name)
            self.assertNotEqual([f.stamp_s for f in case.frames],
                                [f.stamp_s for f in self.plain], case.name)

    def test_lost_frames_are_gone(self):
        cases = {c.name: c for c in fault_cases.lost(self.plain)}
        self.assertEqual(len(cases), 3 * (len(fault_cases.LOST) + 2))
        renumbered = cases["10 lost, renumbered"].frames
        self.assertEqual(len(renumbered), 190)
        self.assertEqual(renumbered[30].physical, 40)
        self.assertAlmostEqual(renumbered[30].stamp_s, 3.0)
        self.assertAlmostEqual(cases["10 lost, stamped"].frames[30].stamp_s, 4.0)
        self.assertEqual(cases["10 lost, gap"].frames[39].scan, faulty.ABSENT)
        self.assertEqual(cases["every 3., renumbered"].frames[2].physical, 6)
        self.assertNotEqual(cases["every 3., gap"].frames[-1].scan, faulty.ABSENT)

    def test_kidnapping_comes_back_aside(self):
        cases = {c.name: c for c in fault_cases.kidnap(self.plain, self.way_m)}
        aside = cases["30 dark, 5 m aside"]
        self.assertEqual(aside.frames[69].scan, faulty.EMPTY)
        self.assertEqual(aside.frames[70].physical, 75)  # five times 1.2 m
        self.assertEqual(aside.fault_frame, 70)

    def test_pauses_need_a_stand(self):
        self.assertEqual(fault_cases.pause(self.plain, self.way_m), [])
        way_m = [min(1.2 * k, 120.0) for k in range(200)]
        names = [c.name for c in fault_cases.pause(self.plain, way_m)]
        self.assertIn("pause while braking, stamped", names)


class Copies(unittest.TestCase):
    def test_links_stamps_and_black_images(self):
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "source"
            for name in ("velodyne", "image_2"):
                (source / name).mkdir(parents=True)
            for k in range(5):
                (source / "velodyne" / f"{k:06d}.bin").write_bytes(bytes([k]) * 16)
                (source / "image_2" / f"{k:06d}.png").write_bytes(faulty.black_png(4, 2))
            (source / "calib.txt").write_text("Tr: 1\n")
            (source / "poses.txt").write_text("truth\n")
            recording = faulty.open_recording(source)
            frames = faulty.plain(recording)
            frames[1] = faulty.Frame(1, 0.5, faulty.EMPTY, faulty.EMPTY)
            frames[2] = faulty.Frame(2, 0.6, faulty.ABSENT, 4)
            copy = faulty.write(recording, frames, pathlib.Path(folder) / "copy")
            self.assertEqual((copy / "velodyne/000001.bin").read_bytes(), b"")
            self.assertFalse((copy / "velodyne/000002.bin").exists())
            self.assertEqual((copy / "velodyne/000003.bin").read_bytes(), bytes([3]) * 16)
            self.assertEqual(faulty.png_size(copy / "image_2/000001.png"), (4, 2))
            self.assertFalse((copy / "image_2/000001.png").is_symlink())
            self.assertFalse((copy / "poses.txt").exists())
            stamps = (copy / "times.txt").read_text().split()
            self.assertEqual([float(s) for s in stamps[:3]], [0.0, 0.5, 0.6])


class Figures(unittest.TestCase):
    # x of the lidar is z of camera 0, y is -x, z is -y.
    T_CAM0_LIDAR = (0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0)

    def test_kitti_errors_of_a_known_scale(self):
        t_err, r_err = figures.kitti_errors(straight(301), straight(301, 1.01))
        # Segments end at the first frame beyond the length: 101 steps for 100 m.
        self.assertAlmostEqual(t_err, 1.0, delta=0.02)
        self.assertAlmostEqual(r_err, 0.0)
        self.assertTrue(math.isnan(figures.kitti_errors(straight(50), straight(50))[0]))

    def test_linear_equations(self):
        x = figures.solve([[0.0, 2.0, 1.0], [1.0, 1.0, 0.0], [3.0, 0.0, 1.0]], [7.0, 3.0, 6.0])
        for value, expected in zip(x, (1.0, 2.0, 3.0)):
            self.assertAlmostEqual(value, expected)

    def test_steps_too_long_by_1_cm_and_what_their_covariance_says(self):
        covariance = [0.0] * 36
        for i in range(6):
            covariance[7 * i] = 1e-4  # 1 cm, 0.01 rad
        report = {"frames": [{"step_covariance": covariance}] * 20}
        run = judge.Run(straight(20, 1.01), ["first"] + 19 * ["tracked"], report)
        found = figures.step_figures(straight(20), run, self.T_CAM0_LIDAR)
        self.assertAlmostEqual(found["step_forward_mm"], 10.0)
        self.assertAlmostEqual(found["step_left_mm"], 0.0)
        self.assertAlmostEqual(found["step_yaw_mdeg"], 0.0)
        self.assertAlmostEqual(found["nees_translation"], 1.0 / 3)
        self.assertAlmostEqual(found["claimed_mm"], 10.0)
        self.assertAlmostEqual(found["claimed_mdeg"], math.degrees(10.0))


class Bounds(unittest.TestCase):
    def test_every_figure_has_a_rule_that_holds_for_itself(self):
        for name in ("t_err_pct", "step_up_mm", "thickness_mm", "nees_rotation", "claimed_mm", "map_planes",
                     "map_plane_rms_mm", "end_m"):
            bound = gate.bound_of("drive", name, 10.0)
            self.assertLess(bound.lower, 10.0)
            self.assertGreater(bound.upper, 10.0)
        with self.assertRaises(ValueError):
            gate.rule_of("colour")

    def test_silent_errors_are_never_allowed(self):
        self.assertEqual(gate.bound_of("drive", "silent_errors", 7.0).upper, 0.0)

    def test_what_is_out_of_bounds_is_said(self):
        bounds = [gate.bound_of("drive", "t_err_pct", 1.0), gate.bound_of("drive", "end_m", 1.0)]
        self.assertEqual(gate.broken("drive", {"t_err_pct": 1.2, "end_m": 0.1}, bounds), [])
        self.assertIn("t_err_pct 1.4", gate.broken("drive", {"t_err_pct": 1.4, "end_m": 1.0}, bounds)[0])
        self.assertIn("no figure end_m", gate.broken("drive", {"t_err_pct": 1.0}, bounds)[0])
        self.assertIn("no bound for new", gate.broken(
            "drive", {"t_err_pct": 1.0, "end_m": 1.0, "new": 1.0}, bounds)[0])

    def test_the_table_comes_back(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bounds.txt"
            bounds = [gate.bound_of("drive", "t_err_pct", 1.0), gate.bound_of("drive", "end_m", 0.5)]
            gate.write_bounds(bounds, path)
            self.assertEqual(gate.read_bounds(path), bounds)

    def test_the_faulty_drive_has_its_faults(self):
        frames = gate.faulty_frames(plain(320))
        steps = [b.physical - a.physical for a, b in zip(frames, frames[1:])]
        self.assertEqual((steps.count(0), sorted(steps)[-2:]), (2, [3, 4]))
        self.assertEqual(sum(f.scan == faulty.ABSENT for f in frames), 2)
        self.assertEqual(sum(f.image == faulty.EMPTY for f in frames), 5)


if __name__ == "__main__":
    unittest.main()
