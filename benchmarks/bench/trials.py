"""One system over one set of scans: run, stored, found again.

A trial writes DIR/result.json and its trajectories (lidar, first pose the identity, 3x4 a line), and
is done again only if what it was made of has changed: scans, program, package, threads, and for maps
how they are measured.
"""

import dataclasses
import json
import pathlib

import numpy as np

from . import clouds, drives, kiss_slam, machine, metrics, ours, registrars
from . import poses as se3

THREADS = 1
BULK = ("map.pcd", "map.ply", "map.png", "trajectory_tum.txt", "graph.g2o")


@dataclasses.dataclass(frozen=True)
class System:
    label: str
    options: tuple | None = None   # of tvl run; None: a peer

    @property
    def is_ours(self):
        return self.options is not None

    @property
    def closes_loops(self):
        return self.label == "KISS-SLAM" or (self.is_ours and "--no-loops" not in self.options)

    @property
    def needs_camera(self):
        return self.is_ours and "--lidar-only" not in self.options


SYSTEMS = {  # in the order of the tables
    "kiss": System("KISS-ICP"),
    "genz": System("GenZ-ICP"),
    "gicp": System("small_gicp (VGICP)"),
    "kiss-slam-odometry": System("KISS-SLAM, odometry alone"),
    "ours-lidar": System("tvl lidar-only", ("--lidar-only", "--no-loops")),
    "ours": System("tvl", ("--no-loops",)),
    "kiss-slam": System("KISS-SLAM", None),
    "ours-lidar-loops": System("tvl lidar-only, loops", ("--lidar-only",)),
    "ours-loops": System("tvl, loops", ()),
}
SECOND_OF = {"kiss-slam-odometry": "kiss-slam"}  # the row comes out of the same run


@dataclasses.dataclass(frozen=True)
class Scans:
    """What every system gets."""
    name: str
    folder: pathlib.Path
    files: tuple
    spin: str | None       # given to every system to de-skew with; None: nobody de-skews
    correction_deg: float
    has_camera: bool
    judge_map: bool        # measure the map made with the poses


@dataclasses.dataclass(frozen=True)
class Trial:
    scans: Scans
    system: str
    binary: pathlib.Path
    out: pathlib.Path


def scans_of(folder, spin, correction_deg, judge_map, name=None):
    folder = pathlib.Path(folder)
    return Scans(name or folder.name, folder, tuple(clouds.scan_files(folder)), spin, correction_deg,
                 drives.has_images(folder), judge_map)


def simulated(folder):
    return scans_of(folder, drives.spin_of(folder), drives.correction_of(folder), judge_map=False)


def version_of(system, binary):
    if SYSTEMS[system].is_ours:
        return machine.digest(binary)
    if system.startswith("kiss-slam"):
        return kiss_slam.version()
    return registrars.version(registrars.PEERS[system])


def key_of(trial):
    """What a stored result must have been made of to be taken again."""
    scans = trial.scans
    return {"scans": scans.name, "frames": len(scans.files), "spin": scans.spin,
            "bytes": sum(f.stat().st_size for f in scans.files),
            "correction_deg": scans.correction_deg, "map_measured_by": machine.digest(metrics.__file__) if scans.judge_map else None,
            "system": trial.system, "version": version_of(trial.system, trial.binary),
            "threads": THREADS}


def stored(trial):
    """The result, None if there is none or it was made of something else."""
    path = trial.out / "result.json"
    if not path.exists():
        return None
    result = json.loads(path.read_text())
    return result if result["key"] == key_of(trial) and "error" not in result else None


def _our_rows(trial):
    scans = trial.scans
    run = ours.run(trial.binary, scans.folder, trial.out / "run", "--deskew", scans.spin or "none",
                   "--threads", THREADS, *SYSTEMS[trial.system].options)
    for name in BULK:
        (run.folder / name).unlink(missing_ok=True)
    return {trial.system: (run.T_world_lidar, ours.total_ms(run.report))}


def _kiss_slam_rows(trial):
    scans = trial.scans
    result = kiss_slam.run(scans.files, scans.correction_deg, THREADS, scans.spin)
    return {"kiss-slam-odometry": (result.T_odom_lidar, None),
            "kiss-slam": (result.T_world_lidar, result.ms)}


def _peer_rows(trial):
    scans = trial.scans
    return {trial.system: registrars.run_peer(trial.system, scans.files, scans.correction_deg,
                                              THREADS, scans.spin)}


def _rows(trial):
    """system -> (trajectory, ms of each frame or None)."""
    if SYSTEMS[trial.system].is_ours:
        return _our_rows(trial)
    return _kiss_slam_rows(trial) if trial.system == "kiss-slam" else _peer_rows(trial)


def instants_of(scans, system):
    """Of the poses of a system, see registrars.pose_instants."""
    return registrars.pose_instants(system, scans.spin, len(scans.files))


def at_middle(scans, system, trajectory):
    """Poses at the middle of each sweep, of such as may belong to another instant."""
    return se3.shifted(trajectory, 0.5 - instants_of(scans, system))


def map_figures(scans, trajectory):
    thick, entropy = metrics.map_quality(scans.files, trajectory, scans.correction_deg, scans.spin)
    return {"thickness_mm": 1e3 * thick.mean_m, "planar_voxels": thick.planar_voxels,
            "planar_points": thick.planar_points, "entropy": entropy.mean,
            "entropy_points": entropy.points}


def _said(error, folder):
    """The last line of what went wrong; where the scans lie is nobody's business."""
    lines = str(error).splitlines() or [type(error).__name__]
    return lines[-1].replace(str(folder), folder.name)


def run(trial):
    """Runs the trial and stores the result; what the system refuses is an error in the result."""
    trial.out.mkdir(parents=True, exist_ok=True)
    result = {"key": key_of(trial), "rows": {}}
    try:
        for system, (trajectory, ms) in _rows(trial).items():
            if len(trajectory) != len(trial.scans.files):
                raise RuntimeError(f"{len(trajectory)} poses of {len(trial.scans.files)} scans")
            row = {"trajectory": f"{system}.txt",
                   "ms": None if ms is None else np.asarray(ms).tolist()}
            se3.write_poses(trial.out / row["trajectory"], trajectory)
            if trial.scans.judge_map:
                row["map"] = map_figures(
                    trial.scans, at_middle(trial.scans, system, trajectory))
            result["rows"][system] = row
    except Exception as error:  # whatever a system does, the others must have their turn
        result["error"] = _said(error, trial.scans.folder)
    path = trial.out / "result.json"
    path.write_text(json.dumps(result, indent=1) + "\n")
    return result


def trajectory_of(trial, row):
    return se3.read_poses(trial.out / row["trajectory"])
