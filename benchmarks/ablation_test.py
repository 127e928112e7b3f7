"""Tests of benchmarks/ablation.py without running anything: python ablation_test.py."""

import argparse
import contextlib
import io
import json
import pathlib
import tempfile
import unittest
from unittest import mock

import numpy as np

import ablation as program
from accuracy_test import folder_of_scans
from bench import ablation, ablation_tables, accuracy_tables, drives, ours, poses, trials
from bench_test import chain, step

HERE = pathlib.Path(__file__).resolve().parent


def documented_options():
    """section.option of docs/options.md."""
    found, sections = set(), []
    for text in (HERE.parent / "docs/options.md").read_text().splitlines():
        if text.startswith("## "):
            sections = [part for k, part in enumerate(text.split("`")) if k % 2 == 1]
        elif text.startswith("| `"):
            found |= {f"{section}.{text.split('`')[1]}" for section in sections}
    return found


class Variants(unittest.TestCase):
    def test_only_options_that_exist_are_changed(self):
        known = documented_options()
        self.assertIn("mapping.beams.enabled", known)
        for name, variant in ablation.VARIANTS.items():
            for key, _ in variant.overrides:
                self.assertIn(key, known, name)

    def test_the_defaults_are_first_and_every_other_variant_differs(self):
        configs = [variant.config() for variant in ablation.VARIANTS.values()]
        self.assertEqual(configs[0], "")
        self.assertEqual(len(set(configs)), len(configs))
        self.assertIn("odometry.enabled: false\n", ablation.VARIANTS["no-odometry"].config())
        self.assertIn("interval: 5", ablation.VARIANTS["paper"].config())

    def test_every_simulated_scene_can_be_written(self):
        names = set()
        for scene in ablation.SCENES.values():
            if scene.is_simulated:
                uri = ablation.uri_of(scene, pathlib.Path("data"))
                drives.simulate_arguments(uri, lidar_only=not scene.with_camera)
                names.add(drives.name_of(uri))
                self.assertEqual("camera=0" not in uri, scene.with_camera)
        self.assertEqual(len(names), sum(s.is_simulated for s in ablation.SCENES.values()))
        sine = ablation.SCENES["beams-sine"].source
        arguments = drives.simulate_arguments(sine, lidar_only=True)
        self.assertEqual(arguments[arguments.index("--beam-error-shape") + 1], "sine")

    def test_options_of_a_run(self):
        scans = argparse.Namespace(spin="cw")
        said = ablation.options_of(ablation.SCENES["kitti360-lidar"], scans, "config.yaml")
        self.assertEqual(said, ["--deskew", "cw", "--threads", 1, "--no-loops", "--lidar-only",
                                "--config", "config.yaml"])
        self.assertNotIn("--lidar-only", ablation.options_of(ablation.SCENES["kitti360"], scans, None))


def run_in(folder, trajectory, cpu_s=0.3):
    frames = [{"status": "first", "total_ms": 90.0}] + [
        {"status": "tracked", "total_ms": 10.0} for _ in trajectory[1:]]
    report = {"frames": frames, "timing": {"odometry": {"p50_ms": 2.0, "mean_ms": 3.0}}}
    return ours.Run(pathlib.Path(folder), trajectory, report, cpu_s)


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "scans").mkdir()
        (self.folder / "scans/calib.txt").write_text("Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n")
        self.scans = trials.scans_of(folder_of_scans(self.folder / "scans"), None, 0.205,
                                     judge_map=False)
        (self.folder / "tvl").write_text("program")
        self.args = argparse.Namespace(binary=self.folder / "tvl", out=self.folder, resume=True,
                                       data=None)

    def measure(self, variant, run):
        with mock.patch.object(ours, "run", run):
            return ablation.measure(self.args, ablation.SCENES["route08"], self.scans,
                                    ablation.VARIANTS[variant], self.folder / "out")

    def test_a_result_is_taken_again_until_the_options_change(self):
        run = mock.Mock(return_value=run_in(self.folder, chain(step(1.0), 3)))
        first = self.measure("no-odometry", run)
        self.assertAlmostEqual(first["figures"]["cpu_ms"], 100.0)
        self.assertEqual(first["figures"]["tracked"], 2)
        self.assertEqual(self.measure("no-odometry", run), json.loads(json.dumps(first)))
        self.assertEqual(run.call_count, 1)
        self.measure("no-edges", run)
        self.assertEqual(run.call_count, 2)
        config = pathlib.Path(run.call_args.args[-1])
        self.assertIn("mapping.scan_to_map.edge_sigma_m: 1000.0", config.read_text())

    def test_a_failure_is_an_error_and_is_tried_again(self):
        run = mock.Mock(side_effect=RuntimeError(f"tvl: exit code 2\n{self.folder}/scans: bad"))
        self.assertEqual(self.measure("default", run)["error"], "scans: bad")
        self.measure("default", run)
        self.assertEqual(run.call_count, 2)

    def test_figures_against_truth(self):
        poses.write_poses(self.folder / "scans/poses.txt", chain(step(1.0), 3))
        figures = ablation.figures_of(run_in(self.folder, chain(step(1.1), 3)), self.scans)
        self.assertAlmostEqual(figures["end_m"], 0.2)
        self.assertIsNone(figures["t_err_pct"])  # too short for it
        self.assertEqual(figures["stage_p50_ms"], {"odometry": 2.0})
        json.dumps(figures)

    def test_ends_are_compared_with_the_peers_and_the_defaults(self):
        runs = [{"variant": "default", "figures": {"end_xyz_m": [1.0, 0.0, 0.0]}},
                {"variant": "paper", "figures": {"end_xyz_m": [1.0, 2.0, 0.0]}},
                {"variant": "no-edges", "error": "lost"}]
        found = ablation.with_distances(runs, np.array([0.0, 2.0, 0.0]))
        self.assertAlmostEqual(found[1]["figures"]["from_median_m"], 1.0)
        self.assertAlmostEqual(found[1]["figures"]["from_default_m"], 2.0)
        self.assertEqual(found[0]["figures"]["from_default_m"], 0.0)
        self.assertNotIn("figures", found[2])


