#!/usr/bin/env python3
"""Drives that begin at speed: is the first motion found?

    startup.py --out DIR [--binary tvl] [--seeds 7,8] [--simulated-only]

Real: kitti_2011_09_26_0013_first16 (13 m/s from its first frame), lidar-only, through TVL_TEST_DATA.
Simulated: 5, 15 and 30 m/s, straight and in a turn, 16 and 64 beams, raw and compensated, 30 frames,
straight from the simulator. One line a run: worst and rms error of the steps against truth, the
first frame from which all steps are within the limit, end error, silent errors (scripts/accuracy/
judge.py), statuses. Exit code 1 if a step is off by more than 0.15 m. Needs Python 3 only.
"""

import argparse
import dataclasses
import itertools
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
from accuracy import judge, poses  # noqa: E402

LIMIT_M = 0.15  # truth from GPS/INS jitters by 4 to 8 cm a frame
REAL = "kitti_2011_09_26_0013_first16"
FRAMES = 30
SPEEDS_MPS = (5, 15, 30)
BEAMS = (64, 16)


@dataclasses.dataclass(frozen=True)
class Start:
    name: str
    source: str         # folder or sim: input
    deskew: str
    truth: str          # pose file; empty: the one the run writes


def real_starts(data):
    folder = pathlib.Path(data) / "sequences" / REAL
    return [Start(f"{REAL} {spin}", str(folder), spin, str(folder / "poses.txt"))
            for spin in ("none", "cw", "ccw")]


def simulated_starts(seeds):
    starts = []
    for seed, speed, turn, beams, raw in itertools.product(
            seeds, SPEEDS_MPS, (0, 1), BEAMS, ("none", "cw", "ccw")):
        keys = f"seed={seed}&frames={FRAMES}&camera=0&speed={speed}&beams={beams}"
        keys += ("&turn=1" if turn else "") + (f"&raw={raw}" if raw != "none" else "")
        name = f"{speed:2d} m/s {'turn' if turn else 'straight':<8} {beams} beams {raw:<4} seed {seed}"
        starts.append(Start(name, f"sim:city?{keys}", raw, ""))
    return starts


def row_of(args, start):
    row = {"start": start.name, "source": pathlib.Path(start.source).name}
    out = args.out / "".join(c if c.isalnum() else "_" for c in start.name)
    shutil.rmtree(out, ignore_errors=True)
    result = subprocess.run(
        [args.binary, "run", start.source, "--out", out, "--lidar-only", "--no-loops", "--threads",
         "1", "--deskew", start.deskew, *args.options],
        check=False, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if result.returncode != 0:
        words = (result.stderr.strip().splitlines() or [""])[-1]
        return row | {"error": f"exit code {result.returncode}: {words}"}
    run = judge.read_run(out)
    truth = poses.read(start.truth or out / "truth_kitti.txt")[:len(run.poses)]
    truth = [poses.between(truth[0], pose) for pose in truth]
    steps_m = [poses.length_m(poses.between(poses.between(truth[k - 1], truth[k]),
                                            poses.between(run.poses[k - 1], run.poses[k])))
               for k in range(1, len(truth))]
    verdict = judge.judge(truth, run)
    wrong = [k for k, step_m in enumerate(steps_m, 1) if step_m > LIMIT_M]
    return row | {"worst_m": max(steps_m), "right_from": wrong[-1] + 1 if wrong else 0,
                  "rms_m": math.sqrt(sum(s * s for s in steps_m) / len(steps_m)),
                  "end_m": poses.distance_m(truth[-1], run.poses[-1]),
                  "silent": verdict.silent, "path_m": verdict.path_m, "statuses": verdict.statuses}


HEADER = (f"{'start':<46} {'worst m':>8} {'rms m':>7} {'right from':>10} {'end m':>7} {'path m':>7} "
          f"{'silent':>6}  statuses")


def text_of(row):
    if "error" in row:
        return f"{row['start']:<46} {row['error']}"
    return (f"{row['start']:<46} {row['worst_m']:8.3f} {row['rms_m']:7.3f} {row['right_from']:10d} "
            f"{row['end_m']:7.3f} {row['path_m']:7.1f} {row['silent']:6d}  "
            + " ".join(f"{k} {v}" for k, v in row["statuses"].items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=pathlib.Path("build/release/tvl"))
    parser.add_argument("--data", default=os.environ.get("TVL_TEST_DATA"))
    parser.add_argument("--seeds", default="7")
    parser.add_argument("--simulated-only", action="store_true")
    parser.add_argument("--real-only", action="store_true")
    parser.add_argument("options", nargs="*", help="after --: more options of tvl run")
    args = parser.parse_args()
    args.binary = args.binary.resolve()
    if args.data is None and not args.simulated_only:
        parser.error("set TVL_TEST_DATA or --data, or ask for --simulated-only")
    args.out.mkdir(parents=True, exist_ok=True)
    starts = [] if args.simulated_only else real_starts(args.data)
    starts += [] if args.real_only else simulated_starts([int(s) for s in args.seeds.split(",")])
    rows = []
    print(HEADER)
    for start in starts:
        rows.append(row_of(args, start))
        print(text_of(rows[-1]), flush=True)
    (args.out / "startup.json").write_text(json.dumps(rows, indent=1) + "\n")
    bad = [row for row in rows if "error" in row or row["worst_m"] > LIMIT_M]
    print(f"{len(rows)} starts, {len(bad)} with a step off by more than {LIMIT_M} m")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
