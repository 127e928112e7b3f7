"""Tests of benchmarks/accuracy without running anything: python accuracy_test.py."""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np

from bench import accuracy_tables, comparison, machine, poses, scores, trials
from bench_test import chain, step

HERE = pathlib.Path(__file__).resolve().parent


def folder_of_scans(folder, count=3):
    for k in range(count):
        np.ones((5 + k, 4), dtype=np.float32).tofile(pathlib.Path(folder) / f"{k:06d}.bin")
    return pathlib.Path(folder)


def trial_in(folder, system="kiss"):
    folder = pathlib.Path(folder)
    (folder / "scans").mkdir()
    scans = trials.scans_of(folder_of_scans(folder / "scans"), None, 0.205, judge_map=False)
    return trials.Trial(scans, system, folder / "tvl", folder / "out")


class Scores(unittest.TestCase):
    T_CAM0_LIDAR = step(0.3, 90.0)

    def test_a_perfect_estimate_of_other_instants_has_no_error(self):
        half_steps = chain(step(0.5, 0.25), 602)
        truth_lidar = half_steps[::2]
        truth_cam0 = poses.to_camera(truth_lidar, self.T_CAM0_LIDAR)
        instants = np.array([0.5, 0.5] + [1.0] * 299)
        estimate = half_steps[[0, 2] + [2 * k + 1 for k in range(2, 301)]]
        truth = scores.truth_at(truth_cam0, self.T_CAM0_LIDAR, instants)
        for name, value in scores.figures(truth, estimate, self.T_CAM0_LIDAR).items():
            self.assertAlmostEqual(value, 0.0, delta=0.01, msg=name)
        unshifted = scores.truth_at(truth_cam0, self.T_CAM0_LIDAR, 0.5)
        self.assertGreater(scores.figures(unshifted, estimate, self.T_CAM0_LIDAR)["end_m"], 0.4)

    def test_figures_of_a_known_scale(self):
        T = self.T_CAM0_LIDAR
        found = scores.figures(chain(step(1.0), 301), chain(step(1.01), 301), T)
        self.assertAlmostEqual(found["t_err_pct"], 1.0, delta=0.02)
        self.assertAlmostEqual(found["end_m"], 3.0)
        self.assertAlmostEqual(found["heading_deg_per_km"], 0.0)
        self.assertLess(found["ate_m"], found["ate_first_m"])

    def test_heading_error_and_its_sign(self):
        found = scores.figures(chain(step(1.0), 301), chain(step(1.0, -0.001), 301), np.eye(4))
        self.assertAlmostEqual(found["heading_deg_per_km"], 1.0)
        self.assertAlmostEqual(found["heading_signed_deg_per_km"], -1.0)


class Trials(unittest.TestCase):
    def run_with(self, trial, rows):
        with mock.patch.object(trials, "_rows", rows):
            return trials.run(trial)

    def test_what_is_stored_is_found_until_what_it_was_made_of_changes(self):
        with tempfile.TemporaryDirectory() as folder:
            trial, truth = trial_in(folder), chain(step(1.0, 2.0), 3)
            self.assertIsNone(trials.stored(trial))
            self.run_with(trial, lambda _: {"kiss": (truth, np.array([1.0, 2.0, 9.0]))})
            found = trials.stored(trial)
            np.testing.assert_allclose(trials.trajectory_of(trial, found["rows"]["kiss"]), truth,
                                       atol=1e-8)
            self.assertEqual(found["rows"]["kiss"]["ms"], [1.0, 2.0, 9.0])
            with mock.patch.object(trials, "version_of", return_value="another"):
                self.assertIsNone(trials.stored(trial))
            np.ones(400, dtype=np.float32).tofile(trial.scans.files[0])
            self.assertIsNone(trials.stored(trial))

    def test_a_failure_is_an_error_without_the_folder_and_is_tried_again(self):
        with tempfile.TemporaryDirectory() as folder:
            trial = trial_in(folder)

            def refuse(_):
                raise RuntimeError(f"tvl: exit code 2\n{trial.scans.folder}/calib.txt: missing")
            result = self.run_with(trial, refuse)
            self.assertEqual(result["error"], "scans/calib.txt: missing")
            self.assertIsNone(trials.stored(trial))

    def test_a_pose_too_few_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            result = self.run_with(trial_in(folder),
                                   lambda _: {"kiss": (chain(step(1.0), 2), np.ones(2))})
            self.assertIn("2 poses of 3 scans", result["error"])

    def test_which_systems_close_loops(self):
        closing = [name for name, system in trials.SYSTEMS.items() if system.closes_loops]
        self.assertEqual(closing, ["kiss-slam", "ours-lidar-loops", "ours-loops"])
        cameras = [name for name, system in trials.SYSTEMS.items() if system.needs_camera]
        self.assertEqual(cameras, ["ours", "ours-loops"])

    def test_one_run_gives_both_rows_of_kiss_slam(self):
        done = {"kiss-slam": ("trial", {"rows": {"kiss-slam": 1, "kiss-slam-odometry": 2}})}
        rows = list(comparison.rows_of(done, ["kiss", "kiss-slam-odometry", "kiss-slam"]))
        self.assertEqual(rows, [("kiss-slam-odometry", "trial", 2, None),
                                ("kiss-slam", "trial", 1, None)])


def runs_of(values):
    """system -> t_err of each seed, as runs."""
    return [{"seed": seed, "system": system, "figures": {"t_err_pct": value, "ms_p50": None}}
            for system, series in values.items() for seed, value in enumerate(series)]


def drive_of(values):
    runs = runs_of(values)
    return {"kind": "city", "label": "a city", "frames": 10, "path_m": [7.0, 9.0], "seeds": [0, 1],
            "spin": None, "runs": runs, "summary": accuracy_tables.summary(runs)}


