"""A simulated drive that comes back to its start in its last 20 frames, through the whole program."""

import csv
import json
import unittest

from program import OK, Folder, distance, png_size, poses, tvl

DRIVE = "sim:lateloop?seed=5&camera=0&frames=420"
RESULTS = ["trajectory_kitti.txt", "odometry_kitti.txt", "loops.csv", "graph.g2o", "map.pcd"]
folder = None


def setUpModule():
    """The same drive with one thread, with two, without loops, and with hardly any memory."""
    global folder
    folder = Folder()
    run("one", "--threads", 1)
    run("two", "--threads", 2)
    run("none", "--threads", 2, "--no-loops")
    config = folder / "paged.yaml"
    config.write_text("mapping.store.memory_mib: 8\n")
    run("paged", "--threads", 2, "--config", config)


def tearDownModule():
    folder.close()


def run(name, *options):
    result = tvl("run", DRIVE, "--deskew", "none", "--out", folder / name, *options)
    assert result.returncode == OK, result.stdout + result.stderr
    (folder / name / "stdout.txt").write_text(result.stdout)


def loops():
    with open(folder / "one" / "loops.csv", newline="") as file:
        return list(csv.DictReader(file))


def ate(name, trajectory):
    out = folder / "evaluation.json"
    result = tvl("evaluate", "--truth", folder / "one" / "truth_kitti.txt", "--estimate",
                 folder / name / trajectory, "--json", out)
    assert result.returncode == OK, result.stderr
    return json.loads(out.read_text())["drives"][0]["ate_se3"]["rmse_m"]


class Loops(unittest.TestCase):
    def test_the_overlap_at_the_very_end_is_found_and_nothing_else(self):
        accepted = [row for row in loops() if row["outcome"] == "accepted"]
        self.assertGreaterEqual(len(accepted), 5)
        for row in accepted:
            self.assertLess(float(row["error_m"]), 0.15)
            self.assertLess(float(row["error_deg"]), 0.5)
            self.assertGreater(int(row["current_frame"]), 380)
        self.assertEqual(loops()[0].keys() & {"proposer", "rms_m", "overlap", "reason"},
                         {"proposer", "rms_m", "overlap", "reason"})

    def test_every_refusal_has_a_reason(self):
        for row in loops():
            if row["outcome"] == "refused":
                self.assertTrue(row["reason"], row)

    def test_loops_do_no_harm(self):
        self.assertLessEqual(ate("one", "trajectory_kitti.txt"),
                             1.05 * ate("one", "odometry_kitti.txt"))

    def test_threads_change_no_byte(self):
        for name in RESULTS:
            self.assertEqual((folder / "one" / name).read_bytes(),
                             (folder / "two" / name).read_bytes(), name)

    def test_keyframes_in_a_file_change_no_byte(self):
        for name in RESULTS:
            self.assertEqual((folder / "one" / name).read_bytes(),
                             (folder / "paged" / name).read_bytes(), name)
        store = json.loads((folder / "paged" / "run.json").read_text())["keyframe_store"]
        self.assertLess(store["memory_bytes"], 8 * 2**20)
        self.assertGreater(store["file_bytes"], 8 * 2**20)

    def test_without_loops_it_is_the_odometry(self):
        self.assertFalse((folder / "none" / "loops.csv").exists())
        self.assertFalse((folder / "none" / "graph.g2o").exists())
        alone = poses(folder / "none" / "trajectory_kitti.txt")
        for a, b in zip(alone, poses(folder / "none" / "odometry_kitti.txt")):
            self.assertLess(distance(a, b), 1e-6)

    def test_the_graph_is_that_of_the_loops(self):
        lines = [line.split() for line in (folder / "one" / "graph.g2o").read_text().splitlines()]
        poses_of_keyframes = [line for line in lines if line[0] == "VERTEX_SE3:QUAT"]
        edges = [(int(line[1]), int(line[2])) for line in lines if line[0] == "EDGE_SE3:QUAT"]
        accepted = {(int(row["history_keyframe"]), int(row["current_keyframe"]))
                    for row in loops() if row["outcome"] == "accepted"}
        chain = [(k - 1, k) for k in range(1, len(poses_of_keyframes))]
        self.assertEqual(len(lines), len(poses_of_keyframes) + len(edges))
        self.assertEqual(edges[:len(chain)], chain)
        self.assertEqual(set(edges[len(chain):]), accepted)

    def test_report_and_pictures(self):
        report = json.loads((folder / "one" / "run.json").read_text())["loops"]
        self.assertEqual(report["against_truth"]["false_accepted"], 0)
        self.assertEqual(report["against_truth"]["false_dropped"], 0)
        self.assertGreaterEqual(report["odometry_variance_factor"], 1.0)
        self.assertGreater(report["against_truth"]["revisit_keyframes"], 0)
        self.assertGreater(report["timing_per_keyframe"]["verify"]["max_ms"], 0.0)
        self.assertIn("loops: ", (folder / "one" / "stdout.txt").read_text())
        self.assertGreater(min(png_size(folder / "one" / "loops.png")), 100)
        self.assertGreater(min(png_size(folder / "one" / "loop_place_1.png")), 100)


if __name__ == "__main__":
    unittest.main()
