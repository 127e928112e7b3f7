"""Faulty copies of recordings in the KITTI odometry layout: links to the files of the original and
a times.txt of their own.

A copy is described by the list of its frames: which scan and image of the original each has, and its
stamp. The original is not touched.
"""

import dataclasses
import pathlib
import struct
import zlib

EMPTY = "empty"    # a file without a point; an image all black
ABSENT = "absent"  # no file of this number


@dataclasses.dataclass(frozen=True)
class Frame:
    physical: int            # frame of the original whose pose this one should get
    stamp_s: float
    scan: int | str          # frame of the original, EMPTY or ABSENT
    image: int | str


@dataclasses.dataclass(frozen=True)
class Recording:
    """Files of a KITTI odometry folder by frame number."""
    folder: pathlib.Path
    scans: list
    images: list             # empty: no camera
    image_folder: str
    stamps_s: list

    @property
    def frames(self):
        return len(self.scans)


def open_recording(folder):
    """Frames are numbered from 0 without gaps."""
    folder = pathlib.Path(folder)
    scans = sorted((folder / "velodyne").glob("*.bin"))
    if not scans:
        raise FileNotFoundError(f"{folder}/velodyne: no .bin scans")
    name = next((f"image_{k}" for k in range(4) if (folder / f"image_{k}").is_dir()), "")
    images = sorted(p for p in (folder / name).glob("*") if p.suffix in (".png", ".jpg")) if name else []
    if images and len(images) != len(scans):
        raise ValueError(f"{folder}: {len(scans)} scans, {len(images)} images")
    times = folder / "times.txt"
    stamps_s = ([float(x) for x in times.read_text().split()] if times.exists()
                else [0.1 * k for k in range(len(scans))])
    return Recording(folder, scans, images, name, stamps_s[:len(scans)])


def plain(recording):
    """The frames of the original itself."""
    return [Frame(k, stamp_s, k, k) for k, stamp_s in enumerate(recording.stamps_s)]


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
    """(width, height)."""
    return struct.unpack(">II", pathlib.Path(path).read_bytes()[16:24])


def _place(source, originals, path, empty_suffix, empty):
    """A link to originals[source], or a file with the bytes `empty`, or nothing."""
    if source == EMPTY:
        path.with_suffix(empty_suffix).write_bytes(empty)
    elif source != ABSENT:
        path.with_suffix(originals[source].suffix).symlink_to(originals[source].resolve())


def write(recording, frames, folder, with_times=True):
    """The faulty copy; `folder` must not exist. Truth is not copied: it would not fit."""
    folder = pathlib.Path(folder)
    (folder / "velodyne").mkdir(parents=True)
    for name in ("calib.txt", "tvl.yaml"):
        if (recording.folder / name).exists():
            (folder / name).symlink_to((recording.folder / name).resolve())
    black = b""
    if recording.images:
        (folder / recording.image_folder).mkdir()
        if any(frame.image == EMPTY for frame in frames):
            black = black_png(*png_size(recording.images[0]))
    for number, frame in enumerate(frames):
        _place(frame.scan, recording.scans, folder / "velodyne" / f"{number:06d}", ".bin", b"")
        if recording.images:
            image = folder / recording.image_folder / f"{number:06d}"
            _place(frame.image, recording.images, image, ".png", black)
    if with_times:
        (folder / "times.txt").write_text("".join(f"{f.stamp_s:.9f}\n" for f in frames))
    return folder
