#!/usr/bin/env python3
"""Lets single calls of the program fail, one run for each call, and checks that it ends in good order.

    faults.py PROGRAM SHIM                      an even choice of all faults, in about a minute
    faults.py PROGRAM SHIM --all                the k-th call fails, for every k, of every command and kind
    faults.py PROGRAM SHIM --command run align  only these commands
    faults.py PROGRAM SHIM --fault alloc write  only these kinds
    faults.py PROGRAM SHIM --json FILE          writes the figures there, too
    faults.py --list                            lists the commands and the kinds of faults

--openni2 FOLDER adds `record`: a libOpenNI2 with the emulated camera of tests/openni2. SHIM is the library that is built from fault_shim.cpp. In good order means: no signal and no hang; either success with the
same outputs as without the fault, or a documented exit code that fits it and one error that says what and where; each
output is the whole old one or the whole new one; no temporary file is left. See docs/testing.md.
"""

import argparse
import collections
import concurrent.futures
import dataclasses
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "outputs"))
import inputs  # noqa: E402
from recorder import SAME_ON_ALL_PROCESSORS, content_of, sha256, without_times  # noqa: E402

OLD = b"an old output, which must stay as it is\n"
CUT = "a recording without its end, which can be read"
RECORDED, MCAP = "live.mcap", b"\x89MCAP0\r\n"  # a whole file begins and ends with it
USUAL_RUNS = 600  # without --all
CONFIGURATION, INPUT, DEVICE, TRACKING, OUTPUT, MEMORY = 3, 4, 5, 6, 8, 9  # exit codes, docs/cli.md

# Exit codes that fit each kind of fault. Reading a module is reading, too, but the loader's own calls are never faulty.
FITTING = {"open": {CONFIGURATION, INPUT, TRACKING, OUTPUT, MEMORY}, "read": {CONFIGURATION, INPUT, TRACKING, OUTPUT, MEMORY},
           "mmap": {INPUT, TRACKING, MEMORY}, "write": {OUTPUT, INPUT}, "sync": {OUTPUT}, "rename": {OUTPUT}, "close": {OUTPUT, INPUT},
           "truncate": {OUTPUT}, "alloc": {MEMORY}, "thread": {MEMORY}, "stdout": {OUTPUT}}
# Faults of one frame, which is left out and counted (docs/cli.md, "Bad frames").
MAY_COST_FRAMES = {"open", "read", "mmap"}


@dataclasses.dataclass
class Command:
    """A command line with {in}, the folder of inputs. All that it writes lies in `out`, where `old` files lie before."""
    name: str
    line: str
    old: tuple = ()
    interim: str = ""  # a command line whose outputs are written on the way
    keeps_first_mesh: bool = False  # if a later step fails, the mesh of the frames that were fused is written all the same

    def arguments(self, folder):
        return [word.replace("{in}", str(folder)) for word in self.line.split()]

    def writes_new_recording(self):
        return self.name.startswith(("convert", "synth", "plan"))


COARSE = "--set fusion.voxel_size=2cm --threads 2"
CONVERTED = [Command(f"convert_{layout.replace('-', '_')}", f"convert {{in}}/desk -o out/{place} --to {layout} --threads 2")
             for layout, place in (("mcap", "r.mcap"), ("ros2", "r.mcap"), ("tum", "r"), ("open3d", "r"), ("7-scenes", "r"),
                                   ("nerfstudio", "r"), ("colmap", "r"))]
