"""Tests of benchmarks/uncertainty.py without running anything: python uncertainty_test.py."""

import contextlib
import io
import json
import pathlib
import tempfile
import unittest

import numpy as np

import uncertainty
from bench_test import chain, step

STEPS = 120


class Judge(unittest.TestCase):
    """A straight way with steps of 1 m."""

    def judge(self, estimate, walk=0.0, bias=(1e-9, 1e-9, 1e-9, 1e-9)):
        truth = chain(step(1.0), STEPS)
        noise = [1e-6 * np.eye(6)] * len(truth)
        return uncertainty.judge(truth, estimate, noise, [walk * np.eye(6)] * len(truth),
                                 np.array(bias))

    def test_a_perfect_run_has_none(self):
        rows = self.judge(chain(step(1.0), STEPS))
        self.assertTrue(rows[1] and rows[10] and rows[100])
        self.assertFalse(rows[400])
        self.assertAlmostEqual(np.max(rows[10]), 0.0)

    def test_a_wrong_scale_is_what_the_bias_of_the_scale_says(self):
        for distance, found in self.judge(chain(step(1.001), STEPS), bias=(1e-9, 1e-9, 1e-9, 1e-3)).items():
            for row in found:
                expected = (1e-3 * distance) ** 2 / (2e-6 + (1e-3 * distance) ** 2)
                self.assertAlmostEqual(row[6], expected, delta=0.01, msg=distance)

    def test_noise_counts_at_both_ends_and_walk_at_every_step(self):
        ten = self.judge(chain(step(1.001), STEPS), walk=1e-5)[10][0]
        self.assertAlmostEqual(ten[6], 0.01**2 / (2e-6 + 10 * 1e-5), delta=0.02)

    def test_a_step_carries_errors_of_rotation_over_the_way(self):
        window = uncertainty.Window()
        for _ in range(100):
            window.add(step(1.0), np.zeros((6, 6)))
        covariance = window.covariance(np.eye(4), np.zeros((6, 6)), np.zeros((6, 6)),
                                       np.array([0.0, 3e-5, 0.0, 0.0]))
        self.assertAlmostEqual(np.sqrt(covariance[1, 1]), 3e-3)
        self.assertAlmostEqual(np.sqrt(covariance[5, 5]), 0.5 * 100**2 * 3e-5, delta=0.002)


class Files(unittest.TestCase):
    def test_an_input_that_is_not_there_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "run.json").write_text(json.dumps({"input": "nowhere"}))
            with self.assertRaises(SystemExit) as ended, contextlib.redirect_stderr(io.StringIO()):
                uncertainty.read(folder)
            self.assertIn("nowhere", str(ended.exception))


if __name__ == "__main__":
    unittest.main()
