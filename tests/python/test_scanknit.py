"""The Python module: arrays in, meshes out, the same bytes as the program's, and errors that say what is wrong."""

import ast
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import numpy as np
except ImportError:
    print("SKIPPED: python3-numpy is not installed")
    sys.exit(77)

import scanknit
from with_a_recording import SOURCE, VOXEL, WithARecording

# A sphere of 0.3 m, its centre 1 m before the camera: z-depth at each pixel, exactly.
RADIUS, DISTANCE = 0.3, 1.0
WIDTH, HEIGHT = 160, 120
INTRINSICS = (150.0, 150.0, 79.5, 59.5)


def sphere_depth():
    fx, fy, cx, cy = INTRINSICS
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    x, y = (u - cx) / fx, (v - cy) / fy
    a = x * x + y * y + 1
    discriminant = DISTANCE**2 - a * (DISTANCE**2 - RADIUS**2)
    hit = discriminant > 0
    z = (DISTANCE - np.sqrt(np.where(hit, discriminant, 0))) / a
    return np.where(hit, z, 0).astype(np.float32)


def sphere_volume(colour=None):
    volume = scanknit.Volume(VOXEL)
    volume.integrate(sphere_depth(), INTRINSICS, np.eye(4), colour)
    return volume


class Arrays(unittest.TestCase):
    def test_a_sphere_becomes_a_mesh_on_the_sphere(self):
        mesh = sphere_volume().extract()
        self.assertEqual(mesh.vertices.dtype, np.float32)
        self.assertEqual(mesh.triangles.dtype, np.uint32)
        self.assertEqual(mesh.vertices.shape, (len(mesh.vertices), 3))
        self.assertEqual(mesh.normals.shape, mesh.vertices.shape)
        self.assertGreater(len(mesh.triangles), 500)
        self.assertLess(mesh.triangles.max(), len(mesh.vertices))
        offset = np.linalg.norm(mesh.vertices - [0, 0, DISTANCE], axis=1) - RADIUS
        self.assertLess(np.abs(offset).mean(), 0.1 * VOXEL)
        outwards = (mesh.vertices - [0, 0, DISTANCE]) / RADIUS
        self.assertGreater((mesh.normals * outwards).sum(axis=1).mean(), 0.9)

    def test_triangles_run_counter_clockwise_seen_from_outside(self):
        mesh = sphere_volume().extract()
        a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        outwards = (a + b + c) / 3 - [0, 0, DISTANCE]
        self.assertGreater(((normal * outwards).sum(axis=1) > 0).mean(), 0.99)

    def test_colours_are_those_of_the_picture(self):
        colour = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        colour[:] = (200, 100, 50)
        mesh = sphere_volume(colour).extract()
        self.assertEqual(mesh.colours.dtype, np.uint8)
        self.assertEqual(mesh.colours.shape, mesh.vertices.shape)
        middle = mesh.colours[np.argmin(mesh.vertices[:, 2])]
        self.assertLessEqual(np.abs(middle.astype(int) - (200, 100, 50)).max(), 2)

    def test_depth_alone_gives_a_grey_mesh(self):
        colours = sphere_volume().extract().colours
        self.assertGreater(len(colours), 0)
        self.assertEqual(np.unique(colours).tolist(), [128])

    def test_raw_depth_strides_and_a_matrix_of_intrinsics_are_the_same(self):
        fx, fy, cx, cy = INTRINSICS
        raw = np.round(sphere_depth() * 5000).astype(np.uint16)
        metres = (raw.astype(np.float64) / 5000).astype(np.float32)
        wide = np.zeros((HEIGHT, 2 * WIDTH), np.float32)
        wide[:, ::2] = metres
        matrix = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]
        meshes = []
        for depth, intrinsics in ((metres, INTRINSICS), (raw, matrix), (wide[:, ::2], np.array(matrix))):
            volume = scanknit.Volume(VOXEL)
            volume.integrate(depth, intrinsics, np.eye(4), depth_scale=5000)
            meshes.append(volume.extract())
        for mesh in meshes[1:]:
            np.testing.assert_array_equal(mesh.vertices, meshes[0].vertices)
            np.testing.assert_array_equal(mesh.triangles, meshes[0].triangles)

    def test_nan_and_negative_depth_are_no_return(self):
        depth = sphere_depth()
        marked = depth.copy()
        marked[depth == 0] = np.nan
        marked[0, 0], marked[0, 1] = -1, np.inf
        volume = scanknit.Volume(VOXEL)
        volume.integrate(marked, INTRINSICS, np.eye(4))
        np.testing.assert_array_equal(volume.extract().vertices, sphere_volume().extract().vertices)

    def test_the_pose_is_camera_to_world(self):
        pose = np.eye(4)
        pose[:3, 3] = (10, 20, 30)
        volume = scanknit.Volume(VOXEL)
        volume.integrate(sphere_depth(), INTRINSICS, pose)
        centre = volume.extract().vertices.mean(axis=0)
        np.testing.assert_allclose(centre[:2], (10, 20), atol=VOXEL)
        self.assertTrue(30 + DISTANCE - RADIUS < centre[2] < 30 + DISTANCE)

    def test_an_isovalue_moves_the_surface(self):
        volume = sphere_volume()
        near = volume.extract(isovalue=VOXEL).vertices[:, 2].min()
        self.assertAlmostEqual(float(volume.extract().vertices[:, 2].min() - near), VOXEL, delta=VOXEL / 4)

    def test_arrays_outlive_their_mesh_and_cannot_be_written(self):
        vertices = sphere_volume().extract().vertices
        self.assertTrue(np.isfinite(vertices).all())
        with self.assertRaises(ValueError):
            vertices[0, 0] = 1


