# SPDX-License-Identifier: Apache-2.0
import runpy
import sys
import tempfile
import types
import unittest
import unittest.mock

import numpy
import touchable
from common import globe, hill, recording, run, source


def noisy(count=20):
    """`count` pictures of a hill, with noise of a millimetre that is new in each, and its camera."""
    depth, camera = hill(96, 72)
    random = numpy.random.default_rng(5)
    return [(depth + random.normal(0, 1.5, depth.shape)).round().astype(numpy.uint16) for _ in range(count)], camera


def roughness(metres):
    return float(numpy.nanstd(numpy.diff(metres, axis=1)))


class Filtering(unittest.TestCase):
    """Depth as filters leave it is the program's own, and better than what was stored."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def same(self, a, b):
        numpy.testing.assert_array_equal(a, b)  # NaN equals NaN

    def noisy_clip(self):
        pictures, camera = noisy()
        path = self.folder + "/noisy.mkv"
        touchable.write(path, pictures, camera=camera)
        return path

    def test_FramesMatchTheProgram(self):
        for path in globe(), self.noisy_clip():
            out = self.folder + "/smooth"
            for form in ".mkv", "/", ".npy":
                run("convert", path, out + form, "--filtered", "--allow-lossy", "--overwrite")
            array = numpy.load(out + ".npy")
            with touchable.open(path) as clip, touchable.open(out + ".mkv") as smooth, touchable.open(out) as pictures:
                for frame, of_video, of_pictures, of_array in zip(clip, smooth, pictures, array, strict=True):
                    self.same(frame.filtered_metres, of_video.metres)
                    self.same(frame.filtered_metres, of_pictures.metres)
                    self.same(frame.filtered_metres, of_array)

    def test_JumpsStartEarlier(self):
        path, out = self.noisy_clip(), self.folder + "/part"
        run("convert", path, out + "/", "--filtered", "--from", "18")
        run("convert", path, out + ".exr", "--filtered", "--from", "18")
        with touchable.open(path) as clip, touchable.open(out) as part, touchable.open(out + ".exr") as floats:
            self.assertIn('"temporal": "on"', clip.touched_scene.text)
            self.assertTrue(numpy.isfinite(clip[0].filtered_metres).any())
            frame = clip[18]  # 2 to 17 are read and filtered before it
            self.same(frame.filtered_metres, part[0].metres)
            numpy.testing.assert_allclose(floats[0].metres, part[0].metres, atol=2e-4)
            late = clip[17]
        self.assertEqual(frame.normals.shape, (*frame.depth.shape, 3))
        with self.assertRaisesRegex(touchable.UsageError, "closed"):
            late.normals

    def test_ArraysHaveMeanRate(self):
        pictures, camera = noisy(4)
        touchable.write(self.folder + "/own.mkv", pictures, camera=camera, times_ns=[0, 30_000_000, 110_000_000, 150_000_000])
        self.assertIn("times   LOST", run("convert", self.folder + "/own.mkv", self.folder + "/own.npy"))
        with touchable.open(self.folder + "/own.mkv") as own, touchable.open(self.folder + "/own.npy") as array:
            self.assertAlmostEqual(array.frames_per_second, own.frames_per_second)

    def test_FilterIsClipsFilter(self):
        path = self.noisy_clip()
        with touchable.open(path) as clip:
            frames = list(clip)
            smooth = touchable.Filter(clip.scene, frames, error_bars=True)
            for frame in frames:
                self.same(smooth(frame.depth), frame.filtered_metres)
                self.same(smooth.normals, frame.normals)
                self.same(smooth.error_degrees, frame.error_degrees)
            smooth.restart()
            self.same(smooth(frames[0]), frames[0].filtered_metres)
            self.assertLess(roughness(frames[-1].filtered_metres), 0.5 * roughness(frames[-1].metres))

    def test_FloatsKeepTheirDirection(self):
        pictures, camera = noisy()
        metres = [picture.astype(numpy.float32) * 0.001 for picture in pictures]
        smooth = touchable.Filter(camera, metres)
        for picture in metres:
            left = smooth(picture)
        self.assertLess(roughness(left), 0.5 * roughness(metres[-1]))
        one = touchable.filtered(metres[0], camera)
        self.assertLess(roughness(one.metres), roughness(metres[0]))
        lengths = numpy.linalg.norm(one.normals, axis=-1)
        numpy.testing.assert_allclose(lengths[numpy.isfinite(lengths)], 1, atol=1e-5)
        self.assertGreater(float(numpy.nanmin(one.error_degrees)), 0)

    def test_RecordingsKeepHoles(self):
        with touchable.open(recording("stills/redwood5")) as clip:
            frame = clip[2]
            self.same(numpy.isnan(frame.filtered_metres), ~frame.valid)
            self.assertLess(roughness(frame.filtered_metres), roughness(frame.metres))

    def test_RosNodeFiltersTopic(self):
        """The example, with a stand-in for rclpy: pictures with rows that are longer, and the other byte order."""
        of = types.SimpleNamespace

        class Node:
            def __init__(self, name):
                self.takes, self.published = {}, []

            def create_publisher(self, kind, topic, qos):
                return of(publish=self.published.append)

            def create_subscription(self, kind, topic, take, qos):
                self.takes[topic] = take

        modules = {"rclpy": of(), "rclpy.node": of(Node=Node), "rclpy.qos": of(qos_profile_sensor_data=None),
                   "sensor_msgs": of(), "sensor_msgs.msg": of(CameraInfo=of, Image=of)}
        with unittest.mock.patch.dict(sys.modules, modules):
            node = runpy.run_path(str(source / "examples/python/ros2_filter.py"))["DepthFilter"]()
        pictures, camera = noisy(20)
        k = [camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1]
        node.takes["depth/camera_info"](of(width=96, height=72, k=k))
        for number, picture in enumerate(pictures):
            rows = numpy.pad(picture.astype(">u2").view(numpy.uint8), ((0, 0), (0, 6)))
            node.takes["depth/image"](of(header=of(stamp=of(sec=5, nanosec=number * 33_000_000)), encoding="16UC1", width=96,
                                         height=72, is_bigendian=1, step=rows.shape[1], data=rows.tobytes()))
        smooth = touchable.Filter(camera, pictures[:16])
        self.assertEqual(len(node.published), 5)
        for message, picture in zip(node.published, pictures[15:], strict=True):
            self.same(numpy.frombuffer(message.data, numpy.float32).reshape(72, 96), smooth(picture))

    def test_Refusals(self):
        pictures, camera = noisy(1)
        smooth = touchable.Filter(camera)
        for refused, words in ((lambda: smooth.normals, "no picture was filtered"), (lambda: smooth(pictures[0][:9]), "96x72"),
                               (lambda: touchable.Filter(None)(pictures[0]), "camera")):
            with self.assertRaisesRegex((touchable.UsageError, TypeError), words):
                refused()
        smooth(pictures[0])
        with self.assertRaisesRegex(touchable.UsageError, "error_bars"):
            smooth.error_degrees
