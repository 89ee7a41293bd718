"""scan(), capture(), align(), extract(): what the program does, byte by byte, with Python's callables in between."""

import ast
import json
import os
import subprocess
import sys
import time
import unittest

import numpy as np

import scanknit
from with_a_recording import SOURCE, VOXEL, WithARecording

SETTINGS = [f"fusion.voxel_size={VOXEL}"]


class WithScans(WithARecording):
    def same_files(self, names, folder, other):
        for name in names:
            self.same_file(os.path.join(folder, name), os.path.join(other, name))

    def same_report(self, scan, folder, names):
        with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
            report = json.load(file)
        self.assertEqual(scan["report"].keys(), report.keys())
        for name in names:
            self.assertEqual(scan["report"][name], report[name], name)

    def refused(self, code, call, *arguments, **keywords):
        with self.assertRaises(scanknit.Error) as caught:
            call(*arguments, **keywords)
        self.assertEqual(caught.exception.code, code, str(caught.exception))


class Scans(WithScans):
    def scan(self, name, **keywords):
        return scanknit.scan(self.recording, self.path(name), settings=SETTINGS, **keywords)

    def test_a_scan_has_the_bytes_of_scanknit_run(self):
        seen, warnings = [], []
        scan = scanknit.scan(self.recording, self.path("python"), presets=["room"],
                             settings=[f"fusion.voxel_size={VOXEL}", "finish.smooth=2"],
                             progress=lambda what, done, total: seen.append((what, done, total)),
                             warning=warnings.append)
        self.run_program("run", self.recording, "--preset", "room", "--set",
                         f"fusion.voxel_size={VOXEL}", "--set", "finish.smooth=2", "-o", self.path("run"))
        self.same_files(("model.glb", "model.ply", "trajectory.txt", "preview.png", "error.png"), self.path("python"),
                        self.path("run"))
        self.assertEqual(scan["frames"], {"read": 6, "fused": 6, "dropped": 0, "lost": 0})
        self.assertEqual([number for number, _ in scan["poses"]], list(range(6)))
        self.assertIn(("fusing", 6, 6), seen)
        self.assertEqual([str(warning) for warning in warnings], [warning.text for warning in scan["warnings"]])
        self.same_report(scan, self.path("run"), ("status", "exit_code", "frames", "tracking", "volume", "mesh", "holes",
                                                  "fit", "finish", "config"))

    def test_a_cancelled_scan_is_the_mesh_of_what_was_fused(self):
        def stop_after_two(what, done, total):
            return not (what == "fusing" and done >= 2)

        scan = self.scan("some.ply", progress=stop_after_two)
        self.assertLess(scan["frames"]["fused"], 6)
        self.assertGreater(scan["triangles"], 100)
        self.assertEqual(scan["report"]["exit_code"], 130)
        codes = {warning.code: warning.text for warning in scan["warnings"]}
        self.assertIn("interrupted", codes["stopped_early"])

    def test_chosen_frames_have_the_bytes_of_scanknit_run(self):
        scan = self.scan("some.ply", first=1, last=5, every=2, save_volume=self.path("some.vdb"),
                         trajectory=self.path("some.txt"))
        self.run_program("run", self.recording, "--set", SETTINGS[0], "--from", "1", "--to", "5", "--every", "2", "-o",
                         self.path("run.ply"), "--trajectory", self.path("run.txt"))
        self.assertEqual([number for number, _ in scan["poses"]], [1, 3, 5])
        self.assertEqual(scan["files"]["volume"], self.path("some.vdb"))
        self.same_file(self.path("some.ply"), self.path("run.ply"))
        self.same_file(self.path("some.txt"), self.path("run.txt"))

    def test_angles_of_a_turntable_reach_the_scan(self):
        self.refused("config", self.scan, "none.ply", presets=["turntable"], angles=self.path("no_angles.txt"))

    def test_what_a_callback_raises_comes_out_of_the_scan(self):
        def raise_it(*arguments):
            raise KeyError("mine")

        for name in ("progress", "frame", "command"):
            with self.assertRaises(KeyError):
                self.scan("none.ply", **{name: raise_it})
        with self.assertRaises(KeyError):
            self.scan("none.ply", command=lambda: "pause", answer=raise_it)

    def test_errors_of_a_scan_have_a_code(self):
        self.refused("input", scanknit.scan, self.path("nothing"), self.path("out"))
        self.refused("config", scanknit.scan, self.recording, self.path("out"), settings=["a.b=1"])
        self.refused("usage", scanknit.scan, self.recording, self.path("out.fbx"))

    def test_arguments_that_cannot_be(self):
        for kind, text, keywords in ((TypeError, "unexpected keyword argument 'voxel'", {"voxel": 1}),
                                     (TypeError, "every: cannot be 'x'", {"every": "x"}),
                                     (ValueError, "every: expected 1 to", {"every": 0}),
                                     (TypeError, "progress: cannot be 5", {"progress": 5}),
                                     (TypeError, "presets: cannot be 'room'", {"presets": "room"}),
                                     (ValueError, "command: expected None, 'start'", {"command": lambda: "stop"}),
                                     (ValueError, "command: expected None, 'start'", {"command": lambda: "crop"}),
                                     (TypeError, "command: a box", {"command": lambda: ("crop", 1)}),
                                     (ValueError, "command: of a box", {"command": lambda: ("crop", ((0, 0, 0), (1, 0, 1)))})):
            with self.assertRaisesRegex(kind, text):
                scanknit.scan(self.recording, self.path("none.ply"), **keywords)


