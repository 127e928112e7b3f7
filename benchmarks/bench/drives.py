"""A drive to compare on: simulated ones are written to disk for the peers to read."""

import dataclasses
import json
import pathlib
import urllib.parse

import numpy as np

from . import clouds, ours, poses

SIM = "sim:"
FLAGS = {"clean": "--clean"}
VALUES = ("seed", "frames", "trajectory", "raw", "tunnel", "open", "night", "changes", "lateral",
          "beam_errors", "beam_error_shape")


@dataclasses.dataclass(frozen=True)
class Drive:
    name: str
    folder: pathlib.Path
    files: list
    T_cam0_lidar: np.ndarray
    truth_cam0: np.ndarray
    has_camera: bool
    spin: str | None          # 'cw' or 'ccw' of raw scans
    correction_deg: float     # to raise its points by


def is_simulated(text):
    return text.startswith(SIM)


def _parts(uri):
    preset, _, query = uri.removeprefix(SIM).partition("?")
    return preset, [pair.partition("=")[::2] for pair in query.split("&") if pair]


def simulate_arguments(uri, lidar_only):
    """Arguments of `tvl simulate` for a sim: input of `tvl run`."""
    preset, pairs = _parts(uri)
    arguments = ["--preset", preset]
    for key, value in pairs:
        if key in FLAGS:
            arguments += [FLAGS[key]] if value == "1" else []
        elif key == "camera":
            lidar_only = lidar_only or value == "0"
        elif key in VALUES:
            arguments += [f"--{key.replace('_', '-')}", value]
        else:
            raise ValueError(f"{uri}: '{key}' cannot be written to disk")
    return arguments + (["--no-camera"] if lidar_only else [])


def name_of(text):
    """Of the folder a drive's results go to."""
    if not is_simulated(text):
        return pathlib.Path(text).resolve().name
    preset, pairs = _parts(text)
    values = [pathlib.Path(v).stem if k == "trajectory" else f"{k}{v}".replace(":", "-")
              for k, v in pairs]
    return urllib.parse.quote("_".join([preset, *values]))


def has_images(folder):
    return any((pathlib.Path(folder) / f"image_{k}").is_dir() for k in range(4))


def meta_of(folder):
    """meta.json of a simulated drive, {} of others."""
    path = pathlib.Path(folder) / "meta.json"
    return json.loads(path.read_text()) if path.exists() else {}


def spin_of(folder):
    """'cw' or 'ccw' of a raw simulated drive, None of a compensated one."""
    spin = meta_of(folder).get("raw")
    return spin if spin in ("cw", "ccw") else None


def correction_of(folder):
    """Simulated drives say what error they carry; KITTI's carry the known one."""
    meta = meta_of(folder)
    return (float(np.rad2deg(meta["vertical_correction_rad"])) if "vertical_correction_rad" in meta
            else clouds.KITTI_CORRECTION_DEG)


def write(binary, uri, folder, lidar_only, threads):
    """Simulates a drive into `folder` unless it is there, whole, already."""
    if not (folder / "meta.json").exists():  # written last
        ours.execute(binary, "simulate", "--out", folder, "--threads", threads,
                     *simulate_arguments(uri, lidar_only))
    return folder


def load(name, folder):
    folder = pathlib.Path(folder)
    files = clouds.scan_files(folder)
    truth = poses.read_poses(folder / "poses.txt")
    if len(truth) != len(files):
        raise ValueError(f"{folder}: {len(files)} scans, {len(truth)} poses")
    return Drive(name, folder, files, poses.read_calibration(folder), truth, has_images(folder),
                 spin_of(folder), correction_of(folder))
