#!/usr/bin/python3
"""Tracks a recording in Open3D's layout with Open3D and prints the camera's positions and the true ones as JSON.

By legacy compute_rgbd_odometry (hybrid term), from frame to frame; a frame that fails stays where the last was. Its
SLAM, frame to model, does not run with Debian's Open3D 0.16: on the CPU its bilateral filter is not implemented.

Needs Debian's python3-open3d and python3-numpy. See compare_tracking.py.
"""

import argparse
import json
from pathlib import Path

import numpy
import open3d

from compare_open3d import read_frames, read_poses


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path, help="folder with depth/, color/, camera_intrinsic.json, trajectory.log")
    parser.add_argument("--max-depth", type=float, default=5.0, help="metres; farther depth is left out")
    return parser.parse_args()


def odometry(arguments, camera, depth_scale):
    """Yields T_world_camera of each frame, or None where tracking fails."""
    settings = open3d.pipelines.odometry.OdometryOption(depth_max=arguments.max_depth)
    intrinsics = open3d.camera.PinholeCameraIntrinsic(
        camera["width"], camera["height"], *(camera["intrinsic_matrix"][i] for i in (0, 4, 6, 7)))
    before, pose = None, numpy.eye(4)
    for frame in read_frames(arguments.recording, depth_scale, arguments.max_depth):
        grey = open3d.geometry.RGBDImage.create_from_color_and_depth(
            frame.color, frame.depth, depth_scale=1, depth_trunc=arguments.max_depth, convert_rgb_to_intensity=True)
        if before is None:
            yield pose
        else:
            is_found, T_before_this, _ = open3d.pipelines.odometry.compute_rgbd_odometry(
                grey, before, intrinsics, numpy.eye(4),
                open3d.pipelines.odometry.RGBDOdometryJacobianFromHybridTerm(), settings)
            pose = pose @ T_before_this if is_found else pose
            yield pose if is_found else None
        before = grey


def main():
    arguments = parse_arguments()
    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    camera = json.loads((arguments.recording / "camera_intrinsic.json").read_text())
    poses = list(odometry(arguments, camera, camera.get("depth_scale", 1000.0)))
    true = [pose[:3, 3].tolist() for pose in read_poses(arguments.recording / "trajectory.log")]
    known = [i for i, pose in enumerate(poses) if pose is not None]
    print(json.dumps({
        "open3d": open3d.__version__,
        "tracked": round(100 * len(known) / len(poses), 1),
        "positions": [poses[i][:3, 3].tolist() for i in known],
        "true": [true[i] for i in known],
    }))


if __name__ == "__main__":
    main()
