"""outputs.py finds outputs that have changed. SCANKNIT_PROGRAM names the program."""

import contextlib
import io
import os
import pathlib
import re
import sys
import tempfile
import unittest
import unittest.mock

import outputs
import recorder

REPORT = """{
  "version": "0.1.0",
  "status": "the mesh is empty: \\"nothing\\" [was] seen",
  "tracking": {"frames": [{"frame": 3, "state": "lost", "reason": "too fast"}, {"frame": 4, "reason": ""}]},
  "stages": {"read": {"total_ms": 0.0, "p95_ms": 0.0}, "write": {"total_ms": 12.5, "p95_ms": 1e-05}},
  "warnings": [
    "one ], \\"quoted\\"",
    "two"
  ],
  "drop_messages": [],
  "peak_rss_mib": 179.25
}"""


def run_outputs(*arguments):
    """Exit code and what was said."""
    said = io.StringIO()
    program = os.environ["SCANKNIT_PROGRAM"]
    with unittest.mock.patch.object(sys, "argv", ["outputs.py", program, *arguments]), contextlib.redirect_stdout(said):
        return outputs.main(), said.getvalue()


class Lists(unittest.TestCase):
    def test_a_wrong_hash_a_missing_line_and_one_too_many_are_found_and_named(self):
        with tempfile.TemporaryDirectory() as folder:
            lists = ["--suite", "formats", "--lists", folder]
            self.assertEqual(run_outputs(*lists, "--record", "bytes", "texts")[0], 0)
            listed = pathlib.Path(folder, "bytes.sha256")
            lines = listed.read_text(encoding="utf-8").splitlines()
            for number, line in enumerate(lines):
                if line.endswith("formats/all/model.glb"):
                    lines[number] = ("1" if line[0] == "0" else "0") + line[1:]
                elif line.endswith("formats/alone_ply/exit_code"):
                    lines[number] = "4" + line[1:]
            lines = [line for line in lines if not line.endswith("formats/unlit/unlit.glb")]
            listed.write_text("\n".join([*lines, "0  formats/gone/exit_code"]) + "\n", encoding="utf-8")
            exit_code, said = run_outputs(*lists)
        self.assertEqual(exit_code, 1, said)
        found = [line for line in said.splitlines() if line.startswith(("bytes:", "texts:"))]
        self.assertEqual(len(found), 4, said)
        self.assertRegex(found[0], "bytes: formats/all/model.glb: [0-9a-f]{64}, expected [0-9a-f]{64}")
        self.assertEqual(found[1], "bytes: formats/alone_ply/exit_code: 0, expected 4")
        self.assertEqual(found[2], "bytes: formats/gone/exit_code: listed, but no longer written")
        self.assertRegex(found[3], "bytes: formats/unlit/unlit.glb: written, but not listed")

    def test_every_suite_is_a_ctest(self):
        text = pathlib.Path(outputs.__file__).with_name("CMakeLists.txt").read_text(encoding="utf-8")
        named = re.search(r"set\(suites (.*?)\)", text, re.DOTALL)[1].split()
        self.assertEqual(named, [suite.__name__ for suite in outputs.suites.SUITES])

    def test_lists_of_another_system_are_not_compared_with(self):
        with tempfile.TemporaryDirectory() as folder:
            for group in outputs.GROUPS:
                pathlib.Path(folder, f"{group}.sha256").write_text("# system: other 1\n", encoding="utf-8")
            exit_code, said = run_outputs("--suite", "formats", "--lists", folder)
        self.assertEqual(exit_code, outputs.SKIPPED)
        self.assertIn("SKIPPED", said)


class Report(unittest.TestCase):
    def test_times_become_one_where_there_were_any(self):
        text = recorder.without_times(REPORT)
        self.assertIn('"read": {"total_ms": 0.0, "p95_ms": 0.0}, "write": {"total_ms": 1.0, "p95_ms": 1.0}', text)
        self.assertIn('"peak_rss_mib": 1.0', text)
        self.assertIn('"version": ""', text)

    def test_words_are_left_out_but_not_that_there_are_some(self):
        text = recorder.without_words(REPORT)
        self.assertIn('"status": "?"', text)
        self.assertIn('"state": "lost", "reason": "?"}, {"frame": 4, "reason": ""}', text)
        self.assertIn('"warnings": [\n    "?",\n    "?"\n  ],\n  "drop_messages": [],', text)

    def test_other_values_count(self):
        for old, new in (('"frame": 3', '"frame": 2'), ('"lost"', '"ok"'), ("  ", " "), ('"two"', '"two", "three"')):
            changed = REPORT.replace(old, new, 1)
            self.assertNotEqual(recorder.without_words(recorder.without_times(changed)),
                                recorder.without_words(recorder.without_times(REPORT)))


class Ways(unittest.TestCase):
    def test_threads_are_asked_of_commands_that_have_them(self):
        way = recorder.Way("3 threads", threads=3)
        self.assertEqual(way.arguments(["run", "in", "-o", "out"]), ["run", "in", "-o", "out", "--threads", "3"])
        for others in ([], ["config", "print"], ["run", "--help"], ["completion", "bash"], ["rum"]):
            self.assertEqual(way.arguments(others), others)
        self.assertEqual(recorder.Way().arguments(["run"]), ["run"])

    def test_every_suite_is_run_in_each_way(self):
        exit_code, said = run_outputs("--suite", "commands", "--threads", "1", "3")
        self.assertEqual(exit_code, 0, said)
        self.assertRegex(said, r"(?s)1 threads: commands: .*3 threads: commands: ")


class Files(unittest.TestCase):
    def test_of_a_volume_only_the_id_is_left_out(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "a.vdb")
            contents = []
            for changed in (0, 21, 56, 20, 57):  # the id is the bytes 22 to 57, counted from 1
                content = bytearray(100)
                content[changed] = 1 if changed else 0
                file.write_bytes(content)
                contents.append(recorder.content_of(file))
        self.assertEqual(contents[1], contents[0])
        self.assertEqual(contents[2], contents[0])
        self.assertNotEqual(contents[3], contents[0])
        self.assertNotEqual(contents[4], contents[0])

    def test_drawings_are_pictures_and_charts_without_words(self):
        chart = '<svg><path d="M0"/></svg>'
        first = recorder.Drawings(f'<p>One</p><img src="data:1" alt="a">{chart}').found
        self.assertEqual(first, recorder.Drawings(f'<p>Two</p><img alt="b" src="data:1">{chart}').found)
        self.assertNotEqual(first, recorder.Drawings(f'<img src="data:2">{chart}').found)


if __name__ == "__main__":
    unittest.main()