COMMANDS = [
    Command("run", f"run {{in}}/desk -o out --save-volume out/v.vdb {COARSE}",
            old=("model.glb", "model.ply", "preview.png", "trajectory.txt", "report.json", "report.html", "v.vdb")),
    Command("run_mcap", f"run {{in}}/desk.mcap -o out/m.ply --trajectory out/t.txt --report out/r.json {COARSE}",
            old=("m.ply", "t.txt", "r.json")),
    Command("run_tracked", f"run {{in}}/walk -o out/m.ply --poses track --to 3 {COARSE}", old=("m.ply",)),
    Command("run_finished", "run {in}/desk -o out/m.3mf --set fusion.voxel_size=5cm --threads 2 --set finish.watertight=full "
                            "--set finish.smooth=2 --set finish.triangles=2000", old=("m.3mf",)),
    Command("run_texture", f"run {{in}}/desk -o out/m.glb {COARSE} --texture --set export.texture_size=256 --compress",
            old=("m.glb",), interim=f"run {{in}}/desk -o out/m.glb {COARSE} --compress"),
    Command("run_turntable", "run {in}/table -o out/m.obj --preset turntable --angles {in}/table/angles.txt "
                             "--set fusion.voxel_size=8mm --threads 2 --every 2", old=("m.obj",), keeps_first_mesh=True),
    Command("extract", "extract {in}/ball.nrrd -o out/m.stl --isovalue 600 --threads 2", old=("m.stl",)),
    Command("extract_vdb", "extract {in}/desk.vdb -o out --threads 2", old=("model.glb", "report.json")),
    Command("extract_streamed", "extract {in}/long.nrrd -o out/m.ply --isovalue 600 --set extract.memory_budget=1MiB "
                                "--threads 2", old=("m.ply",)),
    Command("extract_dicom", "extract {in}/dicom -o out/m.ply --isovalue 600 --threads 2", old=("m.ply",)),
    Command("align", "align {in}/a.ply {in}/b.ply.gz -o out/m.ply --points out/p.pcd --initial {in}/initial.txt --threads 2",
            old=("m.ply", "p.pcd")),
    *CONVERTED,
    Command("convert_fakenect", "convert {in}/full -o out/r --to fakenect --threads 2"),
    Command("synth", "synth desk -o out/r --frames 3 --width 80 --height 60 --noise --threads 2"),
    Command("repair", "repair {in}/torn.mcap -o out/r.mcap --threads 2"),
    Command("plan", f"plan {{in}}/desk -o out/job {COARSE} --set fusion.bricks=64"),
    Command("work", "work out/job --threads 2"),
    Command("record", f"record --device openni2: --frames 3 -o out/{RECORDED}"),
    Command("cluster", f"cluster out/job -o out/m.ply --slurm --array-size 2 --threads 1 -- {{in}}/desk {COARSE.split(' --')[0]} "
                       "--set fusion.bricks=64", old=("m.ply",)),
    Command("join", "join {in}/job -o out/m.ply --threads 2", old=("m.ply",)),
    Command("info_mcap", "info {in}/desk.mcap --json --threads 2"),
    Command("info_ply", "info {in}/desk.ply --json --threads 2"),
    Command("info_vdb", "info {in}/desk.vdb --json --threads 2"),
    Command("distance", "distance {in}/desk.ply {in}/desk --json --threads 2"),
    Command("compare", "distance {in}/desk.ply {in}/desk.ply -o out --threads 2", old=("distance.json",)),
    Command("measure", "measure {in}/octahedron.obj --section z=1mm -o out --threads 2", old=("measure.json",)),
    Command("report", "report out --threads 2", old=("report.html",)),
    Command("config", "config print --config {in}/mine.yaml"),
    Command("man", "man -o out", old=("scanknit.1",)),
    Command("target", "calibrate target -o out/t.pdf", old=("t.pdf",)),
]


WRITTEN_BY_SLURM = (".out", ".err", ".ends")  # what a node's program says has times
# Stand for Slurm, which runs what it is given on other machines, where nothing fails: sbatch, then and there.
SLURM = {
    "sbatch": """#!/bin/sh
unset LD_PRELOAD
tasks=0
for word; do
  case $word in
    --output=*) out=${word#*=} ;;
    --error=*) err=${word#*=} ;;
    --array=0-*) tasks=${word#*=0-} ;;
  esac
  script=$word
done
for task in $(seq 0 "$tasks"); do
  sh "$script" >>"$(echo "$out" | sed "s/%a/$task/")" 2>>"$(echo "$err" | sed "s/%a/$task/")"
done
echo 7
""",
    "squeue": "#!/bin/sh\n",
    "scancel": "#!/bin/sh\n",
}


def environment(folder, shim=None, **more):
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("SCANKNIT_", "COLUMNS", "LINES"))}
    kept |= {"NO_COLOR": "1", "LC_ALL": "C.UTF-8", "TZ": "UTC", "GLIBC_TUNABLES": SAME_ON_ALL_PROCESSORS,
             "TMPDIR": str(folder / "tmp")}
    return kept | ({"LD_PRELOAD": str(shim)} if shim else {}) | more


@dataclasses.dataclass
class Ended:
    exit_code: int
    out: str
    err: str
    files: dict  # SHA-256 by name
    left: list  # temporary files
    seconds: float = 0
    counts: dict = dataclasses.field(default_factory=dict)


