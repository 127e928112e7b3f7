"""The command line: help, and what becomes of input that cannot be used."""

import math
import struct
import unittest

from program import HAS_SIMULATOR, OK, UNUSABLE_INPUT, Folder, files_of, tvl

COMMANDS = ["run", "evaluate", "inspect", "show"] + ["simulate"] * HAS_SIMULATOR


def write_sequence(folder, scan, calibration=True):
    """A sequence of two frames in the KITTI odometry layout, without images."""
    (folder / "velodyne").mkdir(parents=True)
    for name in ("000000.bin", "000001.bin"):
        (folder / "velodyne" / name).write_bytes(scan)
    (folder / "times.txt").write_text("0.0\n0.1\n")
    if calibration:
        projection = " ".join(["700 0 600 0 0 700 180 0 0 0 1 0"])
        rows = [f"P{i}: {projection}" for i in range(4)] + ["Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0"]
        (folder / "calib.txt").write_text("\n".join(rows) + "\n")
    return folder


def small_scan():
    """64 rings of 40 points on a cylinder: readable, though there is little to see."""
    points = []
    for ring in range(64):
        elevation = math.radians(2.0 - 0.42 * ring)
        for i in range(40):
            azimuth = 2.0 * math.pi * (i + 0.5) / 40
            points.append(struct.pack("<4f", 8 * math.cos(azimuth), 8 * math.sin(azimuth),
                                      8 * math.tan(elevation), 0.5))
    return b"".join(points)


class Help(unittest.TestCase):
    def test_every_command_explains_itself(self):
        for command in COMMANDS:
            with self.subTest(command):
                result = tvl(command, "--help")
                self.assertEqual(result.returncode, OK, result.stderr)
                self.assertIn("--help", result.stdout)

    def test_the_program_lists_its_commands_and_version(self):
        result = tvl("--help")
        self.assertEqual(result.returncode, OK)
        for command in COMMANDS:
            self.assertIn(command, result.stdout)
        self.assertRegex(tvl("--version").stdout, r"^\d+\.\d+\.\d+")


class Refusals(unittest.TestCase):
    """Exit code 2, a message that names what is wrong, and nothing written."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.close)

    def refuses(self, arguments, *names):
        result = tvl(*arguments)
        self.assertEqual(result.returncode, UNUSABLE_INPUT, result.stdout + result.stderr)
        for name in names:
            self.assertIn(str(name), result.stderr)
        self.assertEqual(files_of(self.folder / "out"), [])

    def run_on(self, sequence, *options):
        return ["run", sequence, "--out", self.folder / "out", *options]

    def test_command_lines(self):
        self.refuses([])
        self.refuses(["drive"], "subcommand")
        self.refuses(["run"], "input")
        sequence = write_sequence(self.folder / "seq", small_scan())
        self.refuses(self.run_on(sequence, "--deskew", "sideways"), "deskew")
        self.refuses(self.run_on(sequence, "--threads", "0"), "threads")
        self.refuses(self.run_on(sequence, "--frames", "7:9"), "7")
        self.refuses(self.run_on(sequence, "--profile", "no-such-lidar"), "no-such-lidar")

    def test_a_folder_that_is_not_there(self):
        self.refuses(self.run_on(self.folder / "nowhere"), "nowhere")

    def test_a_calibration_that_is_broken(self):
        sequence = write_sequence(self.folder / "seq", small_scan())
        (sequence / "calib.txt").write_text("P2: 1 2 3\n")
        self.refuses(self.run_on(sequence), "calib.txt")

    def test_a_folder_without_scans(self):
        sequence = write_sequence(self.folder / "seq", small_scan())
        for scan in (sequence / "velodyne").iterdir():
            scan.unlink()
        self.refuses(self.run_on(sequence), "velodyne")

    def test_first_scans_that_cannot_be_used(self):
        cut_off = small_scan()[:1234]
        no_numbers = struct.pack("<4f", math.nan, 0.0, 0.0, 0.0) * 2000
        for name, scan, message in (("empty", b"", "no points"),
                                    ("cut_off", cut_off, "not a multiple of 16"),
                                    ("nan", no_numbers, "no valid point")):
            with self.subTest(name):
                sequence = write_sequence(self.folder / name, scan)
                self.refuses(self.run_on(sequence), "000000.bin", message, "--frames 1:")

    def test_options_nobody_knows(self):
        sequence = write_sequence(self.folder / "seq", small_scan())
        config = self.folder / "config.yaml"
        config.write_text("mapping:\n  intervall: 5\n")
        self.refuses(self.run_on(sequence, "--config", config), "config.yaml", "intervall")
        config.write_text("mapping:\n  interval: 0\n")
        self.refuses(self.run_on(sequence, "--config", config), "interval")

    def test_simulations_nobody_knows(self):
        self.refuses(self.run_on("sim:nowhere"), "nowhere")
        self.refuses(self.run_on("sim:city?sed=3"), "sed")

    def test_evaluation_without_truth(self):
        estimate = self.folder / "trajectory_kitti.txt"
        estimate.write_text("1 0 0 0 0 1 0 0 0 0 1 0\n" * 2)
        truth = self.folder / "poses.txt"
        self.refuses(["evaluate", "--truth", truth, "--estimate", estimate], "poses.txt")
        truth.write_text("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 zero 0 1 0 0 0 0 1 0\n")
        self.refuses(["evaluate", "--truth", truth, "--estimate", estimate], "poses.txt", "2")


if __name__ == "__main__":
    unittest.main()
