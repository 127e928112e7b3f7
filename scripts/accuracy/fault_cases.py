"""Faults that recordings of this field have, as lists of frames (see faulty.py).

Each case is (group, name, frames). Stamps are those of the image; lost frames are lost for scan and
image. Three ways to lose frames: `renumbered` (files numbered on and stamped regularly, nothing
tells of the loss), `stamped` (numbered on, stamps right) and `gap` (numbers and stamps right).
"""

import dataclasses
import random

from . import faulty

PERIOD_S = 0.1
GROUPS = ("stamps", "lost", "repeat", "kidnap", "pause")
AFTER = 8           # frames that must be left after a fault, for the recovery to show
LOST = (1, 2, 3, 5, 10, 20, 30)
DARK = (5, 30, 100)
ASIDE_M = (0, 5, 20)


@dataclasses.dataclass(frozen=True)
class Case:
    group: str
    name: str
    frames: list
    fault_frame: int = 0  # first delivered frame after the fault, 0: none in particular


def _stamped(frames, stamps_s):
    return [dataclasses.replace(f, stamp_s=s) for f, s in zip(frames, stamps_s)]


def _regular(frames):
    return _stamped(frames, [PERIOD_S * k for k in range(len(frames))])


def _absent(frame):
    return dataclasses.replace(frame, scan=faulty.ABSENT, image=faulty.ABSENT)


def stamps(plain):
    """One stamp late, jitter, coarse stamps, clock steps. Truth is that of the frames as they are."""
    t = [f.stamp_s for f in plain]
    n, k = len(t), 30 if len(t) >= 100 else min(20, len(t) // 2)
    rng = random.Random(1)

    def changed(change):
        return [change(i, s) for i, s in enumerate(t)]

    variants = {f"late {ms} ms": changed(lambda i, s, ms=ms: s + 1e-3 * ms * (i == k))
                for ms in (60, 80, 95, 98)}
    variants["odd +90 ms"] = changed(lambda i, s: s + 0.09 * (i % 2))
    variants["uniform 30 ms"] = changed(lambda i, s: s + rng.uniform(-0.03, 0.03))
    for ms in (10, 20):
        variants[f"normal {ms} ms"] = changed(lambda i, s, ms=ms: s + rng.gauss(0.0, 1e-3 * ms))
    for step_s in (0.25, 1.0):
        variants[f"rounded {step_s} s"] = changed(lambda i, s, d=step_s: d * round(s / d))
    for step_s in (5, 20):
        variants[f"clock +{step_s} s"] = changed(lambda i, s, d=step_s: s + d * (i >= k))
    variants["one +1000 s"] = changed(lambda i, s: s + 1000.0 * (i == k))
    variants["one -0.3 s"] = changed(lambda i, s: s - 0.3 * (i == k))
    variants["one equal"] = changed(lambda i, s: s - (t[k] - t[k - 1]) * (i == k))
    variants["all equal"] = changed(lambda i, s: t[0])
    variants["day wrap"] = changed(lambda i, s: s + 86400.0 * (i < k))
    return [Case("stamps", name, _stamped(plain, values), k) for name, values in variants.items()
            if n > k + 2]


def _without(plain, first, count, name, group="lost"):
    """The frames [first, first + count) lost in three ways."""
    rest = plain[:first] + plain[first + count:]
    gap = [_absent(f) if first <= i < first + count else f for i, f in enumerate(plain)]
    return [Case(group, name + ", renumbered", _regular(rest), first),
            Case(group, name + ", stamped", rest, first),
            Case(group, name + ", gap", gap, first + count)]


def lost(plain):
    cases = []
    for count in LOST:
        first = min(30 if len(plain) >= 100 else 20, len(plain) - count - AFTER)
        if first >= AFTER // 2:
            cases += _without(plain, first, count, f"{count} lost")
    for nth in (2, 3):
        rest = plain[::nth]
        gap = [f if i % nth == 0 else _absent(f) for i, f in enumerate(plain)]
        gap = gap[:len(plain) - (len(plain) - 1) % nth]  # ends with a scan
        name = f"every {nth}."
        cases += [Case("lost", name + ", renumbered", _regular(rest)),
                  Case("lost", name + ", stamped", rest), Case("lost", name + ", gap", gap)]
    return cases


def repeat(plain):
    """Scans delivered more than once. `5 Hz scans`: images are new, every second scan is old."""
    k = min(30, len(plain) // 2)
    cases = []
    for times in (2, 3):
        frames = [f for f in plain for _ in range(times)]
        cases.append(Case("repeat", f"all {times} times", _regular(frames)))
    cases.append(Case("repeat", "all 2 times, same stamps", [f for f in plain for _ in range(2)]))
    once = plain[:k] + [plain[k]] + plain[k:]
    cases.append(Case("repeat", "one 2 times", _regular(once), k))
    cases.append(Case("repeat", "one 3 times", _regular(plain[:k] + 2 * [plain[k]] + plain[k:]), k))
    held = [dataclasses.replace(f, scan=i - i % 2) for i, f in enumerate(plain)]
    cases.append(Case("repeat", "5 Hz scans", held))
    return cases


def _frames_to(way_m, first, aside_m):
    """Frames to leave out from `first` on, so that `aside_m` of way are missing."""
    k = first
    while k < len(way_m) and way_m[k] - way_m[first] < aside_m:
        k += 1
    return k - first


def kidnap(plain, way_m):
    """Black images and scans without returns; back 0, 5 or 20 m from where prediction says.

    way_m: distance driven up to each frame.
    """
    cases = []
    first = 20 if len(plain) < 100 else 40
    for dark in DARK:
        for aside_m in ASIDE_M:
            back = first + dark
            if back >= len(plain):
                continue
            back += _frames_to(way_m, back, aside_m)
            if back + AFTER > len(plain):
                continue
            black = [dataclasses.replace(f, scan=faulty.EMPTY, image=faulty.EMPTY)
                     for f in plain[first:first + dark]]
            frames = _regular(plain[:first] + black + plain[back:])
            cases.append(Case("kidnap", f"{dark} dark, {aside_m} m aside", frames, first + dark))
    return cases


def pause(plain, way_m):
    """The recorder pauses while the vehicle brakes to a stand, and while it stands."""
    speed_m = [b - a for a, b in zip(way_m, way_m[1:])]
    standing = [i for i, step in enumerate(speed_m) if step < 0.002]
    if not standing or standing[0] < 30:
        return []
    stand = standing[0]
    cases = _without(plain, stand - 25, 35, "pause while braking", "pause")
    cases += _without(plain, stand - 10, 20, "pause at the end of braking", "pause")
    if len(standing) > 20 + AFTER:
        cases += _without(plain, stand + 5, 15, "pause while standing", "pause")
    return cases


def all_cases(plain, way_m, groups):
    made = {"stamps": lambda: stamps(plain), "lost": lambda: lost(plain),
            "repeat": lambda: repeat(plain), "kidnap": lambda: kidnap(plain, way_m),
            "pause": lambda: pause(plain, way_m)}
    return [case for group in groups for case in made[group]()]
