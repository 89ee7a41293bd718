#!/usr/bin/python3
"""Tracks recordings of the synthetic scanner with all that a real sensor and a real hand do to them, and measures the
result against the truth: frames fused, ATE RMSE (Sturm et al. 2012, after Horn's alignment), surface there twice, the
mesh's mean error, and that error as a multiple of the mesh's with true poses. Prints tables in Markdown.

  --ablation   each effect of the sensor alone, and all but each
  --settings   the same recordings once more with other settings: --settings acquire.sensor=none,fusion.loop_closure=off
  --open3d     Open3D's RGB-D odometry on the same frames, from frame to frame

Needs a built `scanknit` and Debian's python3-numpy and, for Open3D, python3-open3d.
"""

import argparse
import json
import statistics
from pathlib import Path

import numpy

from compare import HERE, run

EFFECTS = ("disparity", "ranging", "shadow", "edges", "returns", "corners", "bias", "camera", "lens", "time", "shutter",
           "colour")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scanknit", default="scanknit", help="the command (default: the one in PATH)")
    parser.add_argument("--python", default="/usr/bin/python3", help="a Python that has Open3D")
    parser.add_argument("--work", type=Path, default=Path("out/compare_tracking"), help="folder for recordings, meshes")
    parser.add_argument("--scenes", nargs="+", default=["desk", "room", "clutter"])
    parser.add_argument("--sensors", nargs="+", default=["kinect1", "d435", "phone_lidar"])
    parser.add_argument("--path", default="hand")
    parser.add_argument("--person", default="nobody")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--frames", type=int, default=600)
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--height", type=int, default=240)
    parser.add_argument("--voxel-mm", type=float, default=10)
    parser.add_argument("--settings", nargs="*", default=[], metavar="KEY=VALUE[,KEY=VALUE]")
    parser.add_argument("--ablation", action="store_true")
    parser.add_argument("--open3d", action="store_true")
    return parser.parse_args()


def make_recording(arguments, scene, sensor, seed, effects=()):
    """`effects`: values of --sensor-set."""
    name = "_".join([scene, sensor, arguments.path, arguments.person, str(arguments.frames), str(seed),
                     *(effect.replace("=", "-") for effect in effects)])
    folder = arguments.work / name
    if not (folder / "ground_truth.json").exists():
        run(arguments.scanknit, "synth", scene, "--sensor", sensor, "--path", arguments.path, "--person", arguments.person,
            "--frames", arguments.frames, "--width", arguments.width, "--height", arguments.height, "--seed", seed,
            *(option for effect in effects for option in ("--sensor-set", effect)), "-o", folder)
    return folder


def trajectory(path):
    """{time: position} of a trajectory in TUM's format."""
    rows = (line.split() for line in path.read_text().splitlines() if line and not line.startswith("#"))
    return {float(row[0]): numpy.array(row[1:4], dtype=float) for row in rows}


def ate_mm(estimated, true):
    """RMSE of the positions, N x 3 each, after the rigid motion that fits best (Horn 1987), millimetres."""
    a, b = estimated - estimated.mean(axis=0), true - true.mean(axis=0)
    u, _, vt = numpy.linalg.svd(a.T @ b)
    flip = numpy.diag([1, 1, numpy.sign(numpy.linalg.det(u @ vt))])
    return 1000 * numpy.sqrt(((a @ (u @ flip @ vt) - b) ** 2).sum(axis=1).mean())


def scan(arguments, recording, poses, settings=()):
    """Runs `scanknit`, unless it did so already, and returns the folder of its results."""
    out = recording / "_".join([poses, *settings])
    if not (out / "report.json").exists():
        run(arguments.scanknit, "run", recording, "--poses", poses, "--set", f"fusion.voxel_size={arguments.voxel_mm}mm",
            *(option for setting in settings for option in ("--set", setting)), "-o", out)
    return out


def surface_error_mm(arguments, recording, out):
    error = json.loads(run(arguments.scanknit, "distance", out / "model.glb", recording, "--trajectory",
                           out / "trajectory.txt", "--json"))
    return 1000 * error["area"]["mean_m"]


