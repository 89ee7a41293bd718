#!/usr/bin/python3
"""What a turntable adds at the end of a scan: seconds for the axis and the angles, and for fusing the frames again.

Renders a noisy recording of the tower with a hand and uneven angles, runs it with the preset, and prints the report's stages.

    bench/turntable_stop.py --scanknit build/release/bin/scanknit [--frames 1000] [--width 640] [--voxel 1mm] [--threads 2]
"""
import argparse
import json
import pathlib
import subprocess
import tempfile


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scanknit", required=True)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--width", type=int, default=640)
    parser.add_argument("--voxel", default="1mm")
    parser.add_argument("--threads", type=int, default=0, help="0: as many as the machine has")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        recording = pathlib.Path(folder) / "recording"
        size = ["--frames", str(given.frames), "--width", str(given.width), "--height", str(given.width * 3 // 4)]
        subprocess.run([given.scanknit, "synth", "tower", "--turntable", "--hand", "--noise", "--angle-noise", "0.5",
                        "--jpeg", "--quiet", "-o", str(recording)] + size, check=True)
        threads = ["--threads", str(given.threads)] if given.threads else []
        run = subprocess.run([given.scanknit, "run", str(recording), "--preset", "turntable", "--set",
                              f"fusion.voxel_size={given.voxel}", "-o", str(pathlib.Path(folder) / "out"), "--json",
                              "--quiet"] + threads, check=True, capture_output=True, text=True)
    report = json.loads(run.stdout)
    table = report["turntable"]
    assert table["is_refined"], table["reason"]
    seconds = {name: stage["total_ms"] / 1000 for name, stage in report["stages"].items()}
    scan = sum(seconds[name] for name in ("acquire", "filter", "track", "raycast", "integrate"))
    print(f"{report['frames']['fused']} frames, {table['key_frames']} key frames, {table['pairs']['all']} pairs, "
          f"{table['rms_m'] * 1000:.2f} mm and {table['rms_degrees']:.2f} degrees left")
    print(f"scan {scan:.1f} s; added: axis and angles {seconds['refine']:.1f} s, fusing again {seconds['fuse_again']:.1f} s; "
          f"extract {seconds['extract']:.2f} s; at most {report['peak_rss_mib']:.0f} MiB")


if __name__ == "__main__":
    main()
