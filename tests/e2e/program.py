"""The program under test, and folders for it to work on."""

import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
import zlib

BINARY = os.environ["TVL_BINARY"]
HAS_SIMULATOR = os.environ.get("TVL_HAS_SIMULATOR", "1") == "1"
OK, FAILED, UNUSABLE_INPUT = 0, 1, 2


def tvl(*arguments, timeout_s=240):
    """Runs tvl to its end; stdout and stderr are text."""
    return subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True,
                          errors="replace", timeout=timeout_s, check=False)


def start(*arguments):
    """Starts tvl and returns the running process."""
    return subprocess.Popen([BINARY, *map(str, arguments)], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)


class Folder:
    """A temporary folder; leaves with close()."""

    def __init__(self):
        self.path = pathlib.Path(tempfile.mkdtemp(prefix="tvl_e2e_"))

    def __truediv__(self, name):
        return self.path / name

    def close(self):
        shutil.rmtree(self.path, ignore_errors=True)


def files_of(folder):
    return sorted(p.name for p in pathlib.Path(folder).iterdir()) if folder.is_dir() else []


def copy_sequence(source, target):
    """A sequence of links to the files of another, so that single files can be replaced."""
    for path in sorted(source.rglob("*")):
        if path.is_file():
            link = target / path.relative_to(source)
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(path.resolve())
    return target


def replace(path, data):
    path.unlink()
    path.write_bytes(data)


def black_png(width, height):
    """An 8 bit grey image, all zero."""
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    pixels = zlib.compress(bytes((width + 1) * height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels)
            + chunk(b"IEND", b""))


def png_size(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


def poses(path):
    """Rows of a KITTI pose file, each twelve numbers."""
    return [[float(x) for x in line.split()] for line in path.read_text().splitlines()]


def distance(a, b):
    """Between the positions of two poses, m."""
    return sum((a[i] - b[i]) ** 2 for i in (3, 7, 11)) ** 0.5
