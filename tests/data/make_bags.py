#!/usr/bin/env python3
"""Writes the bags of tests/data/bags with writers that are independent of this project.

Needs Python 3 with numpy, rosbags (0.11) and mcap (1.x). The points are made up: scan k has points
i = 0 .. 11 at x = k + i / 4, y = -i, z = k / 2 with intensity i, ring i % 4 and time i / 1000.
"""

import argparse
import pathlib
import shutil
import struct
import zlib

import numpy as np
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

SCANS, POINTS, WIDTH, HEIGHT = 3, 12, 16, 8
FIRST_NS = 1_600_000_000_100_000_000
OTHER_TYPES = {"tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
               "livox_ros_driver2/msg/CustomPoint":
               "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\n"
               "uint8 reflectivity\nuint8 tag\nuint8 line\n",
               "livox_ros_driver2/msg/CustomMsg":
               "std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\nuint8[3] rsvd\n"
               "livox_ros_driver2/CustomPoint[] points\n"}


class Types:
    """Message classes of ROS 1 or ROS 2."""

    def __init__(self, ros1):
        self.ros1 = ros1
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        for name, text in OTHER_TYPES.items():
            if name in self.store.types:
                continue
            self.store.register(get_types_from_msg(text, name))

    def make(self, name, *args):
        return self.store.types[name](*args)

    def header(self, ns, frame):
        stamp = self.make("builtin_interfaces/msg/Time", ns // 10**9, ns % 10**9)
        return self.make("std_msgs/msg/Header", *([0] if self.ros1 else []), stamp, frame)

    def serialize(self, name, message):
        write = self.store.serialize_ros1 if self.ros1 else self.store.serialize_cdr
        return bytes(write(message, name))


def cloud(types, ns, fields, records):
    """fields: (name, offset, datatype); records: structured array."""
    field = [types.make("sensor_msgs/msg/PointField", n, o, t, 1) for n, o, t in fields]
    data = np.frombuffer(records.tobytes(), np.uint8)
    return types.make("sensor_msgs/msg/PointCloud2", types.header(ns, "lidar"), 1, len(records), field,
                      False, records.itemsize, len(data), data, True)


def synthetic_cloud(types, ns, k):
    layout = {"names": ["x", "y", "z", "intensity", "ring", "time"],
              "formats": ["<f4"] * 4 + ["<u2", "<f4"], "offsets": [0, 4, 8, 16, 20, 24], "itemsize": 32}
    records = np.zeros(POINTS, np.dtype(layout))
    i = np.arange(POINTS)
    records["x"], records["y"], records["z"] = k + i / 4, -i, k / 2
    records["intensity"], records["ring"], records["time"] = i, i % 4, i / 1000
    fields = [(n, o, 4 if n == "ring" else 7) for n, o in zip(layout["names"], layout["offsets"])]
    return cloud(types, ns, fields, records)


def image(types, ns, pixels):
    return types.make("sensor_msgs/msg/Image", types.header(ns, "camera_optical"), pixels.shape[0],
                      pixels.shape[1], "bgr8", 0, pixels.shape[1] * 3, pixels.reshape(-1))


def png(pixels):
    """An RGB image as PNG, from BGR."""
    def part(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row[:, ::-1].tobytes() for row in pixels)
    size = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + part(b"IHDR", size) + part(b"IDAT", zlib.compress(rows, 9))
            + part(b"IEND", b""))


def compressed_image(types, ns, data, kind):
    return types.make("sensor_msgs/msg/CompressedImage", types.header(ns, "camera_optical"), kind,
                      np.frombuffer(data, np.uint8))


def camera_info(types, ns, size, focal, model, coefficients):
    width, height = size
    fx, fy, cx, cy = focal
    K = np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1], float)
    P = np.array([fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0], float)
    roi = types.make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
    return types.make("sensor_msgs/msg/CameraInfo", types.header(ns, "camera_optical"), height, width, model,
                      np.array(coefficients, float), K, np.eye(3).reshape(-1), P, 0, 0, roi)