class Refusals(unittest.TestCase):
    def refused(self, kind, text, **changed):
        arguments = {"depth": sphere_depth(), "intrinsics": INTRINSICS, "pose": np.eye(4), **changed}
        volume = scanknit.Volume(VOXEL)
        with self.assertRaisesRegex(kind, text):
            volume.integrate(**arguments)
        self.assertEqual(volume.frames, 0)

    def test_wrong_shapes(self):
        self.refused(ValueError, r"depth: expected the shape \(height, width\), got \(4,\)", depth=np.ones(4, np.float32))
        self.refused(ValueError, "depth", depth=np.ones((0, 5), np.float32))
        self.refused(ValueError, r"pose: expected the shape \(4, 4\), got \(3, 4\)", pose=np.eye(4)[:3])
        self.refused(ValueError, "intrinsics: expected", intrinsics=(1.0, 2.0, 3.0))
        self.refused(ValueError, r"colour: expected the shape \(height, width, 3\)", colour=np.zeros((5, 5, 4), np.uint8))
        self.refused(ValueError, "colour_intrinsics: needed", colour=np.zeros((60, 80, 3), np.uint8))

    def test_wrong_kinds_of_number(self):
        self.refused(TypeError, r"depth: expected float32 \(metres\) or uint16, got float64", depth=np.ones((4, 4)))
        self.refused(TypeError, "depth: expected a NumPy array", depth=[[1.0]])
        self.refused(TypeError, "colour: expected uint8", colour=np.zeros((HEIGHT, WIDTH, 3), np.float32))
        self.refused(TypeError, "pose: expected a 4 x 4 matrix", pose="here")

    def test_poses_that_are_none(self):
        nan = np.eye(4)
        nan[0, 3] = np.nan
        self.refused(scanknit.Error, "pose: .*finite", pose=nan)
        self.refused(scanknit.Error, "pose: ", pose=np.diag([2.0, 2.0, 2.0, 1.0]))
        self.refused(scanknit.Error, "pose: ", pose=np.diag([1.0, 1.0, -1.0, 1.0]))

    def test_cameras_that_are_none(self):
        self.refused(ValueError, "intrinsics", intrinsics=(0.0, 150.0, 80.0, 60.0))
        self.refused(ValueError, "intrinsics", intrinsics=(np.nan, 150.0, 80.0, 60.0))
        self.refused(ValueError, "depth_scale", depth=np.ones((4, 4), np.uint16), depth_scale=0)

    def test_our_errors_have_a_code_and_our_message(self):
        with self.assertRaises(scanknit.Error) as caught:
            scanknit.Volume(-1.0)
        self.assertEqual(caught.exception.code, "config")
        with self.assertRaises(scanknit.Error) as caught:
            scanknit.Recording("/nowhere")
        self.assertEqual(caught.exception.code, "input")
        self.assertIn("/nowhere", str(caught.exception))

    def test_files_that_cannot_be_written(self):
        mesh = sphere_volume().extract()
        for path, code in (("/proc/nowhere/model.glb", "output"), ("model.fbx", "output")):
            with self.assertRaises(scanknit.Error) as caught:
                mesh.write(path)
            self.assertEqual(caught.exception.code, code)
        with self.assertRaises(scanknit.Error) as caught:
            scanknit.Volume(VOXEL).extract().write(os.path.join(tempfile.gettempdir(), "never.ply"))
        self.assertEqual(caught.exception.code, "mesh")
        with self.assertRaisesRegex(ValueError, "up: expected one of"):
            mesh.write("model.glb", up="north")