class Commands(WithScans):
    """What a scan of six frames does when it is told so."""

    def scan(self, commands, **keywords):
        """Command `commands[n]` is given when n frames were seen."""
        mesh = self.path("commanded.ply")
        if os.path.exists(mesh):
            os.remove(mesh)
        self.events = []
        waiting = dict(commands)

        def frame(number, pose):
            self.events.append(number)
            np.testing.assert_allclose(pose[3], (0, 0, 0, 1))

        def command():
            return waiting.pop(len([event for event in self.events if isinstance(event, int)]), None)

        def answer(command, error):
            self.events.append(command if error is None else (command, error.code))

        return scanknit.scan(self.recording, mesh, settings=SETTINGS, frame=frame, command=command, answer=answer, **keywords)

    def test_finish_ends_the_frames(self):
        scan = self.scan({2: "finish"})
        self.assertEqual(self.events, [0, 1, "finish"])
        self.assertEqual(scan["frames"]["fused"], 2)
        self.assertEqual(scan["report"]["exit_code"], 0)

    def test_a_paused_scan_waits_for_start(self):
        asked = []

        def command():
            asked.append(time.monotonic())
            return {2: "pause", 5: "start"}.get(len(asked))

        scan = scanknit.scan(self.recording, self.path("paused.ply"), settings=SETTINGS, command=command)
        self.assertGreater(asked[4] - asked[1], 0.03, "it polls, but not without a pause")
        self.assertEqual(scan["frames"]["fused"], 6)
        self.run_program("run", self.recording, "--set", SETTINGS[0], "-o", self.path("run.ply"))
        self.same_file(self.path("paused.ply"), self.path("run.ply"))

    def test_a_command_that_is_always_the_same_does_not_hold_the_scan(self):
        scan = scanknit.scan(self.recording, self.path("started.ply"), settings=SETTINGS, command=lambda: "start")
        self.assertEqual(scan["frames"]["fused"], 6)

    def test_export_writes_the_mesh_so_far(self):
        sizes = []
        mesh = self.path("commanded.ply")
        self.scan({3: "export"}, progress=lambda *_: sizes.append(os.path.getsize(mesh) if os.path.exists(mesh) else 0))
        self.assertEqual(self.events, [0, 1, 2, "export", 3, 4, 5])
        self.assertEqual(sizes[0], 0)
        self.assertGreater(sizes[-1], 1000)
        self.assertGreater(os.path.getsize(mesh), sizes[-1])

    def test_reset_begins_anew(self):
        scan = self.scan({4: "reset"})
        self.assertEqual([number for number, _ in scan["poses"]], [4, 5])
        self.assertIn("reset", [warning.code for warning in scan["warnings"]])

    def test_crop_leaves_a_box_and_none_the_whole(self):
        whole = self.scan({})["triangles"]
        box = ((-0.2, -0.2, -10), (0.2, 0.2, 10))
        self.assertLess(self.scan({1: ("crop", box)})["triangles"], whole)
        self.assertEqual(self.scan({1: ("crop", np.array(box)), 2: ("crop", None)})["triangles"], whole)

    def test_a_command_that_fails_is_answered_with_an_error(self):
        self.scan({1: ("crop", ((90, 90, 90), (91, 91, 91))), 2: "export", 3: ("crop", None)})
        self.assertEqual(self.events, [0, "crop", 1, ("export", "mesh"), 2, "crop", 3, 4, 5])


