"""A traffic jam, simulated: lorries and cars creep on all sides and fill the scan."""

import pathlib
import sys
import unittest

from program import OK, Folder, tvl

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from accuracy import judge, poses  # noqa: E402

FRAMES = 160  # the vehicle starts, creeps and stops


class Jam(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.addClassCleanup(cls.folder.close)
        made = tvl("simulate", "--out", cls.folder / "jam", "--preset", "jam", "--seed", 8,
                   "--frames", FRAMES)
        assert made.returncode == OK, made.stderr
        cls.truth = poses.read(cls.folder / "jam/poses.txt")

    def run_with(self, *options):
        """The run and its judge.Verdict."""
        out = self.folder / f"run{len(options)}"
        ran = tvl("run", self.folder / "jam", "--out", out, "--deskew", "none", "--no-loops",
                  *options)
        self.assertEqual(ran.returncode, OK, ran.stderr)
        run = judge.read_run(out)
        return run, judge.judge(self.truth, run)

    def test_the_lidar_alone_does_not_claim_what_only_the_traffic_bears_out(self):
        _, verdict = self.run_with("--lidar-only")
        self.assertEqual(verdict.silent, 0, verdict.silent_frames)
        self.assertGreater(verdict.statuses.get("predicted", 0), 0)

    def test_the_road_tells_how_far_the_vehicle_has_come(self):
        run, verdict = self.run_with()
        self.assertEqual(verdict.silent, 0, verdict.silent_frames)
        truth, way_m = self.truth, poses.path_m(self.truth)
        self.assertGreater(way_m, 5.0, "a drive that tells nothing")
        # Carried along by the traffic it would be three quarters of the way.
        self.assertLess(poses.distance_m(truth[-1], run.poses[-1]), 0.04 * way_m)
        self.assertTrue(any(frame["tracks_moving"] > 100 for frame in run.report["frames"]))


if __name__ == "__main__":
    unittest.main()