def scene_of(name, figures, simulated):
    return {"scene": name, "label": name, "simulated": simulated, "path_m": 100.0 if simulated else None,
            "runs": [{"variant": variant, "figures": {"frames": 10, "tracked": 9} | values}
                     for variant, values in figures.items()]}


class Tables(unittest.TestCase):
    MADE = {"date": "2026-01-02T03:04:05", "binary": {"version": "0.1.0", "commit": "abcdef0123"},
            "checkout": {"commit": None, "dirty": False}, "machine": {"cpu": "a processor", "load_average": [1.5, 1.0, 1.0]}}

    def test_a_cell_a_variant_and_scene(self):
        drive = scene_of("street", {"paper": {"t_err_pct": 0.5, "ate_m": 0.25, "cpu_ms": 30.2},
                                    "default": {"t_err_pct": None, "ate_m": 0.1, "cpu_ms": 20.0}}, True)
        lost = scene_of("field", {"default": {"from_median_m": 0.1, "thickness_mm": 14.0,
                                              "entropy": -3.0, "tracked": 5, "cpu_ms": 1.0}}, False)
        lost["runs"].append({"variant": "paper", "error": "lost"})
        said = ablation_tables.markdown({"made": self.MADE, "scenes": [drive, lost]})
        self.assertIn("| config/paper.yaml | 0.500, 0.250 |", said)
        self.assertIn("| default | -, 0.100 |", said)
        self.assertLess(said.index("| default |"), said.index("| config/paper.yaml |"))
        self.assertIn("| default | 0.100, 14.00, -3.000 (4) |", said)
        self.assertIn("| config/paper.yaml | failed |", said)
        self.assertIn("| config/paper.yaml | 30 | failed |", said)
        self.assertIn("commit abcdef0", said)
        self.assertIn("Load 1.5", said)

    def test_what_changes_nothing_is_a_dash(self):
        self.assertEqual(ablation_tables.cell(scene_of("street", {}, True), "no-landmarks",
                                              ablation_tables.SIMULATED), "-")

    def test_the_document_has_its_markers(self):
        text = (HERE.parent / "docs/evaluation.md").read_text()
        markers = (ablation_tables.BEGIN, ablation_tables.END)
        replaced = accuracy_tables.replaced(text, "new", markers)
        self.assertIn("\nnew\n", replaced)
        self.assertIn(accuracy_tables.BEGIN, replaced)


class Program(unittest.TestCase):
    def test_unknown_names_are_refused(self):
        for option in ("--variants", "--scenes"):
            said = io.StringIO()
            with contextlib.redirect_stderr(said), self.assertRaises(SystemExit):
                program.parse(["--out", "nowhere", option, "moon"])
            self.assertIn("no moon", said.getvalue())

    def test_without_data_what_needs_none_remains(self):
        args = program.parse(["--out", "nowhere"])
        args.data = None
        with contextlib.redirect_stdout(io.StringIO()):
            scenes = program.with_data(args)
        self.assertIn("city131", scenes)
        self.assertNotIn("route08", scenes)
        self.assertNotIn("kitti360", scenes)


if __name__ == "__main__":
    unittest.main()