class Tables(unittest.TestCase):
    VALUES = {"kiss": [0.2, 0.4], "genz": [0.1, 0.3], "ours": [0.1, 0.2], "kiss-slam": [0.05, 0.05],
              "ours-loops": [0.1, 0.1]}

    def test_mean_and_spread_over_seeds(self):
        found = accuracy_tables.summary(runs_of(self.VALUES))
        self.assertAlmostEqual(found["kiss"]["t_err_pct"]["mean"], 0.3)
        self.assertAlmostEqual(found["kiss"]["t_err_pct"]["sd"], math.sqrt(0.02))
        self.assertEqual(found["kiss"]["t_err_pct"]["count"], 2)
        self.assertNotIn("ms_p50", found["kiss"])
        self.assertIsNone(accuracy_tables.summary(runs_of({"kiss": [0.2]}))["kiss"]["t_err_pct"]["sd"])

    def test_odometry_is_compared_with_odometry_and_loops_with_all(self):
        found = accuracy_tables.summary(runs_of(self.VALUES))
        self.assertAlmostEqual(accuracy_tables.ratio(found, "ours", "t_err_pct"), 0.15 / 0.2)
        self.assertAlmostEqual(accuracy_tables.ratio(found, "ours-loops", "t_err_pct"), 2.0)
        self.assertAlmostEqual(accuracy_tables.ratio(found, "kiss", "t_err_pct"), 1.5)
        self.assertIsNone(accuracy_tables.ratio(
            accuracy_tables.summary(runs_of({"ours": [0.1]})), "ours", "t_err_pct"))

    def test_every_line_has_the_columns_of_its_header(self):
        recording = {"name": "street", "frames": 6, "spin": None, "runs": [
            {"system": "ours-lidar", "error": "no calib.txt"},
            {"system": "kiss", "figures": {
                "from_median_m": 0.1, "entropy": -3.0, "entropy_points": 5, "thickness_mm": 12.0,
                "planar_voxels": 7, "planar_points": 70, "ms_p50": None}}]}
        tables = (accuracy_tables.drive_table(drive_of(self.VALUES)),
                  accuracy_tables.ratio_table([drive_of(self.VALUES)]),
                  accuracy_tables.recording_table([recording]))
        for table in tables:
            bars = {row.count("|") for row in table if row.startswith("|")}
            self.assertEqual(len(bars), 1, table)
        self.assertIn("| GenZ-ICP | 0.200 ± 0.141 (1.00) |", "\n".join(tables[0]))
        self.assertIn("0.75 (GenZ-ICP)", "\n".join(tables[1]))
        self.assertIn("2.00 (KISS-SLAM)", "\n".join(tables[1]))
        self.assertIn("refused: no calib.txt", "\n".join(tables[2]))

    def test_a_failed_seed_is_named(self):
        drive = drive_of(self.VALUES)
        drive["runs"].append({"seed": 1, "system": "ours", "error": "lost"})
        self.assertIn("Seed 1, tvl: lost", accuracy_tables.drive_table(drive))

    def test_where_raw_scans_are_deskewed_to_is_said(self):
        said = accuracy_tables.deskewing_text(comparison.deskewing_instants())
        self.assertIn("tvl 0.50, KISS-ICP 1.00, GenZ-ICP 0.50, KISS-SLAM 1.00", said)

    def test_only_what_lies_between_the_markers_is_replaced(self):
        document = f"a\n{accuracy_tables.BEGIN}\nold\n{accuracy_tables.END}\nb\n"
        once = accuracy_tables.replaced(document, "new\n")
        self.assertEqual(once, f"a\n{accuracy_tables.BEGIN}\nnew\n{accuracy_tables.END}\nb\n")
        self.assertEqual(accuracy_tables.replaced(once, "new\n"), once)
        for broken in ("a\n", f"{accuracy_tables.BEGIN}\n"):
            with self.assertRaises(ValueError):
                accuracy_tables.replaced(broken, "new")

    def test_the_document_has_its_markers(self):
        text = (HERE.parent / "docs/evaluation.md").read_text()
        self.assertIn("\nnew\n", accuracy_tables.replaced(text, "new"))


class Program(unittest.TestCase):
    def said(self, *arguments):
        done = subprocess.run([sys.executable, HERE / "accuracy", *arguments], capture_output=True,
                              text=True, check=False)
        return done.returncode, done.stderr

    def test_short_figures_never_reach_the_documents(self):
        code, said = self.said("--out", "nowhere", "--quick", "--update-docs")
        self.assertEqual(code, 2)
        self.assertIn("--quick", said)

    def test_an_unknown_drive_is_refused(self):
        code, said = self.said("--out", "nowhere", "--drives", "moon")
        self.assertEqual(code, 2)
        self.assertIn("no drive moon", said)

    def test_a_drive_along_a_recorded_way_needs_it(self):
        args = argparse.Namespace(drives=["route06"], data=None)
        self.assertEqual(comparison.measure_drives(args, None, []), [])

    def test_numbers_that_do_not_exist_are_null(self):
        found = comparison.with_time({"t_err_pct": math.nan, "end_m": 1.0}, {"ms": [1.0, 3.0, 2.0]})
        self.assertEqual(json.dumps(found), '{"t_err_pct": null, "end_m": 1.0, "ms_p50": 2.0}')

    def test_what_a_measurement_was_made_with(self):
        commit = machine.checkout()["commit"]
        self.assertTrue(commit is None or len(commit) == 40)  # None: not a git checkout
        self.assertTrue(machine.cpu_model())
        self.assertIsNone(machine.version("no-such-package-here"))


if __name__ == "__main__":
    unittest.main()
