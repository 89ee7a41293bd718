#!/usr/bin/python3
"""Compares ScanKnit with Open3D's legacy TSDF on synthetic scenes whose surface is known exactly.

Both get the same frames, true poses and voxel size; ScanKnit with its defaults for all scenes, whose band follows the
noise, Open3D with each of the fixed bands asked for. `scanknit distance` judges the meshes. Prints a table in Markdown. Needs a built `scanknit` and, for Open3D, Debian's python3-open3d and python3-numpy.
"""

import argparse
import functools
import json
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
CASES = [("turntable", False), ("turntable", True), ("desk", True), ("plates", True)]


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scanknit", default="scanknit", help="the command (default: the one in PATH)")
    parser.add_argument("--python", default="/usr/bin/python3", help="a Python that has Open3D")
    parser.add_argument("--work", type=Path, default=Path("out/compare"), help="folder for recordings and meshes")
    parser.add_argument("--voxel-mm", type=float, default=4)
    parser.add_argument("--truncations", type=float, nargs="+", default=[4], help="Open3D's bands, voxels to each side")
    parser.add_argument("--max-depth", type=float, default=10, help="metres; farther depth is left out of both")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenes", nargs="*", help="only these scenes")
    return parser.parse_args()


def run(*command):
    """Runs a command and returns what it printed; says so and ends when it fails."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nexit code {done.returncode}\n{done.stderr}")
    return done.stdout


def make_recording(arguments, scene, noise):
    folder = arguments.work / f"{scene}{'_noise' if noise else ''}_{arguments.frames}"
    options = ["--frames", arguments.frames, "--seed", arguments.seed] + (["--noise"] if noise else [])
    run(arguments.scanknit, "synth", scene, "-o", folder, *options)
    return folder


def fuse_with_scanknit(arguments, recording):
    out = recording / "scanknit"
    run(arguments.scanknit, "run", recording, "-o", out,
        "--set", f"fusion.voxel_size={arguments.voxel_mm}mm", "--set", f"acquire.max_depth={arguments.max_depth}m")
    report = json.loads((out / "report.json").read_text())
    return out / "model.ply", report["stages"]["integrate"]["median_ms"]


def fuse_with_open3d(arguments, recording, truncation):
    mesh = recording / "open3d.ply"
    printed = run(arguments.python, HERE / "compare_open3d.py", recording, "-o", mesh,
                  "--voxel", arguments.voxel_mm / 1000, "--truncation", truncation, "--max-depth", arguments.max_depth)
    return mesh, json.loads(printed)["integrate_ms"]["median"]


def main():
    arguments = parse_arguments()
    arguments.work.mkdir(parents=True, exist_ok=True)
    print(f"Voxel {arguments.voxel_mm:g} mm, depth up to {arguments.max_depth:g} m, {arguments.frames} frames, "
          f"seed {arguments.seed}; distances of the mesh's area to the exact surface.\n")
    programs = {"ScanKnit": fuse_with_scanknit} | {
        f"Open3D, {band:g} voxels": functools.partial(fuse_with_open3d, truncation=band) for band in arguments.truncations}
    print("| scene | noise | program | mean mm | rms mm | p95 mm | complete % | integrate ms/frame |")
    print("|---|---|---|---|---|---|---|---|")
    for scene, noise in CASES:
        if arguments.scenes and scene not in arguments.scenes:
            continue
        recording = make_recording(arguments, scene, noise)
        for program, fuse in programs.items():
            mesh, median_ms = fuse(arguments, recording)
            error = json.loads(run(arguments.scanknit, "distance", mesh, recording, "--json"))
            area = error["area"]
            print(f"| {scene} | {'yes' if noise else 'no'} | {program} | {1000 * area['mean_m']:.3f} | "
                  f"{1000 * area['rms_m']:.3f} | {1000 * area['p95_m']:.3f} | {100 * error['share_complete']:.2f} | "
                  f"{median_ms:.1f} |", flush=True)


if __name__ == "__main__":
    main()
