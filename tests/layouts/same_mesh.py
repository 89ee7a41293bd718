"""One recording by others in every layout that is read gives one mesh.

    same_mesh.py SCANKNIT [--frames N] [--time TIME_READING] [LAYOUT ...]

The recording is rgbd_redwood_lr1_211 of SCANKNIT_TEST_DATA. Each layout is converted by `scanknit convert` or written by
layouts.py, and then fused at its own poses; its mesh is compared with the source's. With --time, the program bench/time_reading
also reads each layout. Exit code 77: there is no recording.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

try:
    import numpy
except ImportError:
    print("SKIPPED: no NumPy (Debian package python3-numpy)")
    sys.exit(77)

import layouts

# How far a vertex may lie from the source's. Without a bound the file has the same bytes.
BOUNDS_M = {
    "sens": 1e-4,  # poses of 32 bits: a voxel on the border of a pixel takes its neighbour
    "pcd": 1e-4,  # the camera is fitted to points of 32 bits
}
SETTINGS = ["--set", "acquire.sensor=none", "--set", "fusion.voxel_size=1cm", "--set", "acquire.max_depth=3m", "--set", "export.formats=[ply]"]
# What azure-mkv cannot hold, or holds by a calibration of its own, is left out of both.
DEPTH_ALONE = ["--poses", "still", "--set", "acquire.intrinsics=[525,525,319.5,239.5]"]


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def recording_of_others():
    """The recording; None, and told, where it is not there."""
    beside = pathlib.Path(__file__).resolve().parents[3] / "shared/data"
    whole = pathlib.Path(os.environ.get("SCANKNIT_TEST_DATA", beside)) / "rgbd_redwood_lr1_211"
    if whole.exists():
        return whole
    print(f"SKIPPED: no recording {whole}")
    return None


def source_of(whole, frames, folder, scanknit):
    """The first frames of the recording."""
    for kind, name in (("depth", "depth"), ("image", "color")):
        (folder / "source" / name).mkdir(parents=True)
        for picture in sorted((whole / kind).iterdir())[:frames]:
            shutil.copyfile(picture, folder / "source" / name / picture.name)
    shutil.copyfile(whole / "camera_intrinsic.json", folder / "source/camera_intrinsic.json")
    lines = (whole / "trajectory.log").read_text().splitlines(keepends=True)
    trajectory = folder / "source/trajectory.log"
    trajectory.write_text("".join(lines[:5 * frames]))
    run(scanknit, "convert", folder / "source", "-o", folder / "pgm", "--to", "fakenect")
    source = layouts.Source(folder / "source", *(
        sorted((folder / "pgm").glob(name), key=lambda file: float(file.name.split("-")[1])) for name in ("d-*.pgm", "r-*.ppm")))
    trajectory.write_text("".join(f"{i} {i} {i + 1}\n" + "".join(" ".join(map(repr, row)) + "\n" for row in pose)
                                  for i, pose in enumerate(source.poses)))
    return source


def mesh_of(scanknit, recording, name, more=()):
    out = recording.parent / f"mesh_of_{name}"
    run(scanknit, "run", recording, "-o", out, "-q", *SETTINGS, *more)
    return out / "model.ply"


def difference_m(scanknit, mesh, expected):
    """The largest distance of a vertex to the other mesh, both ways."""
    largest = 0
    for one, other in ((mesh, expected), (expected, mesh)):
        found = json.loads(run(scanknit, "distance", one, other, "--json"))["vertices"]
        largest = max(largest, found["max_m"], -found["min_m"])
    return largest


def is_right(scanknit, name, recording, expected):
    mesh = mesh_of(scanknit, recording, name, DEPTH_ALONE if name == "azure-mkv" else ())
    if mesh.read_bytes() == expected.read_bytes():
        print(f"{name:14} the same bytes")
        return True
    off_m = difference_m(scanknit, mesh, expected)
    allowed_m = BOUNDS_M.get(name)
    print(f"{name:14} other bytes, {1000 * off_m:.4f} mm off")
    if allowed_m is None or off_m > allowed_m:
        print(f"    WRONG: expected {'the same bytes' if allowed_m is None else f'at most {1000 * allowed_m} mm'}")
        return False
    return True


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scanknit", type=pathlib.Path)
    parser.add_argument("layouts", nargs="*")
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--time", type=pathlib.Path)
    options = parser.parse_args()
    whole = recording_of_others()
    if whole is None:
        return 77
    all_right = True
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        source = source_of(whole, options.frames, place, options.scanknit)
        expected = mesh_of(options.scanknit, source.folder, "source")
        shutil.copytree(source.folder, place / "depth_alone", ignore=shutil.ignore_patterns("color"))
        depth_alone = mesh_of(options.scanknit, place / "depth_alone", "depth_alone", DEPTH_ALONE)
        for name in options.layouts or [*layouts.CONVERTED, *layouts.WRITERS]:
            if name in layouts.CONVERTED:
                recording = place / (name + layouts.CONVERTED[name])
                run(options.scanknit, "convert", source.folder, "-o", recording, "--to", name)
            else:
                recording = layouts.WRITERS[name](source, place / name)
            if recording is None:
                print(f"{name:14} SKIPPED: no rosbag (Debian packages python3-rosbag python3-sensor-msgs python3-tf2-msgs)")
                continue
            all_right &= is_right(options.scanknit, name, recording, depth_alone if name == "azure-mkv" else expected)
            if options.time and name != "azure-mkv":  # it does not say its camera
                print("    " + run(options.time, recording).strip())
    return 0 if all_right else 1


if __name__ == "__main__":
    sys.exit(main())
