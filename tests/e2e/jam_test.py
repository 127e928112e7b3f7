"""A traffic jam, simulated: lorries and cars creep on all sides and fill the scan."""

import pathlib
import sys
import unittest

from program import OK, Folder, tvl

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from accuracy import judge, poses  # noqa: E402

FRAMES = 160  # the vehicle starts, creeps and stops


class Jam(unittest.TestCase):
    def test_the_road_tells_how_far_the_vehicle_has_come(self):
        folder = Folder()
        self.addCleanup(folder.close)
        made = tvl("simulate", "--out", folder / "jam", "--preset", "jam", "--seed", 8,
                   "--frames", FRAMES)
        self.assertEqual(made.returncode, OK, made.stderr)
        ran = tvl("run", folder / "jam", "--out", folder / "run", "--deskew", "none", "--no-loops")
        self.assertEqual(ran.returncode, OK, ran.stderr)
        truth = poses.read(folder / "jam/poses.txt")
        run = judge.read_run(folder / "run")
        verdict = judge.judge(truth, run)
        self.assertEqual(verdict.silent, 0, verdict.silent_frames)
        way_m = poses.path_m(truth)
        self.assertGreater(way_m, 5.0, "a drive that tells nothing")
        # Carried along by the traffic it would be three quarters of the way.
        self.assertLess(poses.distance_m(truth[-1], run.poses[-1]), 0.04 * way_m)
        self.assertTrue(any(frame["tracks_moving"] > 100 for frame in run.report["frames"]))


if __name__ == "__main__":
    unittest.main()
