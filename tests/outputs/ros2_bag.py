"""Writes an Open3D folder of JPEG or PNG colour as a ROS 2 bag: an MCAP file without chunks, its messages in CDR."""

import json
import math
import struct

MAGIC = b"\x89MCAP0\r\n"
TYPES = {"/tf": "tf2_msgs/msg/TFMessage", "/camera/depth/camera_info": "sensor_msgs/msg/CameraInfo",
         "/camera/depth/image_raw/compressedDepth": "sensor_msgs/msg/CompressedImage",
         "/camera/color/image_raw/compressed": "sensor_msgs/msg/CompressedImage"}


class Cdr:
    """Numbers and texts in CDR, little endian."""

    def __init__(self):
        self.body = b""

    def numbers(self, kind, *values):
        size = struct.calcsize(kind)
        for value in values:
            self.body += b"\0" * (-len(self.body) % size) + struct.pack("<" + kind, value)
        return self

    def data(self, data):
        self.numbers("I", len(data))
        self.body += data
        return self

    def text(self, text):
        return self.data(text.encode() + b"\0")

    def header(self, frame, number):
        return self.numbers("i", 100 + number // 10).numbers("I", number % 10 * 100_000_000).text(frame)

    def message(self):
        return b"\0\1\0\0" + self.body


def quaternion(m):
    """x, y, z, w of a rotation: the largest of their squares first, so that nothing is divided by 0 (Shepperd 1978)."""
    squares = [1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2],
               1 - m[0][0] - m[1][1] + m[2][2], 1 + m[0][0] + m[1][1] + m[2][2]]
    sums = [[squares[0], m[1][0] + m[0][1], m[0][2] + m[2][0], m[2][1] - m[1][2]],
            [m[1][0] + m[0][1], squares[1], m[2][1] + m[1][2], m[0][2] - m[2][0]],
            [m[0][2] + m[2][0], m[2][1] + m[1][2], squares[2], m[1][0] - m[0][1]],
            [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], squares[3]]]
    largest = squares.index(max(squares))
    return [value / (2 * math.sqrt(squares[largest])) for value in sums[largest]]


def record(op, content):
    return struct.pack("<BQ", op, len(content)) + content


def text(text):
    return struct.pack("<I", len(text)) + text.encode()


def messages(folder):
    """Topic, frame number and message of everything in the folder."""
    camera = json.loads((folder / "camera_intrinsic.json").read_text())
    k = camera["intrinsic_matrix"]
    lines = (folder / "trajectory.log").read_text().splitlines()
    info = Cdr().header("camera", 0).numbers("I", camera["height"], camera["width"]).text("plumb_bob")
    info.numbers("I", 5).numbers("d", *[0] * 5, k[0], 0, k[6], 0, k[4], k[7], 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1)
    info.numbers("d", k[0], 0, k[6], 0, 0, k[4], k[7], 0, 0, 0, 1, 0).numbers("I", *[0] * 6).numbers("B", 0)
    yield "/camera/depth/camera_info", 0, info.message()
    colours = sorted((folder / "color").iterdir())
    for number, depth in enumerate(sorted((folder / "depth").iterdir())):
        rows = [[float(word) for word in line.split()] for line in lines[5 * number + 1:5 * number + 4]]
        moved = Cdr().numbers("I", 1).header("map", number).text("camera")
        yield "/tf", number, moved.numbers("d", *(row[3] for row in rows), *quaternion(rows)).message()
        packed = Cdr().header("camera", number).text("16UC1; compressedDepth").data(bytes(12) + depth.read_bytes())
        yield "/camera/depth/image_raw/compressedDepth", number, packed.message()
        kind = "jpeg" if colours[number].suffix == ".jpg" else "png"
        colour = Cdr().header("camera", number).text(kind).data(colours[number].read_bytes())
        yield "/camera/color/image_raw/compressed", number, colour.message()


def write_ros2_bag(folder, path):
    content = MAGIC + record(1, text("ros2") + text(""))
    ids = {topic: number + 1 for number, topic in enumerate(TYPES)}
    for topic, kind in TYPES.items():
        number = struct.pack("<H", ids[topic])
        content += record(3, number + text(kind) + text("ros2msg") + text(""))
        content += record(4, number + number + text(topic) + text("cdr") + text(""))
    for topic, number, message in messages(folder):
        time = (1000 + number) * 100_000_000
        content += record(5, struct.pack("<HIQQ", ids[topic], number, time, time) + message)
    path.write_bytes(content + record(15, bytes(4)) + record(2, bytes(20)) + MAGIC)
