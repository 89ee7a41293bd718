# Writes the robot of ros2_bag.h as a bag of ROS 1, with ROS 1's own library:
#   python3 write_ros1_bag.py OUT.bag none|bz2|lz4
# Exit code 77: the library is not installed (Debian: python3-rosbag python3-sensor-msgs python3-tf2-msgs).
import struct
import sys

try:
    import genpy
    import rosbag
    from geometry_msgs.msg import TransformStamped
    from sensor_msgs.msg import CameraInfo, Image
    from tf2_msgs.msg import TFMessage
except ImportError:
    sys.exit(77)


def stamp(time_ns):
    return genpy.Time(time_ns // 10**9, time_ns % 10**9)


def transform(time_ns, parent, child, pose):
    t = TransformStamped()
    t.header.stamp, t.header.frame_id, t.child_frame_id = stamp(time_ns), parent, child
    move, turn = t.transform.translation, t.transform.rotation
    move.x, move.y, move.z, turn.x, turn.y, turn.z, turn.w = pose
    return TFMessage([t])


def camera(fx, fy):
    info = CameraInfo(height=2, width=4, distortion_model="plumb_bob", D=[0.0] * 5)
    info.K = [fx, 0, 1.5, 0, fy, 0.5, 0, 0, 1]
    info.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    info.P = [fx, 0, 1.5, 0, 0, fy, 0.5, 0, 0, 0, 1, 0]
    return info


def image(time_ns, frame, encoding, step, data):
    picture = Image(height=2, width=4, encoding=encoding, step=step, data=data)
    picture.header.stamp, picture.header.frame_id = stamp(time_ns), frame
    return picture


with rosbag.Bag(sys.argv[1], "w", compression=sys.argv[2], chunk_threshold=600) as bag:
    start = stamp(10**9)
    bag.write("/tf_static", transform(0, "base", "/depth_link", [0, 0, 0, -0.5, 0.5, -0.5, 0.5]), start)
    bag.write("/tf_static", transform(0, "depth_link", "colour_link", [0.015, 0, 0, 0, 0, 0, 1]), start)
    bag.write("/cam/depth/camera_info", camera(4, 4.5), start)
    bag.write("/cam/color/camera_info", camera(5, 5), start)
    for time_ns, x in ((10**9, 1), (1050000000, 2)):
        now = stamp(time_ns)
        bag.write("/tf", transform(time_ns, "map", "base", [x, 0, 0, 0, 0, 0, 1]), now)
        depth = struct.pack("<8H", *range(1000, 1008))
        bag.write("/cam/depth/image_raw", image(time_ns, "depth_link", "16UC1", 8, depth), now)
        bag.write("/cam/color/image_raw", image(time_ns + 3, "colour_link", "bgr8", 12, bytes([77]) * 24), now)
