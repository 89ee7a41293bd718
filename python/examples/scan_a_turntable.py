#!/usr/bin/env python3
"""What `scanknit run RECORDING --preset turntable` does: scan_a_turntable.py RECORDING FOLDER. Ctrl-C ends the frames:
what has been fused becomes the mesh, without looking for the turntable. The report is scan["report"], and no file."""

import signal
import sys

import scanknit

interrupts = []
signal.signal(signal.SIGINT, lambda *_: interrupts.append(True))  # else scan() raises KeyboardInterrupt at its end


def show(what, done, total):
    print(f"\r{what} {done} of {total} ", end="", file=sys.stderr)
    return not interrupts  # False ends the frames


scan = scanknit.scan(sys.argv[1], sys.argv[2], presets=["turntable"], progress=show, warning=print)
print(f"{scan['frames']['fused']} frames, {scan['triangles']:,} triangles: {scan['files']['glb']}")