class Bench:
    """The inputs, and what each command does without a fault."""

    def __init__(self, program, shim, folder, openni2=None):
        self.program, self.shim, self.folder = program.resolve(), shim.resolve(), folder
        self.more = {"LD_LIBRARY_PATH": str(openni2.resolve())} if openni2 else {}
        self.inputs, self.slurm = folder / "inputs", folder / "slurm"
        self.inputs.mkdir()
        self.slurm.mkdir()

    def make_inputs(self):
        def call(line):
            done = subprocess.run([self.program, *line.split(), "--quiet"], cwd=self.inputs, env=environment(self.inputs),
                                  capture_output=True, text=True, check=False, timeout=300)
            if done.returncode:
                raise RuntimeError(f"scanknit {line}: {done.stderr}")
        size = "--width 80 --height 60"
        (self.inputs / "tmp").mkdir()
        call(f"synth desk -o desk --frames 4 {size}")
        call("synth tower -o table --turntable --frames 24 --width 160 --height 120")
        call("synth desk -o walk --frames 90 --width 160 --height 120")
        call("synth room -o full --frames 1 --width 640 --height 480 --jpeg")
        call("convert desk -o desk.mcap --to mcap")
        call("run desk -o desk.ply --set fusion.voxel_size=2cm")
        call("run desk -o coarse.ply --set fusion.voxel_size=10cm --save-volume desk.vdb")
        call("run desk -o folder --set fusion.voxel_size=2cm")
        call("plan desk -o job --set fusion.voxel_size=2cm --set fusion.bricks=64")
        shutil.copytree(self.inputs / "job", self.inputs / "planned")
        call("work job")
        whole = (self.inputs / "desk.mcap").read_bytes()
        (self.inputs / "torn.mcap").write_bytes(whole[:-100])
        samples = inputs.ball()
        inputs.write_nrrd(self.inputs / "ball.nrrd", samples, inputs.BALL, inputs.SPACING)
        inputs.write_dicom_series(self.inputs / "dicom", samples, inputs.BALL, inputs.SPACING)
        long = (64, 64, 64), (0.25, 0.25, 0.5)
        inputs.write_nrrd(self.inputs / "long.nrrd", inputs.ball(*long), *long)
        inputs.write_range_grid(self.inputs / "a.ply", inputs.hill_points(0))
        inputs.write_range_grid(self.inputs / "b.ply.gz", inputs.hill_points(50))
        (self.inputs / "initial.txt").write_text("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n")
        inputs.write_octahedron(self.inputs / "octahedron.obj")
        for name, text in SLURM.items():
            (self.slurm / name).write_text(text)
            (self.slurm / name).chmod(0o755)
        (self.inputs / "mine.yaml").write_text("fusion: {voxel_size: 3 mm}\n")

    def prepare(self, command, place):
        (place / "tmp").mkdir(parents=True)
        (place / "out").mkdir()
        if command.name == "report":
            shutil.copytree(self.inputs / "folder", place / "out", dirs_exist_ok=True)
        if command.name == "work":
            shutil.copytree(self.inputs / "planned", place / "out" / "job")
        for name in command.old:
            (place / "out" / name).write_bytes(OLD)

    def run(self, command, fault=None, seconds=120):
        """Runs the command in a new folder; `fault`: None, "stdout" or SCANKNIT_FAULT's value."""
        place = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        counts = place / "counts"
        self.prepare(command, place)
        told = environment(place, self.shim, SCANKNIT_FAULT_COUNTS=str(counts), **self.more)
        told["PATH"] = f"{self.slurm}:{told['PATH']}"
        if fault and fault != "stdout":
            told["SCANKNIT_FAULT"] = fault
        began = time.monotonic()
        with open("/dev/full" if fault == "stdout" else place / "stdout", "wb") as stdout:
            process = subprocess.Popen([self.program, *command.arguments(self.inputs)], cwd=place, env=told, stdout=stdout,
                                       stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)
            try:
                err = process.communicate(timeout=seconds)[1]
                exit_code = process.returncode
            except subprocess.TimeoutExpired:
                process.kill()
                err, exit_code = process.communicate()[1], None
        took = time.monotonic() - began
        found = {}
        if counts.is_file():
            found = {name: int(count) for name, count in (line.split() for line in counts.read_text().splitlines())}
        files, left = look_at(place)
        out = "" if fault == "stdout" else (place / "stdout").read_text(errors="replace").replace(str(place), "PLACE")
        shutil.rmtree(place)
        return Ended(exit_code, out, err.decode(errors="replace"), files, left, took, found)


