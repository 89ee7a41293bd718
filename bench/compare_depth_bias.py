#!/usr/bin/python3
"""Measures how much of a sensor's systematic error of depth `calibrate camera` leaves: renders a board as a sensor with
such an error sees it, calibrates, and corrects the depth of a room that the same sensor sees. Prints a table in
Markdown: what is left of the error, root mean squares, by true depth.

  --sensor-set  more faults of the sensor, for the board: --sensor kinect1 --sensor-set time.rate=5

Needs a built `scanknit`, Debian's python3-numpy and python3-open3d, which reads the pictures.
"""

import argparse
import json
from pathlib import Path

import numpy
import open3d

from compare import run

BANDS_M = ((0.5, 1), (1, 2), (2, 3), (3, 4))
FEWEST_PIXELS = 1000  # fewer tell nothing of a band


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scanknit", default="scanknit", help="the command (default: the one in PATH)")
    parser.add_argument("--work", type=Path, default=Path("out/compare_depth_bias"), help="folder for recordings")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--frames", type=int, default=300, help="of the board")
    parser.add_argument("--sensor", default="ideal")
    parser.add_argument("--sensor-set", nargs="*", default=["colour.noise=0.01"], metavar="KEY=VALUE")
    parser.add_argument("--share", default="1.5%", help="the largest error at 4 m")
    parser.add_argument("--cells", default="4", help="its waves across the picture")
    return parser.parse_args()


def settings(values):
    return [part for value in values for part in ("--sensor-set", value)]


def render(arguments, scene, folder, frames, sensor, values, seed):
    run(arguments.scanknit, "synth", scene, "-o", folder, "--frames", frames, "--sensor", sensor, *settings(values),
        "--width", 640, "--height", 480, "--seed", seed, "--quiet")


def depths_m(recording):
    scale = json.loads((recording / "camera_intrinsic.json").read_text())["depth_scale"]
    return [numpy.asarray(open3d.io.read_image(str(file))) / scale for file in sorted((recording / "depth").glob("*.png"))]


def left_of(true, biased, corrected):
    """A row of the table, for the pixels that have depth in all three."""
    z, before, after = (numpy.concatenate([picture.ravel() for picture in pictures])
                        for pictures in (true, biased, corrected))
    cells = []
    for low, high in BANDS_M:
        band = (z >= low) & (z < high) & (before > 0) & (after > 0)
        if band.sum() < FEWEST_PIXELS:
            cells.append("-")
            continue
        rms_mm = [1000 * numpy.sqrt(numpy.mean((found[band] - z[band]) ** 2)) for found in (before, after)]
        cells.append(f"{rms_mm[0]:.2f} mm, {100 * rms_mm[1] / rms_mm[0]:.1f} %")
    return cells


def main():
    arguments = parse_arguments()
    bias = [f"bias.share={arguments.share}", f"bias.cells={arguments.cells}"]
    print("| seed | " + " | ".join(f"{low} to {high} m: error, left" for low, high in BANDS_M) + " |")
    print("|---|" + "---|" * len(BANDS_M))
    for seed in arguments.seeds:
        folder = arguments.work / f"{arguments.sensor}_{seed}"
        board, true, biased, corrected = (folder / name for name in ("board", "true", "biased", "corrected"))
        render(arguments, "calibration_board", board, arguments.frames, arguments.sensor, bias + arguments.sensor_set, seed)
        render(arguments, "room", true, 8, "ideal", [], seed)
        render(arguments, "room", biased, 8, "ideal", bias, seed)
        camera = folder / "CAMERA.yaml"
        run(arguments.scanknit, "calibrate", "camera", board, "--target", board / "target.yaml", "-o", camera, "--quiet")
        if "depth_bias" not in camera.read_text():
            print(f"| {seed} |" + " not determined |" * len(BANDS_M), flush=True)
            continue
        run(arguments.scanknit, "convert", biased, "-o", corrected, "--to", "open3d", "--set", f"acquire.camera={camera}")
        cells = left_of(*(depths_m(recording) for recording in (true, biased, corrected)))
        print(f"| {seed} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
