"""A simulated drive through the whole program: simulate, run, evaluate, compare, break, stop."""

import json
import os
import signal
import struct
import time
import unittest

from program import (OK, Folder, black_png, copy_sequence, distance, files_of, png_size, poses,
                     replace, start, tvl)

LONG = 3000  # frames of a drive that is never finished
FRAMES = 40
RESULTS = ["graph.g2o", "loops.csv", "loops.png", "map.pcd", "map.ply", "map.png",
           "odometry_kitti.txt", "resolved.yaml", "run.json", "trajectory_kitti.txt",
           "trajectory_tum.txt", "truth_kitti.txt"]
folder = None


def setUpModule():
    """One drive and one run of it, shared by the tests."""
    global folder
    folder = Folder()
    made = tvl("simulate", "--out", folder / "drive", "--frames", FRAMES, "--seed", 3)
    assert made.returncode == OK, made.stderr
    run(folder / "drive", "one", "--threads", 1)


def tearDownModule():
    folder.close()


def run(sequence, name, *options):
    result = tvl("run", sequence, "--out", folder / name, *options)
    assert result.returncode == OK, result.stdout + result.stderr
    return result


def report(name):
    return json.loads((folder / name / "run.json").read_text())


def evaluation(truth, name):
    out = folder / (name + ".json")
    result = tvl("evaluate", "--truth", truth, "--estimate",
                 folder / name / "trajectory_kitti.txt", "--json", out)
    assert result.returncode == OK, result.stderr
    return json.loads(out.read_text())["drives"][0]


class Run(unittest.TestCase):
    def test_everything_promised_is_there(self):
        self.assertEqual(files_of(folder / "one"), RESULTS)
        trajectory = poses(folder / "one" / "trajectory_kitti.txt")
        self.assertEqual(len(trajectory), FRAMES)
        for value, expected in zip(trajectory[0], [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]):
            self.assertAlmostEqual(value, expected, 9)
        result = report("one")
        self.assertTrue(result["complete"])
        self.assertEqual(result["counts"]["frames"], FRAMES)
        self.assertEqual(result["counts"]["predicted"], 0)
        self.assertEqual([f["frame"] for f in result["frames"]], list(range(FRAMES)))
        self.assertEqual(len(result["frames"][5]["step_covariance"]), 36)
        for stage in ("preprocessing", "odometry", "mapping", "total"):
            self.assertGreater(result["timing"][stage]["p95_ms"], 0.0)

    def test_it_follows_the_truth(self):
        errors = evaluation(folder / "drive" / "poses.txt", "one")
        self.assertEqual(errors["frames"], FRAMES)
        self.assertLess(errors["total"]["translation_m"], 0.20)
        self.assertLess(errors["total"]["rotation_deg"], 0.4)
        self.assertLess(errors["rpe_1_frame"]["translation_rmse_m"], 0.015)

    def test_threads_do_not_change_a_byte(self):
        run(folder / "drive", "two", "--threads", 2)
        for name in RESULTS:
            if name == "run.json":  # holds times
                continue
            with self.subTest(name):
                self.assertEqual((folder / "one" / name).read_bytes(),
                                 (folder / "two" / name).read_bytes())

    def test_resolved_options_give_the_same_run(self):
        run(folder / "drive", "again", "--config", folder / "one" / "resolved.yaml", "--frames",
            ":12")
        self.assertEqual(report("again")["threads"], len(os.sched_getaffinity(0)))
        again = poses(folder / "again" / "trajectory_kitti.txt")
        self.assertEqual(again, poses(folder / "one" / "trajectory_kitti.txt")[:12])

    def test_without_the_camera(self):
        run(folder / "drive", "lidar", "--lidar-only")
        errors = evaluation(folder / "drive" / "poses.txt", "lidar")
        self.assertLess(errors["total"]["translation_m"], 0.25)
        self.assertFalse(report("lidar")["options"]["use_camera"])

    def test_raw_scans(self):
        for spin in ("cw", "ccw"):
            with self.subTest(spin):
                sequence = folder / ("raw_" + spin)
                made = tvl("simulate", "--out", sequence, "--frames", 20, "--seed", 4, "--raw",
                           spin, "--no-camera")
                self.assertEqual(made.returncode, OK, made.stderr)
                run(sequence, "run_" + spin, "--deskew", spin)
                errors = evaluation(sequence / "poses.txt", "run_" + spin)
                self.assertLess(errors["total"]["translation_m"], 0.15)

    def test_a_drive_that_never_touches_the_disk(self):
        run("sim:city?seed=3&frames=10", "uri")
        memory = poses(folder / "uri" / "trajectory_kitti.txt")
        disk = poses(folder / "one" / "trajectory_kitti.txt")
        self.assertEqual(len(memory), 10)
        # The route of a shorter drive is another one, but speed and step are alike.
        self.assertLess(abs(distance(memory[0], memory[9]) - distance(disk[0], disk[9])), 2.0)


