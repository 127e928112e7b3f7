#!/usr/bin/env python3
"""Faulty copies of recordings through the program: late stamps, lost, repeated and dark frames.

    faults.py --out DIR --binary tvl [--groups stamps,lost,repeat,kidnap,pause] [--recordings A,B]

Simulated drives are written once, below --out; real recordings are found through TVL_TEST_DATA.
Each case is compared with the run of the recording as it is, for the same physical frames, and its
steps with the truth (of a real recording: with the run as it is). Columns:

    end, rmse   difference to the clean run, m, of the frames that claim to be tracked
    truth       end error against truth, m (simulated drives), and that of the clean run
    path        length of the result's path, m
    step        worst step error of a frame that claims to be tracked, m and deg
    silent      SILENT ERRORS: steps off by more than 0.3 m or 3 deg, status tracked or degraded
    T D P L     frames tracked, degraded, predicted, lost
    found       frames from the fault to the first right step; '-': never
    verdict     ok: within the limits (stamps: 0.1 % of path + 0.1 m of the clean run; else
                1.2 x the clean run's error + 0.2 m); lost: beyond them, but no silent error and
                tracking at the end; FAIL: anything else

Needs Python 3 only. Exit code 1 if a case fails.
"""

import argparse
import dataclasses
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
from accuracy import fault_cases, faulty, judge, poses  # noqa: E402

CITY_CAM = ["--preset", "city", "--seed", "31"]
# name -> (arguments of `tvl simulate`, --deskew, groups that make sense)
SIMULATED = {
    "city": (["--preset", "city", "--seed", "3", "--frames", "120", "--no-camera"], "none",
             ("stamps", "lost", "repeat")),
    "citycam": (CITY_CAM + ["--frames", "120"], "none", ("stamps", "lost", "repeat")),
    "cityraw": (CITY_CAM + ["--frames", "120", "--raw", "cw"], "cw", ("stamps", "lost", "repeat")),
    "citylong": (CITY_CAM + ["--frames", "220"], "none", ("kidnap",)),
    "brake": (["--preset", "city", "--seed", "5", "--no-camera", "--frames", "0"], "none",
              ("pause",)),
}
REAL = {
    "kitti360_3000": ("cw", "none"),
    "kitti_2011_09_26_0052": ("none",),
    "kitti_2011_09_26_0052_jam": ("none",),
    "kitti_2011_09_26_0013_first16": ("none",),
}
DEFAULT = "city,citycam,cityraw,citylong,brake,kitti360_3000"
BULK = ("map.pcd", "map.ply", "map.png")  # nobody looks at them here


@dataclasses.dataclass(frozen=True)
class Setting:
    """One recording under one set of options."""
    name: str
    recording: faulty.Recording
    truth: list          # poses of its frames; empty: unknown
    options: list
    groups: tuple


def braking_drive(path):
    """Poses of camera 0: 12 m/s, from frame 60 braking with 4 m/s2 to a stand, 5 s later off again."""
    forward_m, speed_mps, lines = 0.0, 12.0, []
    for k in range(200):
        lines.append((1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, forward_m))
        acceleration = -4.0 if 60 <= k < 90 else 2.0 if k >= 140 and speed_mps < 12.0 else 0.0
        forward_m += 0.1 * speed_mps + 0.005 * acceleration
        speed_mps = max(0.0, speed_mps + 0.1 * acceleration)
    poses.write(path, lines)


def simulated(args, name):
    """Folder of a simulated drive, written unless it is there."""
    folder = args.out / "drives" / name
    arguments = list(SIMULATED[name][0])
    if name == "brake":
        folder.parent.mkdir(parents=True, exist_ok=True)
        line = folder.parent / "brake_line.txt"
        braking_drive(line)
        arguments += ["--trajectory", str(line)]
    if not (folder / "meta.json").exists():  # written last
        subprocess.run([args.binary, "simulate", "--out", folder, *arguments], check=True,
                       stdout=subprocess.DEVNULL)
    return folder


def settings(args):
    """Every recording under every set of options asked for."""
    for name in args.recordings:
        if name in SIMULATED:
            folder, spins, groups = simulated(args, name), (SIMULATED[name][1],), SIMULATED[name][2]
            truth = poses.read(folder / "poses.txt")
        else:
            folder = args.data / "sequences" / name
            spins, groups, truth = REAL[name], fault_cases.GROUPS, []
        recording = faulty.open_recording(folder)
        for spin in args.deskew or spins:
            for variant in args.variants:
                if variant == "camera" and not recording.images:
                    continue
                options = ["--deskew", spin, "--no-loops", "--threads", "1", *args.options]
                options += ["--lidar-only"] if variant == "lidar" else []
                yield Setting(f"{name} {variant} {spin}", recording, truth, options, groups)


def run(args, sequence, out, options):
    """A judge.Run, or the message of a run that failed."""
    shutil.rmtree(out, ignore_errors=True)
    result = subprocess.run([args.binary, "run", sequence, "--out", out, *options], check=False,
                            capture_output=True, text=True, errors="replace",
                            stdin=subprocess.DEVNULL)
    if result.returncode != 0:
        words = (result.stderr.strip().splitlines() or [""])[-1]
        return f"exit code {result.returncode}: {words}"
    for name in BULK:
        (out / name).unlink(missing_ok=True)
    return judge.read_run(out)


