"""Writes a recording in the layouts that ScanKnit reads and does not write, each from its description.

The source is a folder of Open3D's layout (depth/, color/ of JPEG, camera_intrinsic.json, trajectory.log). Each writer takes a
Source and the folder to write to, and gives the path of the recording, or None where a program that it needs is missing.
"""

import json
import math
import pathlib
import shutil
import sqlite3
import struct
import sys
import zipfile
import zlib

import numpy

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "outputs"))
import ros2_bag  # noqa: E402

FRAME_S = 0.1  # recordings of this layout have no clock: ten frames a second


class Source:
    def __init__(self, folder, depth_pgms, colour_ppms):
        """The last two: the pictures as convert --to fakenect writes them."""
        self.folder = folder
        self.depth = sorted((folder / "depth").iterdir())
        self.colour = sorted((folder / "color").iterdir())
        self.camera = json.loads((folder / "camera_intrinsic.json").read_text())
        numbers = [line.split() for line in (folder / "trajectory.log").read_text().splitlines()]
        self.poses = [rigid([[float(word) for word in row] for row in numbers[i + 1:i + 5]]) for i in range(0, len(numbers), 5)]
        self._pgms, self._ppms = depth_pgms, colour_ppms

    def __len__(self):
        return len(self.depth)

    @property
    def size(self):
        return self.camera["width"], self.camera["height"]

    @property
    def k(self):
        """fx, fy, cx, cy."""
        return [self.camera["intrinsic_matrix"][i] for i in (0, 4, 6, 7)]

    def raw_depth(self, frame):
        """Millimetres, little endian, row by row."""
        width, height = self.size
        return self._pgms[frame].read_bytes()[-2 * width * height:]

    def raw_colour(self, frame):
        """Red, green, blue, row by row."""
        width, height = self.size
        return self._ppms[frame].read_bytes()[-3 * width * height:]

    def times(self):
        return [100 + FRAME_S * i for i in range(len(self))]


def rigid(matrix):
    """With the rotation nearest to that of a printed matrix."""
    u, _, v = numpy.linalg.svd(numpy.array(matrix)[:3, :3])
    return [[*map(float, row), matrix[i][3]] for i, row in enumerate(u @ v)] + [[0.0, 0.0, 0.0, 1.0]]


def opengl(pose):
    """The axes of a camera that looks along -z with y up."""
    return [[row[0], -row[1], -row[2], row[3]] for row in pose]


def quaternion(pose):
    return ros2_bag.quaternion(pose)


def inverse(pose):
    """Rotation and translation of the inverse, row by row."""
    rotation = [[pose[j][i] for j in range(3)] for i in range(3)]
    return rotation, [-sum(rotation[i][j] * pose[j][3] for j in range(3)) for i in range(3)]


def axis_angle(rotation):
    x, y, z, w = ros2_bag.quaternion(rotation)
    length = math.sqrt(x * x + y * y + z * z)
    angle = 2 * math.atan2(length, w)
    return [value * angle / length if length > 0 else 0 for value in (x, y, z)]


