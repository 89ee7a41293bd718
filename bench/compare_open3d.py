#!/usr/bin/python3
"""Fuses a recording in Open3D's layout with Open3D's legacy ScalableTSDFVolume, or its tensor VoxelBlockGrid, and
writes the mesh if one is wanted.

Needs Debian's python3-open3d and python3-numpy. Prints one JSON object: times in milliseconds, counts, versions.
The same frames, poses, voxel size and truncation can be given to `scanknit run`; see compare.py.
"""

import argparse
import json
import resource
import statistics
import sys
import time
from pathlib import Path

import numpy
import open3d


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path, help="folder with depth/, color/, camera_intrinsic.json, trajectory.log")
    parser.add_argument("-o", "--output", type=Path, help="the mesh, a PLY file (default: none is made)")
    parser.add_argument("--voxel", type=float, default=0.004, help="voxel size, metres (default %(default)s)")
    parser.add_argument("--truncation", type=float, default=4.0, help="half width of the band, voxels (default %(default)s)")
    parser.add_argument("--max-depth", type=float, default=10.0, help="metres; farther depth is left out")
    parser.add_argument("--tensor", action="store_true", help="the tensor VoxelBlockGrid instead of the legacy volume")
    parser.add_argument("--frames", type=int, default=0, help="only the first N frames (default: all)")
    return parser.parse_args()


def read_poses(path):
    """Camera-to-world matrices of a trajectory.log: one line of three numbers, then four rows, for each frame."""
    numbers = numpy.array(path.read_text().split(), dtype=float)
    return numbers.reshape(-1, 19)[:, 3:].reshape(-1, 4, 4)


def read_frames(recording, depth_scale, max_depth):
    """Yields RGB-D pictures whose depth is metres as float, in the order of their names."""
    colours = {path.stem: path for path in (recording / "color").iterdir()}
    for path in sorted((recording / "depth").glob("*.png")):
        yield open3d.geometry.RGBDImage.create_from_color_and_depth(
            open3d.io.read_image(str(colours[path.stem])),
            open3d.io.read_image(str(path)),
            depth_scale=depth_scale,
            depth_trunc=max_depth,
            convert_rgb_to_intensity=False,
        )


def milliseconds_since(start):
    return 1000 * (time.perf_counter() - start)


def peak_memory_mib():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def legacy(arguments, camera, depth_scale, poses):
    """The milliseconds of each frame, and the function that makes the mesh."""
    volume = open3d.pipelines.integration.ScalableTSDFVolume(
        voxel_length=arguments.voxel,
        sdf_trunc=arguments.truncation * arguments.voxel,
        color_type=open3d.pipelines.integration.TSDFVolumeColorType.RGB8,
    )
    times = []
    for frame, pose in zip(read_frames(arguments.recording, depth_scale, arguments.max_depth), poses):
        world_to_camera = numpy.linalg.inv(pose)
        start = time.perf_counter()
        volume.integrate(frame, camera, world_to_camera)
        times.append(milliseconds_since(start))
    return times, volume.extract_triangle_mesh


def tensor(arguments, camera, depth_scale, poses):
    """The same with blocks of 8^3 voxels; a frame's time is that of finding its blocks and of integrating.

    Open3D 0.16 may end in an assertion of its own when it makes a mesh of the grid.
    """
    core = open3d.core
    grid = open3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight", "color"), (core.float32, core.float32, core.float32), ((1), (1), (3)),
        voxel_size=arguments.voxel, block_resolution=8, block_count=100000, device=core.Device("CPU:0"))
    intrinsic = core.Tensor(camera.intrinsic_matrix, core.float64)
    colours = {path.stem: path for path in (arguments.recording / "color").iterdir()}
    times = []
    for path, pose in zip(sorted((arguments.recording / "depth").glob("*.png")), poses):
        depth = open3d.t.io.read_image(str(path))
        colour = open3d.t.io.read_image(str(colours[path.stem]))
        extrinsic = core.Tensor(numpy.linalg.inv(pose), core.float64)
        start = time.perf_counter()
        blocks = grid.compute_unique_block_coordinates(
            depth, intrinsic, extrinsic, depth_scale, arguments.max_depth, arguments.truncation)
        grid.integrate(blocks, depth, colour, intrinsic, intrinsic, extrinsic, depth_scale, arguments.max_depth,
                       arguments.truncation)
        times.append(milliseconds_since(start))
    return times, lambda: grid.extract_triangle_mesh().to_legacy()


def main():
    arguments = parse_arguments()
    camera_file = arguments.recording / "camera_intrinsic.json"
    camera = open3d.io.read_pinhole_camera_intrinsic(str(camera_file))
    depth_scale = json.loads(camera_file.read_text()).get("depth_scale", 1000.0)
    poses = read_poses(arguments.recording / "trajectory.log")
    if arguments.frames:
        poses = poses[:arguments.frames]
    fuse = tensor if arguments.tensor else legacy
    before_mib = peak_memory_mib()
    integrate_ms, make_mesh = fuse(arguments, camera, depth_scale, poses)
    if not integrate_ms:
        sys.exit(f"{arguments.recording}: no frames")
    peak_mib = peak_memory_mib()

    result = {
        "open3d": open3d.__version__,
        "frames": len(integrate_ms),
        "voxel_m": arguments.voxel,
        "truncation_vox": arguments.truncation,
        "integrate_ms": {"median": statistics.median(integrate_ms), "mean": statistics.fmean(integrate_ms)},
        "before_mib": before_mib,
        "peak_mib": peak_mib,
    }
    if arguments.output:
        start = time.perf_counter()
        mesh = make_mesh()
        result["extract_ms"] = milliseconds_since(start)
        if not open3d.io.write_triangle_mesh(str(arguments.output), mesh):
            sys.exit(f"{arguments.output}: cannot be written")
        result.update(vertices=len(mesh.vertices), triangles=len(mesh.triangles))
    print(json.dumps(result, indent=2))


if __name__ == "__main__":
    main()
