# Writes a LiDAR that goes along x towards a wall at x = 4 m, one metre in 0.4 s, as a bag of ROS 1, with ROS 1's own
# library: three sweeps of 4 rings x 16 points, as Velodyne's driver writes them.
#   python3 write_lidar_bag.py OUT.bag
# Exit code 77: the library is not installed (Debian: python3-rosbag python3-sensor-msgs python3-tf2-msgs).
import struct
import sys

try:
    import genpy
    import rosbag
    from geometry_msgs.msg import TransformStamped
    from sensor_msgs.msg import PointCloud2, PointField
    from tf2_msgs.msg import TFMessage
except ImportError:
    sys.exit(77)

BEGIN_NS = 1700000000 * 10**9
TURN_NS = 10**8


def stamp(time_ns):
    return genpy.Time(time_ns // 10**9, time_ns % 10**9)


def place(time_ns):
    return (time_ns - BEGIN_NS) / 4e8


def transform(time_ns):
    t = TransformStamped()
    t.header.stamp, t.header.frame_id, t.child_frame_id = stamp(time_ns), "map", "velodyne"
    t.transform.translation.x = place(time_ns)
    t.transform.rotation.w = 1
    return TFMessage([t])


def sweep(end_ns):
    cloud = PointCloud2(height=1, width=64, is_bigendian=False, point_step=22, row_step=22 * 64, is_dense=True)
    cloud.header.stamp, cloud.header.frame_id = stamp(end_ns), "velodyne"
    for name, offset, kind in (("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("ring", 16, 4), ("time", 18, 7)):
        cloud.fields.append(PointField(name=name, offset=offset, datatype=kind, count=1))
    data = b""
    for column in range(16):
        time_ns = end_ns - TURN_NS + column * TURN_NS // 16
        for ring in range(4):
            x = 4 - place(time_ns)
            data += struct.pack("<ffffHf", x, (column - 8) * 0.2, (ring - 1.5) * 0.3, 1, ring, (time_ns - end_ns) * 1e-9)
    cloud.data = data
    return cloud


with rosbag.Bag(sys.argv[1], "w") as bag:
    for i in range(-1, 41):
        bag.write("/tf", transform(BEGIN_NS + i * 10**7), stamp(BEGIN_NS + i * 10**7))
    for i in range(3):
        end_ns = BEGIN_NS + (i + 1) * TURN_NS
        bag.write("/velodyne_points", sweep(end_ns), stamp(end_ns))
