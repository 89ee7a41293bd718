"""A recording of a desk in a folder of its own, and the program beside the module."""

import os
import pathlib
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["SCANKNIT_PROGRAM"]
SOURCE = pathlib.Path(os.environ["SCANKNIT_SOURCE_DIR"])
VOXEL = 0.01


class WithARecording(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.recording = os.path.join(cls.folder.name, "recording")
        cls.run_program("synth", "desk", "--frames", "6", "--width", "160", "--height", "120", "--noise", "-o", cls.recording)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @staticmethod
    def run_program(*arguments):
        subprocess.run([PROGRAM, *arguments, "--quiet"], check=True)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def same_file(self, one, other):
        self.assertEqual(pathlib.Path(one).read_bytes(), pathlib.Path(other).read_bytes())