def put(source, target):
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def png(size, kind, pixels):
    """8 bits; kind 0: grey, 2: red, green, blue."""
    width, height = size
    row = len(pixels) // height

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows = b"".join(b"\0" + pixels[y * row:(y + 1) * row] for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")


def full_confidence(size, value):
    """A grey picture of one value."""
    return png(size, 0, bytes([value]) * (size[0] * size[1]))


def write_replica(source, folder):
    for i in range(len(source)):
        put(source.depth[i], folder / f"room/results/depth{i:06}.png")
        put(source.colour[i], folder / f"room/results/frame{i:06}.jpg")
    lines = [" ".join(repr(value) for row in pose for value in row) for pose in source.poses]
    (folder / "room/traj.txt").write_text("\n".join(lines) + "\n")
    (width, height), (fx, fy, cx, cy) = source.size, source.k
    camera = {"w": width, "h": height, "fx": fx, "fy": fy, "cx": cx, "cy": cy, "scale": 1000}
    (folder / "cam_params.json").write_text(json.dumps({"camera": camera}))
    return folder / "room"


def write_bop(source, folder):
    cameras = {}
    fx, fy, cx, cy = source.k
    for i, pose in enumerate(source.poses):
        put(source.depth[i], folder / f"depth/{i:06}.png")
        put(source.colour[i], folder / f"rgb/{i:06}.jpg")
        rotation, translation = inverse(pose)
        cameras[str(i)] = {"cam_K": [fx, 0, cx, 0, fy, cy, 0, 0, 1], "depth_scale": 1.0,
                           "cam_R_w2c": [value for row in rotation for value in row],
                           "cam_t_w2c": [1000 * value for value in translation]}
    (folder / "scene_camera.json").write_text(json.dumps(cameras))
    return folder


# Phones state the camera of the whole sensor.
SENSOR = (1920, 1440)


def sensor_camera(source):
    """The corner of the picture is at (-0.5, -0.5) in every size."""
    scale = SENSOR[0] / source.size[0]
    fx, fy, cx, cy = source.k
    return [fx * scale, fy * scale, (cx + 0.5) * scale - 0.5, (cy + 0.5) * scale - 0.5]


def write_phone_lidar(source, folder):
    """Its makers scale the camera as if the corner were at (0, 0)."""
    confidence = full_confidence(source.size, 2)
    fx, fy, cx, cy = (value * SENSOR[0] / source.size[0] for value in source.k)
    for i, pose in enumerate(source.poses):
        put(source.depth[i], folder / f"depth_{i:05}.png")
        put(source.colour[i], folder / f"frame_{i:05}.jpg")
        (folder / f"conf_{i:05}.png").write_bytes(confidence)
        matrix = [value for row in opengl(pose) for value in row]
        (folder / f"frame_{i:05}.json").write_text(json.dumps(
            {"cameraPoseARFrame": matrix, "intrinsics": [fx, 0, cx, 0, fy, cy, 0, 0, 1], "time": source.times()[i]}))
    return folder


def write_stray_scanner(source, folder):
    confidence = full_confidence(source.size, 2)
    rows = ["timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy"]
    (folder / "confidence").mkdir(parents=True)
    for i, pose in enumerate(source.poses):
        put(source.depth[i], folder / f"depth/{i:06}.png")
        put(source.colour[i], folder / f"rgb/{i:06}.jpg")
        (folder / f"confidence/{i:06}.png").write_bytes(confidence)
        numbers = [row[3] for row in pose[:3]] + quaternion(pose) + sensor_camera(source)
        rows.append(f"{source.times()[i]}, {i:06}, " + ", ".join(map(repr, numbers)))
    (folder / "odometry.csv").write_text("\n".join(rows) + "\n")
    return folder


def write_polycam(source, folder):
    confidence = full_confidence(source.size, 255)
    fx, fy, cx, cy = sensor_camera(source)
    keyframes = folder / "keyframes"
    for kind in ("confidence", "cameras"):
        (keyframes / kind).mkdir(parents=True)
    for i, pose in enumerate(source.poses):
        name = str(round(source.times()[i] * 1e6))
        put(source.depth[i], keyframes / f"depth/{name}.png")
        put(source.colour[i], keyframes / f"images/{name}.jpg")
        (keyframes / f"confidence/{name}.png").write_bytes(confidence)
        camera = {"fx": fx, "fy": fy, "cx": cx, "cy": cy, "width": SENSOR[0], "height": SENSOR[1]}
        matrix = opengl(pose)
        camera.update({f"t_{row}{column}": matrix[row][column] for row in range(3) for column in range(4)})
        (keyframes / f"cameras/{name}.json").write_text(json.dumps(camera))
    return folder


def write_arkitscenes(source, folder):
    confidence = full_confidence(source.size, 2)
    scene, lines = folder / "41069021/41069021_frames", []
    for kind in ("confidence", "lowres_wide", "lowres_wide_intrinsics"):
        (scene / kind).mkdir(parents=True)
    for i, pose in enumerate(source.poses):
        name = f"41069021_{source.times()[i]:.3f}"
        put(source.depth[i], scene / f"lowres_depth/{name}.png")
        (scene / f"lowres_wide/{name}.png").write_bytes(png(source.size, 2, source.raw_colour(i)))
        (scene / f"confidence/{name}.png").write_bytes(confidence)
        (scene / f"lowres_wide_intrinsics/{name}.pincam").write_text(" ".join(map(repr, [*source.size, *source.k])))
        rotation, translation = inverse(pose)
        lines.append(" ".join([f"{source.times()[i]:.3f}", *map(repr, axis_angle(rotation) + translation)]))
    (scene / "lowres_wide.traj").write_text("\n".join(lines) + "\n")
    return folder


def plain_lzfse(data):
    """One block that is not compressed."""
    return b"bvx-" + struct.pack("<I", len(data)) + data + b"bvx$"


def write_record3d(source, folder):
    folder.mkdir(parents=True)
    metadata = {"w": SENSOR[0], "h": SENSOR[1], "dw": source.size[0], "dh": source.size[1], "fps": 10,
                "frameTimestamps": source.times(), "perFrameIntrinsicCoeffs": [sensor_camera(source)] * len(source),
                "poses": [quaternion(opengl(pose)) + [row[3] for row in pose[:3]] for pose in source.poses]}
    with zipfile.ZipFile(folder / "scan.r3d", "w") as archive:
        archive.writestr("metadata", json.dumps(metadata))
        for i in range(len(source)):
            millimetres = numpy.frombuffer(source.raw_depth(i), "<u2").astype("f8")
            archive.writestr(f"rgbd/{i}.depth", plain_lzfse((millimetres / 1000).astype("<f4").tobytes()))
            archive.writestr(f"rgbd/{i}.jpg", source.colour[i].read_bytes())
    return folder / "scan.r3d"


def write_sens(source, folder):
    folder.mkdir(parents=True)
    fx, fy, cx, cy = source.k
    unit = [float(i % 5 == 0) for i in range(16)]
    camera = [fx, 0, cx, 0, 0, fy, cy, 0, *unit[8:]]
    with open(folder / "scan.sens", "wb") as file:
        file.write(struct.pack("<IQ", 4, 4) + b"test" + struct.pack("<64f", *camera, *unit, *camera, *unit))
        file.write(struct.pack("<ii", 2, 1) + struct.pack("<4I", *source.size, *source.size))
        file.write(struct.pack("<fQ", 1000, len(source)))
        for i, pose in enumerate(source.poses):
            colour, depth = source.colour[i].read_bytes(), zlib.compress(source.raw_depth(i), 1)
            microseconds = round(source.times()[i] * 1e6)
            file.write(struct.pack("<16f", *(value for row in pose for value in row)))
            file.write(struct.pack("<4Q", microseconds, microseconds, len(colour), len(depth)) + colour + depth)
        file.write(struct.pack("<Q", 0))
    return folder / "scan.sens"


def write_db3(source, folder):
    """A bag of ROS 2 in SQLite; depth as PNG (compressedDepth)."""
    folder.mkdir(parents=True)
    database = sqlite3.connect(folder / "bag.db3")
    database.executescript(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
        "data BLOB NOT NULL);")
    ids = {topic: number + 1 for number, topic in enumerate(ros2_bag.TYPES)}
    for topic, kind in ros2_bag.TYPES.items():
        database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (ids[topic], topic, kind))
    for topic, number, message in ros2_bag.messages(source.folder):
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                         (ids[topic], (1000 + number) * 100_000_000, message))
    database.commit()
    database.close()
    return folder / "bag.db3"


