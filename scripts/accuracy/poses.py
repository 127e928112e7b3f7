"""Rigid transforms as 3x4 row-major tuples of twelve numbers (a line of a KITTI pose file).

Plain Python, so that the tests need no packages; a drive has some hundred poses.
"""

import math
import pathlib

IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)


def read(path):
    """Poses of a KITTI pose file."""
    poses = []
    for number, line in enumerate(pathlib.Path(path).read_text().splitlines(), 1):
        values = tuple(float(word) for word in line.split())
        if len(values) != 12:
            raise ValueError(f"{path}:{number}: {len(values)} numbers, not 12")
        poses.append(values)
    return poses


def write(path, poses):
    lines = (" ".join(f"{value:.9e}" for value in pose) for pose in poses)
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


def product(a, b):
    """a * b."""
    out = []
    for row in (0, 4, 8):
        x, y, z = a[row], a[row + 1], a[row + 2]
        out += [x * b[0] + y * b[4] + z * b[8], x * b[1] + y * b[5] + z * b[9],
                x * b[2] + y * b[6] + z * b[10], x * b[3] + y * b[7] + z * b[11] + a[row + 3]]
    return tuple(out)


def inverse(a):
    out = []
    for column in range(3):
        x, y, z = a[column], a[column + 4], a[column + 8]
        out += [x, y, z, -(x * a[3] + y * a[7] + z * a[11])]
    return tuple(out)


def between(a, b):
    """T_a_b of two poses in one frame."""
    return product(inverse(a), b)


def position(a):
    return a[3], a[7], a[11]


def length_m(a):
    return math.sqrt(a[3] ** 2 + a[7] ** 2 + a[11] ** 2)


def distance_m(a, b):
    return math.dist(position(a), position(b))


def angle_deg(a):
    """Rotation angle; exact near zero, unlike the arc cosine of the trace."""
    sine = math.sqrt((a[9] - a[6]) ** 2 + (a[2] - a[8]) ** 2 + (a[4] - a[1]) ** 2)
    return math.degrees(math.atan2(sine, a[0] + a[5] + a[10] - 1.0))


def rotation_vector(a):
    """Axis times angle, rad."""
    v = (a[9] - a[6], a[2] - a[8], a[4] - a[1])
    sine = math.sqrt(sum(x * x for x in v))
    if sine < 1e-15:
        return 0.0, 0.0, 0.0
    angle = math.atan2(sine, a[0] + a[5] + a[10] - 1.0)
    return tuple(x / sine * angle for x in v)


def path_m(poses):
    """Length of the line through the poses."""
    return sum(distance_m(a, b) for a, b in zip(poses, poses[1:]))
