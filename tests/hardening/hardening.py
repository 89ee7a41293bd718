#!/usr/bin/env python3
"""Checks that the installed program, libraries and modules are as hard to exploit as cmake/Hardening.cmake asks.

    hardening.py CMAKE BUILD     installs the build into a temporary folder and checks each ELF file there

Of each file: position-independent, relocations read-only and bound at the start, no executable stack, no segment that is
writable and executable, no search path but relative to $ORIGIN.
"""

import pathlib
import re
import struct
import subprocess
import sys
import tempfile


def readelf(path, *options):
    return subprocess.run(["readelf", "-W", *options, path], capture_output=True, text=True, check=True).stdout


def elf_files(folder):
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not path.is_symlink() and path.suffix != ".o":
            with path.open("rb") as file:
                if file.read(4) == b"\x7fELF":
                    yield path


def segments(path):
    """(type, flags) of each."""
    return re.findall(r"(?m)^\s+(\w+)\s+0x\w+ 0x\w+ 0x\w+ 0x\w+ 0x\w+ ([R ][W ][E ])", readelf(path, "-l"))


def faults_of(path):
    """What is wrong with a file, one message each."""
    dynamic, parts = readelf(path, "-d"), segments(path)
    flags = " ".join(re.findall(r"\((?:FLAGS|FLAGS_1)\)(.*)", dynamic))
    if struct.unpack_from("<H", path.read_bytes(), 16)[0] != 3:  # ET_DYN
        yield "is not position-independent"
    if path.parent.name == "bin" and "PIE" not in flags:
        yield "is not linked as a position-independent executable"
    if not any(part[0] == "GNU_RELRO" for part in parts):
        yield "its relocations stay writable (no GNU_RELRO)"
    if "NOW" not in flags:
        yield "is bound lazily (no BIND_NOW): part of its relocations stay writable"
    if any(part[0] == "GNU_STACK" and "E" in part[1] for part in parts) or not any(part[0] == "GNU_STACK" for part in parts):
        yield "its stack is executable"
    if any(part[0] == "LOAD" and "W" in part[1] and "E" in part[1] for part in parts):
        yield "has a segment that is writable and executable"
    if "TEXTREL" in dynamic:
        yield "changes its own code when it is loaded (TEXTREL)"
    for paths in re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", dynamic):
        if not all(re.match(r"\$ORIGIN(/|$)", one) for one in paths.split(":")):
            yield f"looks for libraries in {paths}, expected folders relative to $ORIGIN"


def main():
    cmake, build = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    said, files = [], 0
    with tempfile.TemporaryDirectory(prefix="scanknit_hardening.") as folder:
        place = pathlib.Path(folder)
        subprocess.run([cmake, "--install", build, "--prefix", place], check=True, stdout=subprocess.DEVNULL)
        for path in elf_files(place):
            files += 1
            said += [f"{path.relative_to(place)}: {fault}" for fault in faults_of(path)]
    for line in said:
        print(line)
    print(f"{files} files, {len(said)} faults")
    return 1 if said or files < 10 else 0


if __name__ == "__main__":
    sys.exit(main())
