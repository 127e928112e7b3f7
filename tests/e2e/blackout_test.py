"""Scans without returns for three seconds, while the vehicle drives on and round a corner."""

import pathlib
import sys
import unittest

from program import OK, Folder, tvl

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from accuracy import fault_cases, faulty, judge, poses  # noqa: E402

FRAMES = 150  # the corner is behind the vehicle at frame 108
DARK = 30


class Blackout(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.addClassCleanup(cls.folder.close)
        drive = cls.folder / "drive"
        made = tvl("simulate", "--out", drive, "--preset", "city", "--seed", 31, "--frames", FRAMES,
                   "--no-camera")
        assert made.returncode == OK, made.stderr
        cls.recording = faulty.open_recording(drive)
        cls.truth = poses.read(drive / "poses.txt")
        way_m = [poses.path_m(cls.truth[:k + 1]) for k in range(len(cls.truth))]
        cls.cases = {case.name: case
                     for case in fault_cases.kidnap(faulty.plain(cls.recording), way_m)}

    def test_the_pose_is_found_again_where_the_map_reaches(self):
        for aside_m in (0, 5, 20):  # 27, 32 and 45 m of way, the last round the corner
            with self.subTest(aside_m=aside_m):
                case = self.cases[f"{DARK} dark, {aside_m} m aside"]
                copy, out = self.folder / f"copy{aside_m}", self.folder / f"run{aside_m}"
                faulty.write(self.recording, case.frames, copy)
                ran = tvl("run", copy, "--out", out, "--deskew", "none", "--no-loops")
                self.assertEqual(ran.returncode, OK, ran.stderr)
                run = judge.read_run(out)
                truth = judge.reference_of(self.truth, case.frames)
                verdict = judge.judge(truth, run, case.fault_frame)
                self.assertEqual(verdict.silent, 0, verdict.silent_frames)
                self.assertLessEqual(verdict.found_after, 10)
                self.assertLess(poses.distance_m(truth[-1], run.poses[-1]), 1.0)
                # Bridged: no frame in the dark was left where it was held forward to.
                steps_m = [poses.distance_m(a, b) for a, b in zip(run.poses, run.poses[1:])]
                self.assertLess(max(steps_m), 2.5)


if __name__ == "__main__":
    unittest.main()
