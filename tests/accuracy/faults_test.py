"""Faulty recordings through the program: what must not be wrong without a word.

    faults_test.py Compensated | Raw | Recorded

A few faults of each kind in scripts/accuracy/fault_cases.py, on a simulated drive of 70 frames and
on a recording; benchmarks/faults.py has them all. No frame may claim to be tracked with a wrong
step, and the poses are right, or the program says that it was lost and finds itself again.
TVL_BINARY names the program, TVL_TEST_DATA the recordings.
"""

import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from accuracy import fault_cases, faulty, gate, judge, poses  # noqa: E402

SKIPPED = 77  # told to ctest
CITY = ("--preset", "city", "--seed", "63", "--frames", "70")


def tools():
    data = os.environ.get("TVL_TEST_DATA")
    return gate.Tools(pathlib.Path(os.environ["TVL_BINARY"]), None,
                      pathlib.Path(data) if data else None)


class Faulty(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="tvl_faults_")
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.tools = tools()

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def simulate(cls, *arguments):
        drive = gate.Drive("drive", CITY + arguments, "none")
        gate.make_drive(cls.tools, drive, cls.folder)
        return cls.folder / "original"

    def check(self, sequence, deskew, lidar_only, names):
        """Runs the cases of these names, and the recording as it is."""
        recording = faulty.open_recording(sequence)
        plain = faulty.plain(recording)
        clean = gate.run(self.tools, sequence, self.folder / "clean", deskew, lidar_only)
        has_truth = (sequence / "poses.txt").exists()
        physical = poses.read(sequence / "poses.txt") if has_truth else clean.poses
        way_m = [poses.path_m(physical[:k + 1]) for k in range(len(plain))]
        cases = {c.name: c for c in fault_cases.all_cases(plain, way_m, fault_cases.GROUPS)}
        clean_to_truth = judge.judge(judge.reference_of(physical, plain), clean)
        self.assertEqual(clean_to_truth.silent, 0, "the recording as it is")
        for name in names:
            with self.subTest(name):
                case = cases[name]
                number = len(list(self.folder.iterdir()))
                copy = faulty.write(recording, case.frames, self.folder / f"copy{number}")
                result = gate.run(self.tools, copy, self.folder / f"run{number}", deskew, lidar_only)
                to_truth = judge.judge(judge.reference_of(physical, case.frames), result)
                to_clean = judge.judge(judge.reference_of(clean.poses, case.frames), result)
                self.assertEqual(to_truth.silent_frames, [])
                self.assertIn(result.statuses[-1], judge.CLAIMS)
                self.assertTrue(
                    judge.within_limits(case.group == "stamps", to_clean,
                                        to_truth if has_truth else None, clean_to_truth)
                    or "lost" in result.statuses, f"{to_clean}")


class Compensated(Faulty):
    def test_lidar_only(self):
        self.check(self.simulate("--no-camera"), "none", True, (
            "late 98 ms", "odd +90 ms", "rounded 1.0 s", "clock +20 s", "one +1000 s",
            "3 lost, renumbered", "10 lost, stamped", "5 lost, gap", "all 2 times",
            "every 3., renumbered", "5 dark, 5 m aside"))


class Raw(Faulty):
    def test_with_camera(self):
        self.check(self.simulate("--raw", "cw"), "cw", False, (
            "late 80 ms", "normal 20 ms", "2 lost, renumbered", "10 lost, gap", "one 3 times",
            "5 Hz scans", "30 dark, 0 m aside"))


class Recorded(Faulty):
    SEQUENCE = "kitti360_3000"

    def test_lidar_only_as_if_compensated(self):
        self.check(self.tools.data / "sequences" / self.SEQUENCE, "none", True, (
            "late 95 ms", "normal 20 ms", "clock +5 s", "3 lost, renumbered", "all 2 times"))

    def test_with_camera(self):
        self.check(self.tools.data / "sequences" / self.SEQUENCE, "cw", False, (
            "late 80 ms", "rounded 0.25 s", "every 2., renumbered", "all 2 times",
            "5 dark, 0 m aside"))


if __name__ == "__main__":
    if "Recorded" in sys.argv and not os.environ.get("TVL_TEST_DATA"):
        print("TVL_TEST_DATA is not set: real recordings are skipped")
        sys.exit(SKIPPED)
    unittest.main()