class Recordings(WithARecording):
    def test_the_mesh_has_the_bytes_of_scanknit_run(self):
        for extension in (".glb", ".ply"):
            self.run_program("run", self.recording, "--set", f"fusion.voxel_size={VOXEL}", "-o", self.path("run" + extension))
        example = SOURCE / "python" / "examples" / "mesh_a_recording.py"
        for extension in (".glb", ".ply"):
            out = self.path("python" + extension)
            done = subprocess.run([sys.executable, str(example), self.recording, out, "--voxel-size", str(VOXEL)],
                                  check=True, capture_output=True, text=True)
            self.assertIn("6 frames", done.stdout)
            self.same_file(out, self.path("run" + extension))

    def test_frames_are_arrays(self):
        recording = scanknit.Recording(self.recording)
        self.assertEqual(len(recording), 6)
        frames = list(recording)
        self.assertEqual(len(frames), 6)
        self.assertEqual(recording.dropped, 0)
        for frame in frames:
            self.assertEqual((frame.depth.shape, frame.depth.dtype), ((120, 160), np.float32))
            self.assertEqual((frame.colour.shape, frame.colour.dtype), ((120, 160, 3), np.uint8))
            np.testing.assert_allclose(frame.pose[:3, :3] @ frame.pose[:3, :3].T, np.eye(3), atol=1e-6)
            self.assertEqual(len(frame.intrinsics), 4)

    def test_other_threads_run_while_a_frame_is_fused(self):
        frame = next(scanknit.Recording(self.recording))
        volume = scanknit.Volume(0.002)
        gate, has_run = threading.Lock(), threading.Event()
        gate.acquire()

        def wait_and_run():
            with gate:
                has_run.set()

        other = threading.Thread(target=wait_and_run)
        other.start()
        interval = sys.getswitchinterval()
        sys.setswitchinterval(100)  # the other thread gets the interpreter only from a call that lets go of it
        gate.release()
        try:
            end = time.monotonic() + 30  # on a busy machine it may need several frames to wake up
            while not has_run.is_set() and time.monotonic() < end:
                volume.integrate(frame.depth, frame.intrinsics, frame.pose)
            ran = has_run.is_set()
        finally:
            sys.setswitchinterval(interval)
            other.join()
        self.assertTrue(ran)

    def test_two_threads_may_use_one_volume(self):
        frames = list(scanknit.Recording(self.recording))
        volume = scanknit.Volume(VOXEL)
        workers = [threading.Thread(target=lambda part=part: [
            volume.integrate(frame.depth, frame.intrinsics, frame.pose) for frame in part])
            for part in (frames[:3], frames[3:])]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertEqual(volume.frames, 6)
        self.assertGreater(len(volume.extract().triangles), 100)


class Documentation(unittest.TestCase):
    def test_the_stubs_name_what_the_module_has(self):
        import scanknit as module

        tree = ast.parse((SOURCE / "python" / "scanknit" / "__init__.pyi").read_text())
        for node in (n for n in tree.body if isinstance(n, ast.ClassDef)):
            stated = {m.name for m in node.body if isinstance(m, ast.FunctionDef)}
            there = {name for name in vars(getattr(module, node.name)) if not name.startswith("_")}
            public = {name for name in stated if not name.startswith("_")}
            if node.name != "Error":
                self.assertEqual(public, there, node.name)

    def test_everything_has_a_docstring(self):
        for kind in (scanknit.Volume, scanknit.Mesh, scanknit.Frame, scanknit.Recording):
            self.assertTrue(kind.__doc__)
        self.assertIn("(H, W) float32", scanknit.Volume.integrate.__doc__)
        self.assertIn("metres", scanknit.Mesh.vertices.__doc__)


if __name__ == "__main__":
    unittest.main()
