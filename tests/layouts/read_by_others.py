"""What convert writes, read by others: Open3D, and a loader of nerfstudio's format by its documentation.

    read_by_others.py SCANKNIT

The points of each frame of a recording by others, in the world, must agree to 0.1 mm. Exit code 77: there is no recording, or no Open3D.
"""

import json
import pathlib
import sys
import tempfile

try:
    import numpy
    import open3d
except ImportError:
    print("SKIPPED: no Open3D for Python (Debian package python3-open3d)")
    sys.exit(77)

import same_mesh

ALLOWED_M = 1e-4
FRAMES = 3


def true_points(source, frame):
    """Of all pixels with depth, row by row, from the recording's own files."""
    width, height = source.size
    z = numpy.frombuffer(source.raw_depth(frame), "<u2").reshape(height, width) / 1000
    v, u = numpy.nonzero(z)
    fx, fy, cx, cy = source.k
    points = numpy.stack([(u - cx) * z[v, u] / fx, (v - cy) * z[v, u] / fy, z[v, u], numpy.ones(len(u))])
    return (numpy.array(source.poses[frame]) @ points)[:3].T


def points_for_nerfstudio(folder):
    """Points of each frame: cameras look along -z, the corner of the first pixel is (0, 0), c2w matrices."""
    scene = json.loads((folder / "transforms.json").read_text())
    to_original = numpy.linalg.inv(numpy.vstack([scene["applied_transform"], [0, 0, 0, 1]]))
    for frame in scene["frames"]:
        depth = numpy.asarray(open3d.io.read_image(str(folder / frame["depth_file_path"])))
        v, u = numpy.nonzero(depth)
        z = depth[v, u] * scene["depth_unit_scale_factor"]
        x = (u + 0.5 - scene["cx"]) / scene["fl_x"] * z
        y = (v + 0.5 - scene["cy"]) / scene["fl_y"] * z
        camera = numpy.stack([x, -y, -z, numpy.ones(len(u))])
        yield (to_original @ numpy.array(frame["transform_matrix"]) @ camera)[:3].T


def splat_points_off_m(folder, expected):
    """How far the coloured points that nerfstudio's splatting begins with lie from the recording's points."""
    scene = json.loads((folder / "transforms.json").read_text())
    cloud = open3d.io.read_point_cloud(str(folder / scene["ply_file_path"]))
    assert len(cloud.points) > 1000 and cloud.has_colors(), f"{len(cloud.points)} points of {scene['ply_file_path']}"
    cloud.transform(numpy.linalg.inv(numpy.vstack([scene["applied_transform"], [0, 0, 0, 1]])))
    everything = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(numpy.concatenate(expected)))
    return float(numpy.max(cloud.compute_point_cloud_distance(everything)))


def points_in_open3d(folder):
    camera = open3d.io.read_pinhole_camera_intrinsic(str(folder / "camera_intrinsic.json"))
    trajectory = open3d.io.read_pinhole_camera_trajectory(str(folder / "trajectory.log"))
    for parameters, picture in zip(trajectory.parameters, sorted((folder / "depth").iterdir())):
        depth = open3d.io.read_image(str(picture))
        cloud = open3d.geometry.PointCloud.create_from_depth_image(
            depth, camera, parameters.extrinsic, depth_scale=1000, depth_trunc=1000)
        yield numpy.asarray(cloud.points)


def main():
    whole = same_mesh.recording_of_others()
    if whole is None:
        return 77
    scanknit = pathlib.Path(sys.argv[1])
    is_right = True
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        source = same_mesh.source_of(whole, FRAMES, place, scanknit)
        for name, reader in (("nerfstudio", points_for_nerfstudio), ("open3d", points_in_open3d)):
            same_mesh.run(scanknit, "convert", source.folder, "-o", place / name, "--to", name)
            read = list(reader(place / name))
            assert len(read) == FRAMES, f"{name}: {len(read)} frames, expected {FRAMES}"
            for frame, points in enumerate(read):
                expected = true_points(source, frame)
                assert points.shape == expected.shape, f"{name}: {len(points)} points, expected {len(expected)}"
                off_m = float(numpy.linalg.norm(points - expected, axis=1).max())
                is_right &= off_m <= ALLOWED_M
                print(f"{name}, frame {frame}: {len(points)} points, at most {1000 * off_m:.6f} mm off")
        off_m = splat_points_off_m(place / "nerfstudio", [true_points(source, frame) for frame in range(FRAMES)])
        is_right &= off_m <= ALLOWED_M
        print(f"nerfstudio, the points for a splatting: at most {1000 * off_m:.6f} mm off")
    return 0 if is_right else 1


if __name__ == "__main__":
    sys.exit(main())