CAPTURE = """
import json, sys
import scanknit

numbers, answers, warnings = [], [], []
scan = scanknit.capture(sys.argv[1], device="openni2:", settings=["fusion.voxel_size=8mm"], recording=json.loads(sys.argv[2]),
                        frame=lambda number, pose: numbers.append(number), warning=lambda warning: warnings.append(str(warning)),
                        command=lambda: "finish" if len(numbers) >= 8 else None,
                        answer=lambda command, error: answers.append([command, error]))
print(json.dumps({"frames": scan["frames"], "files": scan["files"], "numbers": numbers, "answers": answers,
                  "triangles": scan["triangles"], "exit_code": scan["report"]["exit_code"], "losses": scan["report"]["losses"]}))
"""


class Captures(WithScans):
    def test_a_scanner_that_is_absent_is_an_error_of_the_device(self):
        self.refused("device", scanknit.capture, self.path("none.ply"), device="usb:8086:0b07/no_such_serial")
        self.refused("usage", scanknit.capture, self.path("none.ply"), device="nowhere")
        self.assertFalse(os.path.exists(self.path("none.ply")))

    def test_arguments_that_cannot_be(self):
        for kind, text, keywords in ((ValueError, "frames, seconds", {"frames": 3, "seconds": 2}),
                                     (ValueError, "width: expected 16 to 8192, got 3", {"width": 3}),
                                     (ValueError, "fps: expected 1 to 1000, got nan", {"fps": float("nan")}),
                                     (TypeError, "frames: cannot be -1", {"frames": -1}),
                                     (ValueError, "seconds: expected", {"seconds": 0})):
            with self.assertRaisesRegex(kind, text):
                scanknit.capture(self.path("none.ply"), **keywords)
        self.refused("usage", scanknit.capture, self.path("none.ply"), recording="pictures.bag")
        self.refused("usage", scanknit.capture, self.path("none.ply"), settings=["acquire.poses=recording"])

    def capture(self, name, recording):
        folder = os.environ.get("SCANKNIT_EMULATED_CAMERA")
        if not folder:
            self.skipTest("SKIPPED: the emulated camera needs OpenNI2")
        done = subprocess.run([sys.executable, "-c", CAPTURE, self.path(name), json.dumps(recording)], text=True,
                              capture_output=True, env={**os.environ, "LD_LIBRARY_PATH": folder})
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_an_emulated_camera_becomes_a_mesh_and_a_recording(self):
        scan = self.capture("captured", True)
        self.assertGreaterEqual(len(scan["numbers"]), 8)
        self.assertEqual(scan["frames"]["fused"] + scan["frames"]["lost"], len(scan["numbers"]))
        self.assertEqual(scan["answers"], [["finish", None]])
        self.assertGreater(scan["triangles"], 1000)
        self.assertEqual(scan["exit_code"], 0)
        self.assertIsNotNone(scan["losses"])
        self.assertEqual(scan["files"]["recording"], os.path.join(self.path("captured"), "recording.mcap"))
        self.assertGreater(len(list(scanknit.Recording(scan["files"]["recording"]))), 7)

    def test_the_recording_of_a_capture_may_be_elsewhere_or_left_out(self):
        self.assertEqual(self.capture("one.ply", self.path("two.mcap"))["files"]["recording"], self.path("two.mcap"))
        self.assertNotIn("recording", self.capture("three.ply", False)["files"])
        self.assertFalse(os.path.exists(self.path("three.mcap")))


