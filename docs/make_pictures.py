#!/usr/bin/python3
"""Draws the pictures of docs/extract.md: meshes made by the program, in the frame of their cells, Highs as dots.

Each row shows one small volume: first the trilinear isosurface itself (the volume sampled forty times as densely), then
what the named deciders make of the eight or twelve samples. Needs numpy and Pillow (Debian: python3-numpy, python3-pil).

    docs/make_pictures.py build/release/bin/scanknit docs/images
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw

DENSER = 40
WIDTH = 720
LIGHT = np.array([0.35, -0.75, 0.56])


def trilinear(volume):
    """The trilinear interpolant of `volume` [z, y, x] on a grid DENSER times as fine."""
    for axis in range(3):
        count = (volume.shape[axis] - 1) * DENSER + 1
        place = np.linspace(0, volume.shape[axis] - 1, count)
        low = np.minimum(place.astype(int), volume.shape[axis] - 2)
        shape = [1, 1, 1]
        shape[axis] = count
        part = (place - low).reshape(shape)
        volume = np.take(volume, low, axis) * (1 - part) + np.take(volume, low + 1, axis) * part
    return volume


def mesh(scanknit, volume, isovalue, decider, spacing, folder):
    """Vertices in units of cells, and triangles, as `scanknit extract` writes them."""
    raw, obj = folder / "volume.raw", folder / "mesh.obj"
    np.asarray(volume, "<f4").tofile(raw)
    dims = "x".join(str(n) for n in reversed(volume.shape))
    subprocess.run([scanknit, "extract", raw, "--dims", dims, "--type", "float", "--spacing", str(spacing),
                    "--isovalue", str(isovalue), "--decider", decider, "-o", obj, "--quiet"], check=True)
    lines = [line.split() for line in obj.read_text().splitlines()]
    vertices = np.array([line[1:4] for line in lines if line[:1] == ["v"]], float)
    faces = np.array([[int(v.split("/")[0]) - 1 for v in line[1:4]] for line in lines if line[:1] == ["f"]])
    return vertices, faces


def view(points, cells_high):
    """Pixels, and depth away from the viewer, of points in cells: a parallel projection from the right and above."""
    turn, tilt = np.radians(62), np.radians(20)
    x, y, z = (np.asarray(points, float) - [0.5, 0.5, cells_high / 2]).T
    right, away = x * np.cos(turn) + y * np.sin(turn), -x * np.sin(turn) + y * np.cos(turn)
    up, depth = z * np.cos(tilt) + away * np.sin(tilt), away * np.cos(tilt) - z * np.sin(tilt)
    scale = WIDTH * 0.52 / max(1, 0.62 * cells_high)
    return np.stack([WIDTH / 2 + scale * right, WIDTH / 2 - scale * up], 1), depth


def picture(volume, vertices, faces):
    """The mesh in the frame of its cells; dots on the High samples of small volumes. Twice as large, then reduced."""
    high = volume["samples"].shape[0] - 1
    image = Image.new("RGB", (WIDTH, WIDTH), "white")
    draw = ImageDraw.Draw(image)
    corners = [(x, y, z) for z in range(high + 1) for y in (0, 1) for x in (0, 1)]
    pixels, _ = view(corners, high)
    for i, a in enumerate(corners):
        for j, b in enumerate(corners):
            if i < j and sum(abs(p - q) for p, q in zip(a, b)) == 1:
                draw.line([tuple(pixels[i]), tuple(pixels[j])], fill=(150, 150, 150), width=3)
    pixels, depth = view(vertices, high)
    for face in faces[np.argsort(-depth[faces].mean(1))]:
        a, b, c = vertices[face]
        normal = np.cross(b - a, c - a)
        light = abs(normal @ LIGHT) / max(np.linalg.norm(normal), 1e-12)
        shade = tuple(int(v * (0.45 + 0.55 * light)) for v in (236, 158, 84))
        polygon = [tuple(p) for p in pixels[face]]
        edge = tuple(v // 2 for v in shade) if len(faces) < 100 else shade
        draw.polygon(polygon, fill=shade, outline=edge)
    pixels, _ = view(corners, high)
    for (x, y, z), (u, v) in zip(corners, pixels):
        if volume["samples"][z, y, x] >= volume["isovalue"]:
            draw.ellipse([u - 11, v - 11, u + 11, v + 11], fill=(40, 60, 120))
    return image.resize((WIDTH // 2, WIDTH // 2), Image.LANCZOS)


def cells(*layers):
    """Samples from lists [z][y][x]."""
    return np.array(layers, float)


ROWS = {
    "ambiguous_face": (cells([[110, 70], [70, 120]], [[0, 0], [0, 0]]), [(92, "trilinear"), (93, "trilinear")]),
    "tunnel": (cells([[10, -1], [-1, -1]], [[-1, -1], [-1, 10]]), [(0, "trilinear"), (0, "asymptotic")]),
    "knit": (cells([[0, 0], [0, 0]], [[110, 70], [70, 120]], [[130, 60], [60, 140]]),
             [(95, "trilinear"), (95, "knit")]),
    "hole": (cells([[1, 1], [1, -1]], [[1.3, -0.8], [-0.8, 1.3]], [[-1, -1], [-1, 1]]), [(0, "trilinear"), (0, "lorensen")]),
}


def main():
    scanknit, target = sys.argv[1], pathlib.Path(sys.argv[2])
    for name, (volume, shown) in ROWS.items():
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            drawn = [(trilinear(volume), shown[0][0], "trilinear", 1 / DENSER)]
            drawn += [(volume, isovalue, decider, 1) for isovalue, decider in shown]
            parts = [picture({"samples": volume, "isovalue": isovalue},
                             *mesh(scanknit, samples, isovalue, decider, spacing, folder))
                     for samples, isovalue, decider, spacing in drawn]
        row = Image.new("RGB", (sum(p.width for p in parts), parts[0].height))
        for i, part in enumerate(parts):
            row.paste(part, (i * parts[0].width, 0))
        row.save(target / f"extract_{name}.png", optimize=True)


if __name__ == "__main__":
    main()