def transforms(types, ns, links):
    """links: (parent, child, (x, y, z), (qx, qy, qz, qw))."""
    made = []
    for parent, child, t, q in links:
        transform = types.make("geometry_msgs/msg/Transform",
                               types.make("geometry_msgs/msg/Vector3", *map(float, t)),
                               types.make("geometry_msgs/msg/Quaternion", *map(float, q)))
        made.append(types.make("geometry_msgs/msg/TransformStamped", types.header(ns, parent), child,
                               transform))
    return types.make("tf2_msgs/msg/TFMessage", made)


def livox(types, ns, k):
    points = [types.make("livox_ros_driver2/msg/CustomPoint", 1000 * i, k + i / 4, float(-i), k / 2, i, 0,
                         i % 4) for i in range(POINTS)]
    return types.make("livox_ros_driver2/msg/CustomMsg", types.header(ns, "lidar"), ns, POINTS, 0,
                      np.zeros(3, np.uint8), points)


def synthetic(types):
    """(topic, type, log time, message); recorded 5 ms after the stamps, scan 2 before scan 1."""
    # Lidar x forward, camera z forward.
    links = [("base", "lidar", (0, 0, 2), (0, 0, 0, 1)),
             ("base", "camera_optical", (1, 0, 2), (-0.5, 0.5, -0.5, 0.5))]
    yield "/tf_static", "tf2_msgs/msg/TFMessage", FIRST_NS, transforms(types, FIRST_NS, links)
    for place, k in enumerate([0, 2, 1]):
        stamp, log = FIRST_NS + k * 10**8, FIRST_NS + place * 10**8 + 5_000_000
        pixels = np.full((HEIGHT, WIDTH, 3), (10 * (k + 1), 100, 200), np.uint8)
        yield "/points", "sensor_msgs/msg/PointCloud2", log, synthetic_cloud(types, stamp, k)
        yield "/cam/image_raw", "sensor_msgs/msg/Image", log, image(types, stamp, pixels)
        yield ("/cam/image_raw/compressed", "sensor_msgs/msg/CompressedImage", log,
               compressed_image(types, stamp, png(pixels), "bgr8; png compressed bgr8"))
        yield ("/cam/camera_info", "sensor_msgs/msg/CameraInfo", log,
               camera_info(types, stamp, (WIDTH, HEIGHT), (20, 21, 7.5, 3.5), "plumb_bob",
                           (-0.1, 0.01, 0.001, -0.001, 0.0)))


def own_clock(types):
    """A lidar that counts from its start, a fisheye camera, and /tf in place of /tf_static."""
    links = [("base", "lidar", (0, 0, 2), (0, 0, 0, 1)), ("base", "camera_optical", (1, 0, 2), (0, 0, 0, 1))]
    pixels = np.full((HEIGHT, WIDTH, 3), 100, np.uint8)
    for k in range(2):
        log, since_start = FIRST_NS + k * 10**8, 12 * 10**9 + k * 10**8
        yield "/tf", "tf2_msgs/msg/TFMessage", log, transforms(types, log, links)
        yield "/points", "sensor_msgs/msg/PointCloud2", log, synthetic_cloud(types, since_start, k)
        yield "/cam/image_raw", "sensor_msgs/msg/Image", log + 1_000_000, image(types, log, pixels)
        yield ("/cam/camera_info", "sensor_msgs/msg/CameraInfo", log,
               camera_info(types, log, (WIDTH, HEIGHT), (20, 21, 7.5, 3.5), "equidistant", (0.1, 0, 0, 0)))


def no_stamps(types):
    """A driver that leaves the stamps of its headers zero, and images of another size than their CameraInfo."""
    pixels = np.full((HEIGHT, WIDTH, 3), 100, np.uint8)
    for k in range(2):
        log = FIRST_NS + k * 10**8
        yield "/points", "sensor_msgs/msg/PointCloud2", log, synthetic_cloud(types, 0, k)
        yield "/cam/image_raw", "sensor_msgs/msg/Image", log, image(types, log, pixels)
        yield ("/cam/camera_info", "sensor_msgs/msg/CameraInfo", log,
               camera_info(types, log, (2 * WIDTH, 2 * HEIGHT), (20, 21, 7.5, 3.5), "plumb_bob", ()))


