#!/usr/bin/env python3
"""What `scanknit run RECORDING --preset turntable` does: scan_a_turntable.py RECORDING FOLDER. Ctrl-C cancels it."""

import sys

import scanknit


def show(what, done, total):
    print(f"\r{what} {done} of {total} ", end="", file=sys.stderr)


scan = scanknit.scan(sys.argv[1], sys.argv[2], presets=["turntable"], progress=show, warning=print)
print(f"{scan['frames']['fused']} frames, {scan['triangles']:,} triangles: {scan['files']['glb']}")