def whole_report(path):
    """A value for a report, which has times: another one for each report that is cut short."""
    text = path.read_text(errors="replace")
    if path.suffix == ".html":
        return "page" if text.rstrip().endswith("</html>") else sha256(text)
    try:
        json.loads(text)
    except ValueError:
        return sha256(text)
    return "report"


def value_of(path, place):
    if path.read_bytes() == OLD:
        return sha256(OLD)
    content = content_of(path)
    if path.suffix == ".sh":  # names this run's own folder
        content = content.replace(os.fsencode(place), b"PLACE")
    if path.name == RECORDED:  # what the camera sent, at times of its own
        return "recording" if content.startswith(MCAP) and content.endswith(MCAP) else CUT if content.startswith(MCAP) else "torn"
    is_report = path.suffix in (".html", ".json") and (b"peak_rss_mib" in content or path.suffix == ".html")
    return whole_report(path) if is_report else sha256(content)


def look_at(place):
    """The files of `out` by name, and temporary ones anywhere."""
    everything = [path for path in place.rglob("*") if path.is_file() and path.parent != place]
    left = [path for path in everything if ".scanknit." in path.name or path.is_relative_to(place / "tmp")]
    written = [path for path in everything if path not in left and path.suffix not in WRITTEN_BY_SLURM]
    files = {path.relative_to(place).as_posix(): value_of(path, place) for path in written}
    return files, [path.relative_to(place).as_posix() for path in left]


LOSSES = re.compile(r'[1-9]\d* (dropped|lost)|"dropped": [1-9]|(?m:^(Dropped|Fault) )|"warnings": \[\n')


def told_of_losses(ended):
    """True if it was said that frames or parts were left out."""
    return "warning" in ended.err or bool(LOSSES.search(ended.out))


def without_seconds(text):
    return re.sub(r"(?m)^Seconds .*$|: \d+ pictures, [0-9.]+ MB$", "", without_times(text))


def is_of_losses(command, name, kind, ended_value):
    """True for what a scan that failed writes of the frames that it had, if frames could be lost by the fault."""
    if name == f"out/{RECORDED}":  # what came before a disk was full stays
        return kind in ("write", "sync", "close", "alloc") and ended_value == CUT
    if command.keeps_first_mesh and name.endswith(".obj"):
        return True
    return kind in MAY_COST_FRAMES and name.endswith((".vdb", ".txt", "report.json", "report.html"))


def complaints(command, fault, ended, wholes):
    """What is wrong about a run with a fault; `wholes`: the runs without it, also that of what is written on the way."""
    kind, whole = fault.split(":")[0], wholes[0]
    can_open_nothing = kind == "open" and fault.endswith(":on")  # then it cannot list the folder that it would empty
    said = []
    if ended.exit_code is None:
        return ["hangs"]
    if ended.exit_code < 0 or ended.exit_code >= 128:
        return [f"ends by signal {-ended.exit_code}: {ended.err.strip()[-300:]}"]
    if ended.left:
        said.append(f"leaves {', '.join(ended.left)}")
    old = {f"out/{name}": sha256(OLD) for name in command.old}
    if command.name == "report":
        old = {name: value for name, value in whole.files.items() if name != "out/report.html"} | old
    if ended.exit_code == whole.exit_code:
        same = ended.files == whole.files and (kind == "stdout" or without_seconds(ended.out) == without_seconds(whole.out))
        if not same and not (kind in MAY_COST_FRAMES and told_of_losses(ended)):
            said.append(f"succeeds with other output: {differences(ended, whole)}")
        return said
    errors = [line for line in ended.err.splitlines() if re.search(r"(^|: )error: ", line)]
    if not errors or (len(errors) > 1 and not fault.endswith(":on")):
        said.append(f"exit code {ended.exit_code} with {len(errors)} errors: {ended.err.strip()[-300:]}")
    elif ended.exit_code not in fitting(command, kind):
        said.append(f"exit code {ended.exit_code} does not fit: {errors[0]}")
    elif not re.search(r"\bout\b|inputs/|stdout|memory|thread", ended.err):
        said.append(f"says not where: {errors[0]}")
    for name, value in ended.files.items():
        if value not in (old.get(name), *(other.files.get(name) for other in wholes)) and not is_of_losses(command, name, kind, value):
            said.append(f"{name} is neither the old nor the new one")
        elif name not in old and command.writes_new_recording() and ended.files != whole.files and not can_open_nothing:
            said.append(f"{name} is part of a recording that is not whole")
    said += [f"{name} is gone" for name in old if name not in ended.files]
    return said


