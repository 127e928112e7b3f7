"""Runs the program `tvl` and reads what it wrote."""

import dataclasses
import json
import pathlib
import resource
import subprocess

import numpy as np

from . import poses as se3

DEFAULT_BINARY = pathlib.Path(__file__).resolve().parents[2] / "build/release/tvl"


@dataclasses.dataclass(frozen=True)
class Run:
    folder: pathlib.Path
    T_world_lidar: np.ndarray
    report: dict  # run.json; empty if there is none
    cpu_s: float  # processor time of the whole program, reading and writing included


def execute(binary, *arguments):
    """Runs tvl; on failure raises with its last words."""
    command = [str(binary), *map(str, arguments)]
    result = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                            check=False)
    if result.returncode != 0:
        words = "\n".join((result.stdout + result.stderr).splitlines()[-15:])
        raise RuntimeError(f"{' '.join(command)}: exit code {result.returncode}\n{words}")
    return result.stdout


def run(binary, sequence, out, *options):
    """tvl run; poses come back in the lidar frame of the first scan."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    execute(binary, "run", sequence, "--out", out, *options)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    out = pathlib.Path(out)
    T_world_cam0 = se3.read_poses(out / "trajectory_kitti.txt")
    T_world_lidar = se3.to_lidar(T_world_cam0, se3.read_calibration(sequence))
    report = out / "run.json"
    return Run(out, T_world_lidar, json.loads(report.read_text()) if report.exists() else {},
               cpu_s)


def stage_ms(report):
    """stage -> {mean_ms, p50_ms, p95_ms, p99_ms, max_ms} of run.json, {} if it has none."""
    return report.get("timing", {})


def total_ms(report):
    """Milliseconds of each frame."""
    return np.array([frame["total_ms"] for frame in report.get("frames", ())] or [np.nan])
