"""What is wrong with the poses of a run, and whether its statuses say so.

A SILENT ERROR is a frame whose status is `tracked` or `degraded` and whose step T_{k-1,k} from the
frame delivered before is off by more than 0.3 m or 3 deg. Where the frame before was not tracked
itself, its pose was no claim, and the frame is judged by the motion since the last frame that was,
or by its absolute pose, whichever is nearer to the reference; after a frame that was `predicted`,
which says that some direction is dead reckoning and drifts, by its step from there, too. A frame with
which the map begins anew (`map_begins_anew`) says that the way to it is not known: the frames after it
are judged from there.
"""

import dataclasses
import json
import math
import pathlib

from . import poses

CLAIMS = ("tracked", "degraded")
LIMIT_M = 0.3
LIMIT_DEG = 3.0


@dataclasses.dataclass(frozen=True)
class Run:
    poses: list     # of camera 0, the first is the identity
    statuses: list  # of run.json
    report: dict


@dataclasses.dataclass(frozen=True)
class Verdict:
    frames: int
    path_m: float
    end_m: float         # distance to the reference of the last frame that claims to be tracked
    rmse_m: float        # of the positions of the frames that claim to be tracked
    worst_m: float       # worst step of the frames that claim to be tracked
    worst_deg: float
    silent: int
    silent_frames: list  # the first ones
    statuses: dict       # status -> count
    found_after: int | None  # frames from fault_frame to the first right claim; None: never


def read_run(folder):
    folder = pathlib.Path(folder)
    report = json.loads((folder / "run.json").read_text())
    return Run(poses.read(folder / "trajectory_kitti.txt"),
               [frame["status"] for frame in report["frames"]], report)


def _error(reference, estimate):
    """(m, deg) between two motions."""
    difference = poses.between(reference, estimate)
    return poses.length_m(difference), poses.angle_deg(difference)


def _step_error(reference, estimate, is_origin, statuses, k):
    """(m, deg) of frame k > 0, which claims to be tracked; is_origin: may a step begin at a frame?"""
    def since(j):
        return _error(poses.between(reference[j], reference[k]),
                      poses.between(estimate[j], estimate[k]))
    trusted = k - 1
    while trusted > 0 and not is_origin[trusted]:
        trusted -= 1
    errors = [since(trusted)]
    if trusted != k - 1:
        errors.append(_error(reference[k], estimate[k]))
    if statuses[k - 1] == "predicted":
        errors.append(since(k - 1))
    return min(errors, key=lambda e: max(e[0] / LIMIT_M, e[1] / LIMIT_DEG))


def judge(reference, run, fault_frame=0):
    """reference: the right pose of every delivered frame, in the frame of the first."""
    if len(reference) != len(run.poses):
        raise ValueError(f"{len(run.poses)} poses, {len(reference)} expected")
    claims = [k for k in range(1, len(run.poses)) if run.statuses[k] in CLAIMS]
    begins_anew = [frame.get("map_begins_anew", False) for frame in run.report.get("frames", [])]
    is_origin = [status in CLAIMS or any(begins_anew[k:k + 1])
                 for k, status in enumerate(run.statuses)]
    errors = {k: _step_error(reference, run.poses, is_origin, run.statuses, k) for k in claims}
    wrong = [k for k in claims if errors[k][0] > LIMIT_M or errors[k][1] > LIMIT_DEG]
    away_m = [poses.distance_m(reference[k], run.poses[k]) for k in claims]
    found = [k for k in claims if k >= fault_frame and k not in wrong]
    counts = {s: run.statuses.count(s) for s in sorted(set(run.statuses))}
    return Verdict(
        len(run.poses), poses.path_m(run.poses), away_m[-1] if away_m else math.nan,
        math.sqrt(sum(a * a for a in away_m) / len(away_m)) if away_m else math.nan,
        max((e[0] for e in errors.values()), default=0.0),
        max((e[1] for e in errors.values()), default=0.0),
        len(wrong), wrong[:20], counts, found[0] - fault_frame if found else None)


def within_limits(stamps_only, to_clean, to_truth=None, clean_to_truth=None):
    """May a fault cost that much? Verdicts of the faulty run against the run without faults and
    against truth, and of the run without faults against truth. Wrong stamps change nothing; lost or
    repeated frames cost a fifth more than there was, and 0.2 m."""
    apart_m = max(to_clean.end_m, to_clean.rmse_m)
    if stamps_only:
        return apart_m <= 0.001 * to_clean.path_m + 0.1
    if to_truth is None:
        return apart_m <= 0.2
    return (to_truth.end_m <= 1.2 * clean_to_truth.end_m + 0.2 and
            to_truth.rmse_m <= 1.2 * clean_to_truth.rmse_m + 0.2)


def reference_of(physical, frames):
    """Poses of the physical frames as the delivered ones should have them."""
    origin = poses.inverse(physical[frames[0].physical])
    return [poses.product(origin, physical[f.physical]) for f in frames]
