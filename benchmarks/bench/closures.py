"""Loop closures between stretches of a drive, against truth.

A stretch is what a system that closes loops between local maps makes a map of: consecutive frames,
with their poses relative to its first frame. T_query_reference maps coordinates of the reference
stretch's first frame to those of the query stretch's.
"""

import dataclasses

import numpy as np

from . import metrics, poses as se3

FALSE_M, FALSE_DEG = 1.0, 5.0     # as tvl evaluates its own loops
REVISIT_M = 10.0
REVISIT_S, REVISIT_PATH_M = 30.0, 50.0
FRAME_S = 0.1


@dataclasses.dataclass(frozen=True)
class Stretch:
    first: int                    # frame
    T_first_frame: np.ndarray     # (n, 4, 4), the first is the identity

    @property
    def frames(self):
        return self.first + np.arange(len(self.T_first_frame))


@dataclasses.dataclass(frozen=True)
class Closure:
    query: int                    # indices of stretches
    reference: int
    T_query_reference: np.ndarray


@dataclasses.dataclass(frozen=True)
class Score:
    accepted: int
    false: int
    error_p95_m: float            # of the accepted; NaN without any
    error_p95_deg: float
    revisits: int                 # stretches that see a place again
    closed: int                   # of them, with a closure that is not false


def nearest(truth, a, b):
    """Where two stretches come nearest by truth: (offset in a, offset in b, distance m)."""
    pa, pb = truth[a.frames, :3, 3], truth[b.frames, :3, 3]
    distance = np.linalg.norm(pa[:, None] - pb[None], axis=2)
    i, j = np.unravel_index(np.argmin(distance), distance.shape)
    return int(i), int(j), float(distance[i, j])


def error(truth, stretches, closure):
    """(m, deg) of the motion the closure implies between the frames at which its stretches meet.

    Taken there and not at the first frames: up to 100 m away a tenth of a degree counts 0.17 m, and
    the drift within the stretches is no fault of the closure.
    """
    query, reference = stretches[closure.query], stretches[closure.reference]
    i, j, _ = nearest(truth, query, reference)
    implied = (se3.inverse(query.T_first_frame[i]) @ closure.T_query_reference
               @ reference.T_first_frame[j])
    actual = se3.inverse(truth[query.first + i]) @ truth[reference.first + j]
    off = se3.inverse(actual) @ implied
    return float(np.linalg.norm(off[:3, 3])), float(np.rad2deg(se3.angle_rad(off)))


def revisits(truth, stretches):
    """Indices of the stretches with a frame near an earlier one, much later in time and path."""
    path = metrics.path_m(truth)
    found = []
    for index, stretch in enumerate(stretches):
        for frame in stretch.frames:
            old = np.searchsorted(path, path[frame] - REVISIT_PATH_M)
            old = min(old, max(0, frame - int(REVISIT_S / FRAME_S)))
            apart = np.linalg.norm(truth[:old, :3, 3] - truth[frame, :3, 3], axis=1)
            if len(apart) > 0 and apart.min() < REVISIT_M:
                found.append(index)
                break
    return found


def score(truth, stretches, closures):
    errors = np.array([error(truth, stretches, c) for c in closures]).reshape(-1, 2)
    is_false = (errors[:, 0] > FALSE_M) | (errors[:, 1] > FALSE_DEG)
    good = {c.query for c, wrong in zip(closures, is_false) if not wrong}
    again = revisits(truth, stretches)
    p95 = np.percentile(errors, 95, axis=0) if len(errors) > 0 else (np.nan, np.nan)
    return Score(len(closures), int(is_false.sum()), float(p95[0]), float(p95[1]), len(again),
                 len(good.intersection(again)))