def write_hills(path, first, turn_degrees, moved):
    """A range grid of hills of which no two places are alike, from `first` on along x, in a frame of its own."""
    hills = np.random.default_rng(7).uniform((-0.02, -0.02, 0.006, -0.012), (0.24, 0.24, 0.02, 0.012), (60, 4))
    side = 101
    y, x = np.mgrid[0:side, 0:side] * 0.001
    x = x + first
    z = sum(height * np.exp(-((x - at_x) ** 2 + (y - at_y) ** 2) / (2 * width**2)) for at_x, at_y, width, height in hills)
    c, s = np.cos(np.radians(turn_degrees)), np.sin(np.radians(turn_degrees))
    points = np.stack([c * x - s * y, s * x + c * y, z], axis=-1).reshape(-1, 3) + moved
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ply\nformat ascii 1.0\nobj_info num_cols {side}\nobj_info num_rows {side}\n"
                   f"element vertex {side * side}\nproperty float x\nproperty float y\nproperty float z\n"
                   f"element range_grid {side * side}\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines("%.9g %.9g %.9g\n" % tuple(point) for point in points)
        file.writelines(f"1 {cell}\n" for cell in range(side * side))


class Alignments(WithScans):
    def setUp(self):
        self.inputs = [self.path("a.ply"), self.path("b.ply")]
        write_hills(self.inputs[0], 0, 0, (0, 0, 0))
        write_hills(self.inputs[1], 0.03, 20, (0.3, -0.1, 0.05))

    def test_two_range_scans_have_the_bytes_of_scanknit_align(self):
        out, points = self.path("aligned"), self.path("points.ply")
        seen = []
        scan = scanknit.align(self.inputs, out, points=points, settings=["finish.smooth=1"],
                              progress=lambda *step: seen.append(step))
        self.run_program("align", *self.inputs, "-o", self.path("align"), "--points", self.path("run_points.ply"),
                         "--set", "finish.smooth=1")
        self.same_files(("model.glb", "model.ply", "preview.png"), out, self.path("align"))
        self.same_file(points, self.path("run_points.ply"))
        self.same_report(scan, self.path("align"), ("status", "exit_code", "volume", "mesh", "config"))
        self.assertEqual([placed["is_placed"] for placed in scan["report"]["alignment"]["scans"]], [True, True])
        self.assertIn(("fusing", 2, 2), seen)

    def test_what_is_known_reaches_the_alignment(self):
        for name in ("initial", "markers"):
            self.refused("input", scanknit.align, self.inputs, self.path("none.ply"), **{name: self.path("no_file.txt")})
        self.refused("usage", scanknit.align, self.inputs, self.path("none.ply"), points=self.path("points.obj"))
        # A voxel size that was asked for is kept; else it is the spacing of the points.
        scan = scanknit.align(self.inputs, self.path("coarse.ply"), settings=["fusion.voxel_size=3mm"], refine=True)
        self.assertEqual(scan["report"]["volume"]["voxel_size_m"], 0.003)

    def test_errors_have_a_code(self):
        self.refused("input", scanknit.align, [self.path("nothing.ply")], self.path("none.ply"))
        self.refused("config", scanknit.align, self.inputs, self.path("none.ply"), settings=["export.texture=png"])
        self.refused("too_little", scanknit.align, self.inputs, self.path("none.ply"), progress=lambda *_: False)
        for inputs, kind in (([], ValueError), ("a.ply", TypeError)):
            with self.assertRaises(kind):
                scanknit.align(inputs, self.path("none.ply"))


