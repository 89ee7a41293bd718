#!/usr/bin/env python3
"""Fuses a recording that has poses and writes the mesh: the main job, frame by frame.

    scanknit synth turntable --frames 120 --noise -o recording
    python3 mesh_a_recording.py recording model.glb --voxel-size 0.002
"""

import argparse

import scanknit


def main() -> None:
    parser = argparse.ArgumentParser(description="Fuse a recording that has poses, and write the mesh.")
    parser.add_argument("recording")
    parser.add_argument("output", help=".glb, .ply, .obj, .stl or .3mf")
    parser.add_argument("--voxel-size", type=float, default=0.004, help="metres")
    arguments = parser.parse_args()

    volume = scanknit.Volume(arguments.voxel_size)
    recording = scanknit.Recording(arguments.recording)
    for frame in recording:
        # frame.depth and frame.colour are NumPy arrays: here is the place to mask or change them.
        if frame.pose is None:
            continue
        volume.integrate(
            frame.depth,
            frame.intrinsics,
            frame.pose,
            frame.colour,
            colour_intrinsics=frame.colour_intrinsics,
            colour_pose=frame.colour_pose,
        )

    mesh = volume.extract(min_component_triangles=300)  # smaller pieces float in the air
    mesh.write(arguments.output, up=recording.up)
    extent_mm = 1000 * (mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0))
    size = " x ".join(f"{length:.0f}" for length in extent_mm)
    print(f"{volume.frames} frames, {len(mesh.triangles):,} triangles, {size} mm: {arguments.output}")


if __name__ == "__main__":
    main()