def write_ros1(path, messages, compression=None, chunk_size=2048):
    types = Types(True)
    writer = Ros1Writer(path)
    writer.chunk_threshold = chunk_size
    if compression:
        writer.set_compression(Ros1Writer.CompressionFormat[compression.upper()])
    with writer:
        connections = {}
        for topic, name, log, message in messages(types):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=types.store,
                                                           msgdef="# none", md5sum="0" * 32)
            writer.write(connections[topic], log, types.serialize(name, message))


def write_rosbag2(path, messages, plugin=StoragePlugin.SQLITE3):
    types = Types(False)
    with Ros2Writer(path, version=9, storage_plugin=plugin) as writer:
        connections = {}
        for topic, name, log, message in messages(types):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=types.store)
            writer.write(connections[topic], log, types.serialize(name, message))


def write_mcap(path, messages, compression="NONE", ros1=False, chunk_size=2048, **options):
    types = Types(ros1)
    with open(path, "wb") as file:
        writer = McapWriter(file, chunk_size=chunk_size, compression=CompressionType[compression], **options)
        writer.start("ros1" if ros1 else "ros2")
        channels = {}
        for topic, name, log, message in messages(types):
            if topic not in channels:
                schema = writer.register_schema(name.replace("/msg/", "/") if ros1 else name,
                                                "ros1msg" if ros1 else "ros2msg", b"")
                channels[topic] = writer.register_channel(topic, "ros1" if ros1 else "cdr", schema)
            writer.add_message(channels[topic], log, types.serialize(name, message), log)
        writer.finish()


def write_split(folder, messages, parts, storage):
    """A rosbag2 folder of several files, the messages dealt out in order."""
    types = Types(False)
    dealt = list(messages(types))
    size = -(-len(dealt) // parts)
    folder.mkdir()
    names = []
    for part in range(parts):
        share = dealt[part * size:(part + 1) * size]
        names.append(f"{folder.name}_{part}.{'db3' if storage == 'sqlite3' else 'mcap'}")
        if storage == "mcap":
            write_mcap(folder / names[-1], lambda _, share=share: share, "ZSTD")
        else:
            write_rosbag2(folder / "part", lambda _, share=share: share)
            (folder / "part" / "part.db3").rename(folder / names[-1])
            shutil.rmtree(folder / "part")
    listed = "".join(f"    - {name}\n" for name in names)
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n"
        f"  storage_identifier: {storage}\n  relative_file_paths:\n{listed}"
        f"  message_count: {len(dealt)}\n  compression_format: \"\"\n  compression_mode: \"\"\n")


def livox_only(types):
    for k in range(2):
        yield ("/livox/lidar", "livox_ros_driver2/msg/CustomMsg", FIRST_NS + k * 10**8,
               livox(types, FIRST_NS + k * 10**8, k))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", default=pathlib.Path(__file__).parent / "bags", type=pathlib.Path)
    folder = parser.parse_args().folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for compression in (None, "bz2", "lz4"):
        write_ros1(folder / f"ros1_{compression or 'none'}.bag", synthetic, compression)
    write_ros1(folder / "livox_ros1.bag", livox_only, None)
    write_rosbag2(folder / "sqlite", synthetic)
    for compression in ("NONE", "ZSTD", "LZ4"):
        write_mcap(folder / f"{compression.lower()}.mcap", synthetic, compression)
    write_mcap(folder / "unchunked.mcap", synthetic, use_chunking=False)
    write_mcap(folder / "unindexed.mcap", synthetic, "ZSTD", index_types=IndexType.NONE,
               repeat_channels=False, repeat_schemas=False, use_statistics=False, use_summary_offsets=False)
    write_mcap(folder / "ros1.mcap", synthetic, "LZ4", ros1=True)
    write_mcap(folder / "livox_ros2.mcap", livox_only)
    write_mcap(folder / "own_clock.mcap", own_clock, "ZSTD")
    write_mcap(folder / "no_stamps.mcap", no_stamps, "ZSTD")
    write_split(folder / "split_mcap", synthetic, 3, "mcap")
    write_split(folder / "split_sqlite", synthetic, 2, "sqlite3")


if __name__ == "__main__":
    main()