def row_of(setting, case, result, clean):
    """One line of the table as a dict."""
    row = {"setting": setting.name, "group": case.group, "case": case.name}
    if isinstance(result, str):
        return row | {"verdict": "FAIL", "error": result}
    to_clean = judge.judge(judge.reference_of(clean.poses, case.frames), result, case.fault_frame)
    to_truth = clean_to_truth = None
    if setting.truth:
        to_truth = judge.judge(judge.reference_of(setting.truth, case.frames), result,
                               case.fault_frame)
        plain = faulty.plain(setting.recording)
        clean_to_truth = judge.judge(judge.reference_of(setting.truth, plain), clean)
    steps = to_truth or to_clean
    claims_end = result.statuses[-1] in judge.CLAIMS
    good = steps.silent == 0 and claims_end
    verdict = ("ok" if good and judge.within_limits(
                   case.group == "stamps", to_clean, to_truth, clean_to_truth)
               else "lost" if good and len(result.statuses) > sum(
                   result.statuses.count(s) for s in judge.CLAIMS) + 1 else "FAIL")
    return row | {"verdict": verdict, "end_m": to_clean.end_m, "rmse_m": to_clean.rmse_m,
                  "truth_end_m": to_truth.end_m if to_truth else None,
                  "clean_truth_end_m": clean_to_truth.end_m if to_truth else None,
                  **{k: v for k, v in dataclasses.asdict(steps).items()
                     if k not in ("end_m", "rmse_m")}}


HEADER = (f"{'recording':<34} {'case':<33} {'end':>8} {'rmse':>8} {'truth':>8} {'clean':>6} "
          f"{'path':>8} {'step m':>8} {'deg':>6} {'silent':>6} {'T':>4} {'D':>3} {'P':>3} {'L':>3} "
          f"{'found':>5}  verdict")


def text_of(row):
    def number(key, width, digits):
        value = row.get(key)
        return f"{'-' if value is None or math.isnan(value) else format(value, f'.{digits}f'):>{width}}"
    head = f"{row['setting']:<34} {row['case']:<33} "
    if "error" in row:
        return head + row["error"][:150] + "  FAIL"
    count = [row["statuses"].get(s, 0) for s in ("tracked", "degraded", "predicted", "lost")]
    found = "-" if row["found_after"] is None else str(row["found_after"])
    return (head + f"{number('end_m', 8, 3)} {number('rmse_m', 8, 3)} {number('truth_end_m', 8, 3)} "
            f"{number('clean_truth_end_m', 6, 3)} {number('path_m', 8, 1)} {number('worst_m', 8, 3)} "
            f"{number('worst_deg', 6, 2)} {row['silent']:6d} {count[0]:4d} {count[1]:3d} "
            f"{count[2]:3d} {count[3]:3d} {found:>5}  {row['verdict']}")


def run_setting(args, setting):
    """Rows of one recording under one set of options."""
    work = args.out / "runs" / setting.name.replace(" ", "_")
    plain = faulty.plain(setting.recording)
    clean = run(args, setting.recording.folder, work / "clean", setting.options)
    if isinstance(clean, str):
        raise RuntimeError(f"{setting.name}: the recording as it is: {clean}")
    clean_case = fault_cases.Case("clean", "as recorded", plain)
    rows = [row_of(setting, clean_case, clean, clean)]
    print(text_of(rows[0]), flush=True)
    reference = setting.truth or clean.poses
    way_m = [poses.path_m(reference[:k + 1]) for k in range(len(plain))]
    groups = [g for g in args.groups if g in setting.groups]
    for case in fault_cases.all_cases(plain, way_m, groups):
        if args.cases and not any(part in case.name for part in args.cases):
            continue
        if case.name == "5 Hz scans" and "--lidar-only" in setting.options:
            continue  # without images the same as every scan twice
        name = "".join(c if c.isalnum() else "_" for c in case.name)
        copy = work / "copies" / name
        shutil.rmtree(copy, ignore_errors=True)
        faulty.write(setting.recording, case.frames, copy)
        result = run(args, copy, work / name, setting.options)
        shutil.rmtree(copy)
        rows.append(row_of(setting, case, result, clean))
        print(text_of(rows[-1]), flush=True)
    return rows


def comma_separated(text):
    return [part for part in text.split(",") if part]


def parse():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=pathlib.Path("build/release/tvl"))
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("TVL_TEST_DATA"))
    parser.add_argument("--groups", type=comma_separated, default=list(fault_cases.GROUPS))
    parser.add_argument("--recordings", type=comma_separated, default=comma_separated(DEFAULT),
                        help=f"of {', '.join([*SIMULATED, *REAL])}; default {DEFAULT}")
    parser.add_argument("--variants", type=comma_separated, default=["lidar", "camera"])
    parser.add_argument("--deskew", type=comma_separated, default=None,
                        help="none, cw, ccw; default: what fits the recording")
    parser.add_argument("--cases", type=comma_separated, default=None,
                        help="only cases with one of these words in their name")
    parser.add_argument("--json", type=pathlib.Path, help="default: table.json in --out")
    parser.add_argument("options", nargs="*", help="after --: more options of tvl run")
    args = parser.parse_args()
    args.binary, args.out = args.binary.resolve(), args.out.resolve()
    if any(name in REAL for name in args.recordings) and args.data is None:
        parser.error("set TVL_TEST_DATA or --data, or leave the real recordings out")
    return args


def main():
    args = parse()
    args.out.mkdir(parents=True, exist_ok=True)
    print(HEADER)
    rows = []
    for setting in settings(args):
        rows += run_setting(args, setting)
        (args.json or args.out / "table.json").write_text(json.dumps(rows, indent=1) + "\n")
    bad = [row for row in rows if row["verdict"] == "FAIL"]
    print(f"{len(rows)} runs, {len(bad)} failed, "
          f"{sum(row.get('silent', 0) for row in rows)} silent errors")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
