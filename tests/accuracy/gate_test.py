"""The accuracy gate: is the program as accurate as it was? And would the gate notice if it were not?

    gate_test.py Drive | Faults | Recordings

Runs the scenes of scripts/accuracy/gate.py in a temporary folder and compares their figures with
bounds.txt. TVL_BINARY and TVL_MAP_THICKNESS name the programs, TVL_TEST_DATA the recordings.
"""

import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from accuracy import gate  # noqa: E402

SKIPPED = 77  # told to ctest


def tools(options=()):
    data = os.environ.get("TVL_TEST_DATA")
    return gate.Tools(pathlib.Path(os.environ["TVL_BINARY"]),
                      pathlib.Path(os.environ["TVL_MAP_THICKNESS"]),
                      pathlib.Path(data) if data else None, tuple(options))


class Scene(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="tvl_accuracy_")
        cls.path = pathlib.Path(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def broken(self, scenes):
        bounds = gate.read_bounds()
        return [m for scene, found in scenes.items() for m in gate.broken(scene, found, bounds)]

    def within_bounds(self, scenes):
        messages = self.broken(scenes)
        self.assertEqual(messages, [], "\n" + "\n".join(messages))


class Drive(Scene):
    def test_figures_are_within_bounds(self):
        self.within_bounds(gate.drive_figures(tools(), gate.DRIVES[0], self.path))

    def test_a_weight_worse_by_a_fifth_is_noticed(self):
        config = self.path / "worse.yaml"
        config.write_text(gate.WORSE_WEIGHT)
        scenes = gate.drive_figures(tools(["--config", config]), gate.DRIVES[0], self.path, "worse")
        self.assertNotEqual(self.broken(scenes), [])


class Faults(Scene):
    def test_figures_are_within_bounds(self):
        self.within_bounds(gate.drive_figures(tools(), gate.DRIVES[1], self.path))


class Recordings(Scene):
    def test_figures_are_within_bounds(self):
        for recording in gate.RECORDINGS:
            with self.subTest(recording[0]):
                self.within_bounds(gate.recording_figures(tools(), *recording, self.path))


if __name__ == "__main__":
    if "Recordings" in sys.argv and not os.environ.get("TVL_TEST_DATA"):
        print("TVL_TEST_DATA is not set: the real recordings are skipped")
        sys.exit(SKIPPED)
    unittest.main()