def write_ros1(source, folder):
    """By ROS 1's own library; depth as it is."""
    try:
        import genpy
        import rosbag
        from geometry_msgs.msg import TransformStamped
        from sensor_msgs.msg import CameraInfo, CompressedImage, Image
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return None
    folder.mkdir(parents=True)
    (width, height), (fx, fy, cx, cy) = source.size, source.k
    info = CameraInfo(height=height, width=width, distortion_model="plumb_bob", D=[0.0] * 5,
                      K=[fx, 0, cx, 0, fy, cy, 0, 0, 1], R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                      P=[fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0])
    with rosbag.Bag(str(folder / "scan.bag"), "w") as bag:
        for i, pose in enumerate(source.poses):
            now = genpy.Time.from_sec(source.times()[i])

            def stamped(message, frame):
                message.header.stamp, message.header.frame_id = now, frame
                return message

            moved = stamped(TransformStamped(child_frame_id="camera"), "map")
            place, turn = moved.transform.translation, moved.transform.rotation
            place.x, place.y, place.z = (row[3] for row in pose[:3])
            turn.x, turn.y, turn.z, turn.w = quaternion(pose)
            bag.write("/tf", TFMessage([moved]), now)
            bag.write("/camera/depth/camera_info", stamped(info, "camera"), now)
            depth = Image(height=height, width=width, encoding="16UC1", step=2 * width, data=source.raw_depth(i))
            bag.write("/camera/depth/image_raw", stamped(depth, "camera"), now)
            colour = CompressedImage(format="jpeg", data=source.colour[i].read_bytes())
            bag.write("/camera/color/image_raw/compressed", stamped(colour, "camera"), now)
    return folder / "scan.bag"