def measure(arguments, recording, settings=()):
    tracked = scan(arguments, recording, "track", settings)
    true = scan(arguments, recording, "recording")
    report = json.loads((tracked / "report.json").read_text())
    found, truth = trajectory(tracked / "trajectory.txt"), trajectory(true / "trajectory.txt")
    times = [time for time in found if time in truth]
    error_mm = surface_error_mm(arguments, recording, tracked)
    return {
        "fused": 100 * report["frames"]["fused"] / report["frames"]["read"],
        "ate": ate_mm(numpy.array([found[time] for time in times]), numpy.array([truth[time] for time in times])),
        "doubled": 100 * report["doubled"]["share"],
        "error": error_mm,
        "ratio": error_mm / surface_error_mm(arguments, recording, true),
        "frame": report["total_ms"] / report["frames"]["read"],
    }


def print_table(first, rows):
    """`rows`: (name, measures of each seed)."""
    print(f"\n| {first} | frames fused | ATE RMSE | worst seed | there twice | mean error | times that with true poses | whole run a frame |")
    print("|---|" + "---|" * 7)
    for name, measures in rows:
        mean = {key: statistics.mean(measure[key] for measure in measures) for key in measures[0]}
        worst = max(measure["ate"] for measure in measures)
        print(f"| {name} | {mean['fused']:.1f} % | {mean['ate']:.1f} mm | {worst:.1f} mm | {mean['doubled']:.2f} % | "
              f"{mean['error']:.2f} mm | {mean['ratio']:.2f} | {mean['frame']:.0f} ms |", flush=True)


def measure_settings(arguments):
    variants = [()] + [tuple(settings.split(",")) for settings in arguments.settings]
    for scene in arguments.scenes:
        for sensor in arguments.sensors:
            for settings in variants:
                name = ", ".join([scene, sensor, *settings])
                yield name, [measure(arguments, make_recording(arguments, scene, sensor, seed), settings)
                             for seed in arguments.seeds]


def ablate(arguments):
    """Of the first scene and sensor."""
    def of(effects):
        return [measure(arguments, make_recording(arguments, arguments.scenes[0], arguments.sensors[0], seed, effects))
                for seed in arguments.seeds]
    yield "all effects", of(())
    for effect in EFFECTS:
        yield f"all but `{effect}`", of((f"{effect}=off",))
    for effect in EFFECTS:
        yield f"`{effect}` alone", of(tuple(f"{other}=off" for other in EFFECTS if other != effect))
    yield "none", of(tuple(f"{effect}=off" for effect in EFFECTS))


def print_open3d(arguments):
    print("\n| recording | program | frames tracked | ATE RMSE |\n|---|---|---|---|")
    for scene in arguments.scenes:
        for sensor in arguments.sensors:
            for seed in arguments.seeds:
                recording = make_recording(arguments, scene, sensor, seed)
                ours = measure(arguments, recording)
                print(f"| {scene}, {sensor}, seed {seed} | ScanKnit | {ours['fused']:.1f} % | {ours['ate']:.1f} mm |")
                result = json.loads(run(arguments.python, HERE / "compare_open3d_tracking.py", recording))
                error_mm = ate_mm(numpy.array(result["positions"]), numpy.array(result["true"]))
                print(f"| | Open3D {result['open3d']} | {result['tracked']} % | {error_mm:.1f} mm |", flush=True)


def main():
    arguments = parse_arguments()
    arguments.work.mkdir(parents=True, exist_ok=True)
    print(f"{arguments.frames} frames of {arguments.width} x {arguments.height}, path `{arguments.path}`, person "
          f"`{arguments.person}`, voxels of {arguments.voxel_mm:g} mm; means over the seeds {arguments.seeds}.")
    if arguments.open3d:
        return print_open3d(arguments)
    rows = ablate(arguments) if arguments.ablation else measure_settings(arguments)
    print_table("effects" if arguments.ablation else "scene, sensor", rows)


if __name__ == "__main__":
    main()
