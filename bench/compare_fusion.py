#!/usr/bin/python3
"""Times ScanKnit's frames against Open3D's on a synthetic desk: 640 x 480 depth and colour, Kinect noise, 4 mm voxels.

Prints a table in Markdown: milliseconds a frame by stage, ratios against Open3D's tensor VoxelBlockGrid and its legacy
ScalableTSDFVolume in the same run, peak memory of each process before it fuses and while it does. Decoding pictures is
counted for neither: `time_frames`, beside the command, has them all in memory first, Open3D reads each before its clock
starts. Needs a built `scanknit` and Debian's python3-open3d and python3-numpy.
"""

import argparse
import json
import os
import statistics
import subprocess
from pathlib import Path

from compare import HERE, make_recording, run

STAGES = ("filter", "raycast", "track", "integrate", "frame")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scanknit", default="scanknit", help="the command (default: the one in PATH)")
    parser.add_argument("--python", default="/usr/bin/python3", help="a Python that has Open3D")
    parser.add_argument("--work", type=Path, default=Path("out/compare"), help="folder for recordings and meshes")
    parser.add_argument("--scene", default="desk")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--voxel-mm", type=float, default=4)
    parser.add_argument("--rounds", type=int, default=3, help="each program runs so often, in turn")
    return parser.parse_args()


def scanknit(arguments, recording, *options):
    return json.loads(run(Path(arguments.scanknit).with_name("time_frames"), recording,
                          "--voxel-mm", arguments.voxel_mm, *options))


def open3d(arguments, recording, *options):
    printed = run(arguments.python, HERE / "compare_open3d.py", recording,
                  "--voxel", arguments.voxel_mm / 1000, "--truncation", 4, *options)
    return json.loads(printed)


def peak_rss_mib(*command):
    """What the kernel counts for one process, whatever its exit code."""
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, _, usage = os.wait4(process.pid, 0)
    process.returncode = 0
    return usage.ru_maxrss / 1024


def scanknit_memory(arguments, recording, *options):
    """Peak MiB before the first frame is fused (all libraries loaded, the recording opened) and while frames are. No
    mesh is made, as in Open3D's run: nothing is as far from a surface as the isovalue."""
    before = peak_rss_mib(arguments.scanknit, "info", recording)
    peak = peak_rss_mib(arguments.scanknit, "run", recording, "-o", recording / "memory",
                        "--set", f"fusion.voxel_size={arguments.voxel_mm}mm", "--set", "extract.isovalue=1000", *options)
    return before, peak


def medians(reports, stage):
    times = [report[stage] for report in reports if stage in report]
    if not times:
        return None
    return tuple(statistics.median(time[key] for time in times) for key in ("median_ms", "p95_ms"))


def main():
    arguments = parse_arguments()
    arguments.work.mkdir(parents=True, exist_ok=True)
    recording = make_recording(arguments, arguments.scene, True)
    bands = {"fixed band of 4 voxels": ("--fixed-band",), "defaults": ()}
    runs = {f"ScanKnit, {band}, {poses}": (*options, *tracked) for poses, tracked in
            {"true poses": (), "tracked": ("--tracked",)}.items() for band, options in bands.items()}
    ours = {name: [] for name in runs}
    theirs = {"tensor": [], "legacy": []}
    for _ in range(arguments.rounds):
        for name, options in runs.items():
            ours[name].append(scanknit(arguments, recording, *options))
        theirs["tensor"].append(open3d(arguments, recording, "--tensor"))
        theirs["legacy"].append(open3d(arguments, recording))
    peer = {name: statistics.median(result["integrate_ms"]["median"] for result in results)
            for name, results in theirs.items()}

    print("Median (95th percentile) of milliseconds a frame; median of the rounds.\n")
    print("| program | " + " | ".join(STAGES) + " | integration: Open3D tensor / legacy are slower by |")
    print("|---|" + "---|" * (len(STAGES) + 1))
    for name, reports in ours.items():
        cells = []
        for stage in STAGES:
            time = medians(reports, stage)
            cells.append(f"{time[0]:.1f} ({time[1]:.1f})" if time else "")
        integrate = medians(reports, "integrate")[0]
        cells.append(f"{peer['tensor'] / integrate:.1f} / {peer['legacy'] / integrate:.1f}")
        print(f"| {name} | " + " | ".join(cells) + " |")
    for name, median_ms in peer.items():
        print(f"| Open3D {theirs[name][0]['open3d']}, {name} | | | | {median_ms:.1f} | | |")
    print("\nPeak resident memory of the process, MiB, without meshing.\n")
    print("| program | before fusing | while fusing | growth |")
    print("|---|---|---|---|")
    print_memory("ScanKnit, fixed band of 4 voxels",
                 *scanknit_memory(arguments, recording, "--set", "fusion.truncation_sigmas=0"))
    print_memory("ScanKnit, defaults", *scanknit_memory(arguments, recording))
    for name, results in theirs.items():
        print_memory(f"Open3D {results[0]['open3d']}, {name}",
                     *(statistics.median(result[key] for result in results) for key in ("before_mib", "peak_mib")))


def print_memory(name, before_mib, peak_mib):
    print(f"| {name} | {before_mib:.0f} | {peak_mib:.0f} | {peak_mib - before_mib:.0f} |")



if __name__ == "__main__":
    main()
