"""ScanKnit: from depth frames to a coloured, correct mesh. NumPy arrays in and out.

    volume = scanknit.Volume(voxel_size=0.004)
    volume.integrate(depth, (fx, fy, cx, cy), pose, colour)
    mesh = volume.extract()
    mesh.write("model.glb")

    scanknit.scan("recording", "out", presets=["object"])  # tracking, loops, finishing, all files
    scanknit.capture("out", seconds=20)                    # the same from a scanner
    scanknit.align(["a.ply", "b.ply"], "out")              # several scans into one mesh
    scanknit.extract("head.nrrd", "head.glb", isovalue=300)

Metres, radians; pose is camera to world; the camera looks along +z, x right, y down.
"""

import numpy as _numpy  # fails here if it is missing, not after a scan whose result cannot be returned

from ._core import (Error, Frame, Mesh, Recording, ScanWarning, Volume, __version__, align, capture, extract,
                    scan)

__all__ = ["Error", "Frame", "Mesh", "Recording", "ScanWarning", "Volume", "__version__", "align", "capture",
           "extract", "scan"]