def write_pcd(source, folder):
    folder.mkdir(parents=True)
    (width, height), (fx, fy, cx, cy) = source.size, source.k
    u, v = numpy.meshgrid(numpy.arange(width), numpy.arange(height))
    for i, pose in enumerate(source.poses):
        z = numpy.frombuffer(source.raw_depth(i), "<u2").reshape(height, width) / 1000
        z[z == 0] = numpy.nan
        points = numpy.stack([(u - cx) * z / fx, (v - cy) * z / fy, z], axis=-1).astype("<f4")
        x, y, z, w = quaternion(pose)
        viewpoint = " ".join(map(repr, [row[3] for row in pose[:3]] + [w, x, y, z]))
        head = (f"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {width}\nHEIGHT {height}\n"
                f"VIEWPOINT {viewpoint}\nPOINTS {width * height}\nDATA binary\n")
        (folder / f"cloud_{i:06}.pcd").write_bytes(head.encode() + points.tobytes())
    return folder


def element(identifier, content):
    """Of EBML (RFC 8794); sizes in eight bytes."""
    return bytes.fromhex(identifier) + struct.pack(">Q", (1 << 56) | len(content)) + content


def number(value):
    return struct.pack(">Q", value)


def write_azure_mkv(source, folder):
    """Depth alone, without calibration and poses."""
    folder.mkdir(parents=True)
    width, height = source.size
    bitmap = struct.pack("<IiiHH4sIiiII", 40, width, height, 1, 16, b"b16g", 2 * width * height, 0, 0, 0, 0)
    video = element("B0", number(width)) + element("BA", number(height))
    track = element("AE", element("D7", number(1)) + element("73C5", number(1)) + element("83", number(1)) +
                    element("536E", b"DEPTH") + element("86", b"V_MS/VFW/FOURCC") + element("63A2", bitmap) +
                    element("E0", video))
    with open(folder / "scan.mkv", "wb") as file:
        file.write(element("1A45DFA3", element("4286", number(1)) + element("4282", b"matroska")))
        file.write(bytes.fromhex("18538067") + b"\x01" + b"\xff" * 7)  # a segment whose size is not said
        file.write(element("1549A966", element("2AD7B1", number(1000))) + element("1654AE6B", track))
        for i in range(len(source)):
            picture = numpy.frombuffer(source.raw_depth(i), "<u2").astype(">u2").tobytes()
            time = element("E7", number(round(source.times()[i] * 1e6)))
            file.write(element("1F43B675", time + element("A3", b"\x81\0\0\x80" + picture)))
    return folder / "scan.mkv"


WRITERS = {"replica": write_replica, "bop": write_bop, "phone-lidar": write_phone_lidar, "stray-scanner": write_stray_scanner,
           "polycam": write_polycam, "arkitscenes": write_arkitscenes, "record3d": write_record3d, "sens": write_sens,
           "ros2-db3": write_db3, "ros1": write_ros1, "pcd": write_pcd, "azure-mkv": write_azure_mkv}
CONVERTED = {"open3d": "", "7-scenes": "", "tum": "", "nerfstudio": "", "mcap": ".mcap", "ros2": ".mcap"}