def fitting(command, kind):
    """Exit codes. A .vdb is read by a child process first, for which too little memory is the file's fault."""
    return FITTING[kind] | ({INPUT} if kind in ("alloc", "thread") and command.name.endswith("_vdb") else set())


def differences(ended, whole):
    names = sorted(name for name in {*ended.files, *whole.files} if ended.files.get(name) != whole.files.get(name))
    return ", ".join(names) or "stdout"


def evenly(count, wanted):
    """At most `wanted` of the numbers 1 to `count`, evenly spread."""
    if wanted >= count:
        return list(range(1, count + 1))
    return sorted({1 + (2 * i + 1) * count // (2 * wanted) for i in range(wanted)})


def plan(commands, kinds, wholes, wanted):
    """(command, fault) for each run. `wanted`: how many in all, or None for all there are."""
    counts = {name: of_command[0].counts for name, of_command in wholes.items()}
    series = [(command, kind, mode) for command in commands for kind in kinds if kind != "stdout"
              for mode in ("", ":on") if counts[command.name].get(kind, 0) > 0]
    runs = [(command, "stdout") for command in commands if "stdout" in kinds and wholes[command.name][0].out]
    share = None if wanted is None else max(1, (wanted - len(runs)) // max(1, len(series)))
    for command, kind, mode in series:
        count = counts[command.name][kind]
        runs += [(command, f"{kind}:{k}{mode}") for k in evenly(count, count if share is None else share)]
    return runs


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", type=pathlib.Path)
    parser.add_argument("shim", nargs="?", type=pathlib.Path)
    parser.add_argument("--openni2", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--runs", type=int, default=USUAL_RUNS, help="about how many without --all")
    parser.add_argument("--command", nargs="+", metavar="NAME", choices=[command.name for command in COMMANDS])
    parser.add_argument("--fault", nargs="+", metavar="KIND", choices=list(FITTING))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--list", action="store_true")
    given = parser.parse_args()
    if not given.list and (given.program is None or given.shim is None):
        parser.error("name the program and the shim")
    return given


def measure_wholes(bench, commands):
    """Each command without a fault; the commands must succeed."""
    wholes = {}
    for command in commands:
        lines = [command.line, command.interim] if command.interim else [command.line]
        wholes[command.name] = [bench.run(dataclasses.replace(command, line=line)) for line in lines]
        for whole in wholes[command.name]:
            if whole.exit_code != 0:
                raise RuntimeError(f"{command.name} without a fault: exit code {whole.exit_code}: {whole.err}")
    return wholes


def main():
    given = parse_arguments()
    if given.list:
        print("commands:", *(command.name for command in COMMANDS))
        print("kinds:", *FITTING)
        return 0
    commands = [command for command in COMMANDS if given.command is None or command.name in given.command]
    if given.openni2 is None:
        commands = [command for command in commands if command.name != "record"]
    kinds = given.fault or list(FITTING)
    began = time.monotonic()
    found, counts = [], collections.Counter()
    with tempfile.TemporaryDirectory(prefix="scanknit_faults.") as folder:
        bench = Bench(given.program, given.shim, pathlib.Path(folder), given.openni2)
        bench.make_inputs()
        wholes = measure_wholes(bench, commands)
        runs = plan(commands, kinds, wholes, None if given.all else given.runs)

        def check(run):
            command, fault = run
            of_command = wholes[command.name]
            limit_s = 10 + 20 * of_command[0].seconds  # on a busy machine
            return run, complaints(command, fault, bench.run(command, fault, limit_s), of_command)

        with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
            for (command, fault), said in pool.map(check, runs):
                counts[f"{command.name} {fault.split(':')[0]}"] += 1
                if said:
                    found.append({"command": command.name, "fault": fault, "said": said})
                    print(f"{command.name} {fault}: {'; '.join(said)}", flush=True)
    seconds = time.monotonic() - began
    print(f"{len(runs)} faults in {len(commands)} commands, {len(found)} exceptions, {seconds:.0f} s")
    if given.json:
        figures = {"runs": len(runs), "exceptions": found, "seconds": round(seconds), "by_command_and_fault": counts}
        given.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