class Extractions(WithScans):
    def setUp(self):
        self.raw = self.path("ball.raw")
        k, j, i = np.mgrid[0:20, 0:24, 0:28]
        ball = 200 - 12 * np.sqrt((i - 14) ** 2 + (j - 12) ** 2 + (k - 10) ** 2)
        ball.clip(0).astype(">u2").tofile(self.raw)
        self.options = {"dims": (28, 24, 20), "type": "uint16", "spacing_mm": (1, 1, 1.5), "byte_order": "big"}
        self.words = ("--dims", "28x24x20", "--type", "uint16", "--spacing", "1x1x1.5", "--byte-order", "big")

    def test_raw_samples_have_the_bytes_of_scanknit_extract(self):
        for name, isovalue, words in (("given", 100.5, ("--isovalue", "100.5")), ("auto", "auto", ("--auto-isovalue",))):
            ours, theirs = self.path(name), self.path("program_" + name)
            scan = scanknit.extract(self.raw, ours, isovalue=isovalue, **self.options)
            self.run_program("extract", self.raw, "-o", theirs, *words, *self.words)
            self.same_files(("model.glb", "model.ply", "preview.png"), ours, theirs)
            self.same_report(scan, theirs, ("status", "exit_code", "volume", "mesh", "holes", "config"))
            self.assertGreater(scan["triangles"], 500)
            self.assertEqual(scan["poses"], [])

    def test_a_volume_that_a_scan_saved_is_meshed_at_zero(self):
        scanknit.scan(self.recording, self.path("scan.ply"), settings=SETTINGS, save_volume=self.path("scan.vdb"))
        scan = scanknit.extract(self.path("scan.vdb"), self.path("extract.ply"))
        self.run_program("extract", self.path("scan.vdb"), "-o", self.path("program.ply"))
        self.same_file(self.path("extract.ply"), self.path("program.ply"))
        found = scan["report"]["extract"]
        self.assertEqual((found["isovalue"], found["isovalue_source"]), (0, "signed_distance"))

    def test_an_isovalue_may_be_a_setting(self):
        scanknit.extract(self.raw, self.path("one.ply"), settings=["extract.isovalue=80"], **self.options)
        scanknit.extract(self.raw, self.path("two.ply"), isovalue=80, **self.options)
        self.same_file(self.path("one.ply"), self.path("two.ply"))

    def test_errors_have_a_code(self):
        out = self.path("none.ply")
        self.refused("usage", scanknit.extract, self.raw, out, **self.options)  # no isovalue
        self.refused("mesh", scanknit.extract, self.raw, out, isovalue=5000, **self.options)
        self.refused("input", scanknit.extract, self.path("nothing.nrrd"), out, isovalue=1)
        self.refused("config", scanknit.extract, self.raw, out, isovalue=float("nan"), **self.options)
        for kind, text, keywords in ((ValueError, "isovalue: expected a number, 'auto'", {"isovalue": "high"}),
                                     (ValueError, "type: expected one of int8, uint8", {"type": "short"}),
                                     (ValueError, "byte_order", {"byte_order": "middle"}),
                                     (ValueError, "dims", {"dims": (0, 1, 1)}), (TypeError, "dims", {"dims": 3}),
                                     (ValueError, "spacing_mm", {"spacing_mm": -1}),
                                     (TypeError, "unexpected keyword argument 'save_volume'", {"save_volume": "a.vdb"})):
            with self.assertRaisesRegex(kind, text):
                scanknit.extract(self.raw, out, **keywords)


class Signatures(WithScans):
    """Python sees **keywords: the stubs and the docstrings say which, and the functions take these."""

    CALLS = {"scan": ("/nowhere", "/nowhere/out.ply"), "capture": ("/nowhere/out.ply",),
             "align": (["/nowhere"], "/nowhere/out.ply"), "extract": ("/nowhere", "/nowhere/out.ply")}

    @staticmethod
    def keywords_of(function):
        values = [ast.literal_eval(value) for value in function.args.kw_defaults]
        return dict(zip((argument.arg for argument in function.args.kwonlyargs), values))

    def test_stubs_docstrings_and_functions_agree(self):
        stubs = ast.parse((SOURCE / "python" / "scanknit" / "__init__.pyi").read_text())
        functions = {node.name: node for node in stubs.body if isinstance(node, ast.FunctionDef)}
        self.assertEqual(functions.keys(), self.CALLS.keys())
        for name, call in self.CALLS.items():
            documented = ast.parse("def " + getattr(scanknit, name).__doc__.split("\n\n")[0] + ": ...").body[0]
            keywords = self.keywords_of(functions[name])
            self.assertEqual(self.keywords_of(documented), keywords)
            keywords["settings"] = ["no.such=key"]  # with which each ends before any work
            self.refused("config", getattr(scanknit, name), *call, **keywords)
            self.refused("config", getattr(scanknit, name), *call, **{**dict.fromkeys(keywords), "settings": ["a=b"]})


if __name__ == "__main__":
    unittest.main()