class BadFrames(unittest.TestCase):
    """Bad frames in mid-run are reported, counted, bridged and marked."""

    def test_each_kind(self):
        sequence = copy_sequence(folder / "drive", folder / "bad")
        scan, image = sequence / "velodyne", sequence / "image_0"
        points = (scan / "000024.bin").read_bytes()
        replace(scan / "000010.bin", b"")
        replace(scan / "000014.bin", points[:len(points) // 3 + 5])
        replace(scan / "000018.bin", struct.pack("<4f", float("nan"), 1, 1, 0) * 500
                + (scan / "000018.bin").read_bytes())
        (scan / "000022.bin").unlink()
        replace(image / "000026.png", b"no image at all")
        replace(image / "000028.png", black_png(*png_size(image / "000028.png")))
        replace(image / "000030.png", black_png(64, 32))
        (image / "000032.png").unlink()
        replace(scan / "000034.bin", b"")
        (image / "000034.png").unlink()
        replace(scan / "000036.bin", 3 * (scan / "000036.bin").read_bytes())  # 192 turns
        (scan / "000038.bin").unlink()
        (scan / "000038.bin").mkdir()
        result = run(sequence, "run_bad")
        kinds = {f["frame"]: json.dumps(f["faults"]) for f in report("run_bad")["frames"]
                 if f["faults"]}
        self.assertEqual(sorted(kinds), [10, 14, 18, 22, 26, 28, 30, 32, 34, 36, 38])
        self.assertIn("invalid_points", kinds[18])
        self.assertIn("black_image", kinds[28])
        self.assertIn("wrong_size_image", kinds[30])
        self.assertIn("odd_scan", kinds[36])
        self.assertIn("missing_scan", kinds[38])
        for name in ("000010.bin", "000014.bin", "frame 22", "000026.png", "frame 32", "frame 36",
                     "000038.bin"):
            self.assertIn(name, result.stderr)
        self.assertEqual(report("run_bad")["frames"][34]["status"], "predicted")
        self.assertEqual(len(poses(folder / "run_bad" / "trajectory_kitti.txt")), FRAMES)
        errors = evaluation(folder / "drive" / "poses.txt", "run_bad")
        self.assertLess(errors["total"]["translation_m"], 0.25)
        self.assertLess(errors["rpe_1_frame"]["translation_rmse_m"], 0.05)

    def test_time_that_goes_back(self):
        sequence = copy_sequence(folder / "drive", folder / "late")
        times = (sequence / "times.txt").read_text().splitlines()
        times[20] = times[15]
        replace(sequence / "times.txt", ("\n".join(times) + "\n").encode())
        run(sequence, "run_late")
        faults = {f["frame"] for f in report("run_late")["frames"] if f["faults"]}
        self.assertIn(20, faults)
        errors = evaluation(folder / "drive" / "poses.txt", "run_late")
        self.assertLess(errors["total"]["translation_m"], 0.25)


class Interrupts(unittest.TestCase):
    def test_a_signal_leaves_complete_results(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number.name):
                name = "stopped_" + number.name
                # A drive that takes minutes: the signal always comes in the middle of it.
                drive = f"sim:city?seed=3&frames={LONG}&camera=0"
                process = start("run", drive, "--out", folder / name, "--deskew", "none")
                time.sleep(3)
                process.send_signal(number)
                out, error = process.communicate(timeout=60)
                self.assertIn("interrupted", out + error)
                self.assertEqual(files_of(folder / name), RESULTS)
                frames = report(name)["counts"]["frames"]
                self.assertFalse(report(name)["complete"])
                self.assertTrue(0 < frames < LONG, frames)
                trajectory = poses(folder / name / "trajectory_kitti.txt")
                self.assertEqual(len(trajectory), frames)


class OtherCommands(unittest.TestCase):
    def test_inspect(self):
        result = tvl("inspect", folder / "drive")
        self.assertEqual(result.returncode, OK, result.stderr)
        self.assertIn(str(FRAMES), result.stdout)

    def test_show_each_stage(self):
        for stage in ("tracks", "segments", "features", "depth", "map"):
            with self.subTest(stage):
                out = folder / (stage + ".png")
                result = tvl("show", folder / "drive", "--frame", 3, "--stage", stage, "--out", out)
                self.assertEqual(result.returncode, OK, result.stderr)
                self.assertGreater(png_size(out)[0], 300)

    def test_evaluate_draws_plots(self):
        result = tvl("evaluate", "--truth", folder / "drive" / "poses.txt", "--estimate",
                     folder / "one" / "trajectory_kitti.txt", "--plot", folder / "plots")
        self.assertEqual(result.returncode, OK, result.stderr)
        self.assertTrue(any(name.endswith(".png") for name in files_of(folder / "plots")))

    def test_the_same_seed_gives_the_same_drive(self):
        for name in ("a", "b"):
            made = tvl("simulate", "--out", folder / name, "--frames", 2, "--seed", 9)
            self.assertEqual(made.returncode, OK, made.stderr)
        for part in ("velodyne/000001.bin", "image_0/000001.png", "poses.txt", "calib.txt"):
            self.assertEqual((folder / "a" / part).read_bytes(), (folder / "b" / part).read_bytes())


if __name__ == "__main__":
    unittest.main()
