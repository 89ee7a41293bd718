#!/usr/bin/env python3
"""Compares the SHA-256 of the program's outputs, over all commands, presets and kinds of recordings, with the lists
beside this script. bytes.sha256 lists outputs that must never change, texts.sha256 lists texts for people.

    outputs.py PROGRAM                      compare everything
    outputs.py PROGRAM --suite run finish   compare two suites
    outputs.py PROGRAM --record texts       record a list again, of all suites or those named
    outputs.py PROGRAM --keep FOLDER        keep the outputs in a new folder, to look at those that differ
    outputs.py PROGRAM --lists FOLDER       use lists in another folder
    outputs.py PROGRAM --threads 1 3 64     compare everything with each of these numbers of threads
    outputs.py PROGRAM --targets SHIM       compare everything with each instruction set of this processor
    outputs.py --list                       list the suites
"""

import argparse
import pathlib
import platform
import subprocess
import sys
import tempfile
import time

import suites
from recorder import Missing, Recorder, Way

GROUPS = ("bytes", "texts")
SKIPPED = 77


def system():
    """The system that a list is valid for: libraries of other systems may compress and decode pictures differently."""
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        release = {}
    return f"{release.get('ID', '?')} {release.get('VERSION_ID', '?')} {platform.machine()}"


def read_list(path):
    """The system that a list is valid for, and its lines as a value by its name."""
    if not path.is_file():
        return None, {}
    recorded, lines = None, {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("# system: "):
            recorded = line.removeprefix("# system: ")
        elif line and not line.startswith("#"):
            value, name = line.split("  ", 1)
            lines[name] = value
    return recorded, lines


def write_list(path, lines):
    text = f"# Written by outputs.py --record {path.stem}, see docs/testing.md.\n# system: {system()}\n"
    path.write_text(text + "".join(f"{value}  {name}\n" for name, value in lines.items()), encoding="utf-8")


def differences(group, listed, found):
    """One message for each line that differs."""
    said = []
    for name in [*listed, *(name for name in found if name not in listed)]:
        if name not in found:
            said.append(f"{group}: {name}: listed, but no longer written")
        elif name not in listed:
            said.append(f"{group}: {name}: written, but not listed ({found[name]})")
        elif listed[name] != found[name]:
            said.append(f"{group}: {name}: {found[name]}, expected {listed[name]}")
    return said


def record_suite(program, suite, folder, way):
    """Runs a suite in a new folder; returns its lines."""
    folder.mkdir(parents=True)
    recorder = Recorder(program, folder, suite.__name__, way)
    began = time.monotonic()
    suite(recorder)
    counts = ", ".join(f"{len(recorder.lines[group])} {group}" for group in GROUPS)
    print(f"{way.name + ': ' if way.name else ''}{suite.__name__}: {counts}, {time.monotonic() - began:.1f} s", flush=True)
    return recorder.lines


def ways_of(given):
    """The ways in which all commands are run: as they are, or with other threads or instruction sets."""
    ways = [Way(f"{count} threads", threads=count) for count in given.threads]
    if given.targets:
        shim = {"LD_PRELOAD": str(given.targets.resolve())}
        names = subprocess.run(["/bin/true"], env=shim | {"SCANKNIT_TARGETS": "list"}, capture_output=True, text=True, check=True)
        ways += [Way(name, variables=shim | {"SCANKNIT_TARGETS": name}) for name in names.stdout.split()]
    return ways or [Way()]


def of_suites(lines, names):
    return {name: value for name, value in lines.items() if name.split("/", 1)[0] in names}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", type=pathlib.Path)
    parser.add_argument("--suite", nargs="+", metavar="NAME", choices=[suite.__name__ for suite in suites.SUITES])
    parser.add_argument("--record", nargs="+", metavar="GROUP", choices=GROUPS, default=[])
    parser.add_argument("--lists", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent)
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--threads", type=int, nargs="+", metavar="N", default=[])
    parser.add_argument("--targets", type=pathlib.Path, metavar="SHIM", help="the library that is built from targets_shim.cpp")
    given = parser.parse_args()
    if not given.list and given.program is None:
        parser.error("name the program")
    if given.record and (given.threads or given.targets):
        parser.error("lists are recorded as the commands are, without --threads and --targets")
    return given


def compare(given, found, names):
    """Compares, or writes, the two lists; returns the exit code."""
    said = []
    for group in GROUPS:
        path = given.lists / f"{group}.sha256"
        _, listed = read_list(path)
        if group in given.record:
            kept = {name: value for name, value in listed.items() if name not in of_suites(listed, names)}
            order = [suite.__name__ for suite in suites.SUITES]
            lines = sorted((kept | found[group]).items(), key=lambda line: order.index(line[0].split("/", 1)[0]))
            write_list(path, dict(lines))
            print(f"{path}: {len(lines)} lines, {len(found[group])} of them recorded again")
        else:
            said += differences(group, of_suites(listed, names), found[group])
    for line in said:
        print(line)
    if said:
        print(f"FAILED: {len(said)} outputs have changed. docs/testing.md says when a list may be recorded again")
    return 1 if said else 0


def main():
    given = parse_arguments()
    if given.list:
        print("\n".join(f"{suite.__name__}: {suite.__doc__}" for suite in suites.SUITES))
        return 0
    for group in GROUPS:
        recorded, _ = read_list(given.lists / f"{group}.sha256")
        if group not in given.record and recorded != system():
            print(f"SKIPPED: {group}.sha256 was recorded on {recorded}, this is {system()}; record lists with a"
                  " program that you trust (--lists FOLDER --record bytes texts) and compare with those")
            return SKIPPED
    said = [compare_way(given, way) for way in ways_of(given)]
    return next((code for code in said if code not in (0, SKIPPED)), min(said))


def compare_way(given, way):
    """Runs the suites in one way; returns the exit code."""
    found, names = {group: {} for group in GROUPS}, []
    with tempfile.TemporaryDirectory(prefix="scanknit_outputs.") as scratch:
        for suite in suites.SUITES:
            if given.suite and suite.__name__ not in given.suite:
                continue
            try:
                folder = (given.keep or pathlib.Path(scratch)).resolve() / way.name / suite.__name__
                lines = record_suite(given.program.resolve(), suite, folder, way)
            except Missing as reason:
                print(f"SKIPPED: {suite.__name__}: {reason}")
                continue
            names.append(suite.__name__)
            for group in GROUPS:
                found[group] |= lines[group]
    return compare(given, found, names) if names else SKIPPED


if __name__ == "__main__":
    sys.exit(main())
