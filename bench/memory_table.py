#!/usr/bin/env python3
"""Peak memory of the program on every recording of SCANKNIT_TEST_DATA, under each memory budget, as a table in Markdown.

Each run is a process of its own; its peak is what the kernel counted (wait4). The mesh of each budget is compared with that of
the largest. Exit code 1 if a run ends by a signal, or takes more than the budget and 15 %.

    SCANKNIT_TEST_DATA=DATA bench/memory_table.py --scanknit build/release/bin/scanknit [--budgets 512 1024 2048 4096] [--only WORD]
"""
import argparse
import hashlib
import os
import pathlib
import shlex
import sys
import tempfile

MOST_OVER_BUDGET = 1.15

# Name in the table: arguments after the command, with paths in the folder of the data.
RUNS = {
    "`rgbd_box_f200`": "run {data}/rgbd_box_f200",
    "`rgbd_d435i_table_48`": "run {data}/rgbd_d435i_table_48 --set fusion.voxel_size=2mm",
    "the same with `--texture`": "run {data}/rgbd_d435i_table_48 --set fusion.voxel_size=2mm --texture",
    "`rgbd_icl_3`": "run {data}/rgbd_icl_3 --preset icl_nuim",
    "`rgbd_iphone_lidar_corridor_73`": "run {data}/rgbd_iphone_lidar_corridor_73",
    "`rgbd_redwood_lr1_211`": "run {data}/rgbd_redwood_lr1_211",
    "the same, tracked, 1 cm": "run {data}/rgbd_redwood_lr1_211 --poses track --set fusion.voxel_size=1cm",
    "`rgbd_shelf_masks_15`": "run {data}/rgbd_shelf_masks_15",
    "`rgbd_sun3d_studyroom_5/3dmatch`": "run {data}/rgbd_sun3d_studyroom_5/3dmatch",
    "`rgbd_tum_fr1_rpy_150`": "run {data}/rgbd_tum_fr1_rpy_150",
    "the same, tracked": "run {data}/rgbd_tum_fr1_rpy_150 --preset tum_freiburg1 --poses track",
    "`realsense_bag`": "run {data}/realsense_bag/single_depth_color_640x480.bag",
    "`pclzf`": "run {data}/pclzf",
    "`range_stanford_bunny`": "align {data}/range_stanford_bunny/bun.conf",
}


def run(arguments, out):
    """(exit code, or minus the signal; peak in MiB)"""
    child = os.fork()
    if child == 0:
        log = os.open(out.with_suffix(".log"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(log, 1)
        os.dup2(log, 2)
        os.execv(arguments[0], arguments)
    _, status, usage = os.wait4(child, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_maxrss / 1024


def mesh_of(out):
    mesh = out / "model.ply"
    return hashlib.sha256(mesh.read_bytes()).hexdigest() if mesh.is_file() else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scanknit", required=True)
    parser.add_argument("--budgets", type=int, nargs="+", default=[512, 1024, 2048, 4096], metavar="MIB")
    parser.add_argument("--only", metavar="WORD", help="only recordings whose line has this word")
    given = parser.parse_args()
    data = os.environ.get("SCANKNIT_TEST_DATA")
    if not data:
        sys.exit("set SCANKNIT_TEST_DATA to the folder of the recordings")
    budgets = sorted(given.budgets, reverse=True)
    missed = False
    print("| recording |", *(f"{budget} MiB |" for budget in reversed(budgets)))
    print("|---|" + "---|" * len(budgets))
    for name, line in RUNS.items():
        if given.only and given.only not in name + line:
            continue
        cells, largest = [], None
        with tempfile.TemporaryDirectory(prefix="scanknit_memory.") as folder:
            for budget in budgets:
                out = pathlib.Path(folder) / str(budget)
                words = shlex.split(line.format(data=shlex.quote(data)))
                code, peak = run([given.scanknit, *words, "-o", str(out), "--quiet", "--set",
                                  f"fusion.memory_budget={budget}MiB"], out)
                mesh = mesh_of(out)
                largest = largest or mesh
                note = "" if code == 0 and mesh == largest else f", exit code {code}" if code else ", another mesh"
                is_over = code < 0 or peak > MOST_OVER_BUDGET * budget
                missed |= is_over
                cells.append(f"{'**' if is_over else ''}{peak:.0f}{'**' if is_over else ''}{note}")
        print(f"| {name} |", *(f"{cell} |" for cell in reversed(cells)), flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
