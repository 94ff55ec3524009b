import gc
import os
import pathlib
import tempfile
import unittest

import numpy
import touchable
from common import globe, made, png, recording, run, source
from touchable import _library


def status_of_frameset(number):
    return _library.function("frameset_frame")(number, _library.FrameStruct())


class Reading(unittest.TestCase):
    def test_CodesAreThoseOfTheFolderThatTheProgramWrites(self):
        with tempfile.TemporaryDirectory() as folder, touchable.open(globe()) as clip:
            run("convert", globe(), folder + "/pictures")
            self.assertEqual(len(clip), 12)
            for k, frame in enumerate(clip):
                self.assertEqual(frame.number, k)
                for role in "depth", "haptic", "height":
                    expected = png(f"{folder}/pictures/{role}_{k:06d}.png")
                    self.assertTrue(numpy.array_equal(getattr(frame, role), expected), role)

    def test_CodesAndMetresAreThoseOfExport(self):
        with tempfile.TemporaryDirectory() as folder, touchable.open(globe()) as clip:
            run("export", globe(), "--frame", "3", "--out", folder + "/3")
            frame = clip[3]
            self.assertTrue(numpy.array_equal(frame.depth, png(folder + "/3/codes.png")))
            self.assertTrue(numpy.array_equal(frame.valid, png(folder + "/3/valid.png") > 0))
            # Linear between two planes, 40 and 180 mm, the largest code at the near one.
            expected = (180 - frame.depth / 65535 * 140) * 1e-3
            self.assertLess(numpy.abs(frame.metres - expected).max(), 1e-7)
            self.assertEqual(frame.metres.dtype, numpy.float32)

    def test_ColourIsThereUnlessItIsLeftOut(self):
        with touchable.open(globe()) as clip, touchable.open(globe(), colour=False) as plain:
            self.assertEqual(clip[0].colour.shape, (120, 160, 3))
            self.assertGreater(clip[0].colour.std(), 10)
            self.assertIsNone(plain[0].colour)
            self.assertTrue(numpy.array_equal(plain[0].depth, clip[0].depth))

    def test_PicturesThatAreNotThereAreNone(self):
        with touchable.open(made("plane", "--frames", "2", "--size", "64x48")) as clip:
            self.assertEqual((clip.has_haptic, clip.has_height), (False, False))
            self.assertIsNone(clip[0].haptic)
            self.assertIsNone(clip[0].height)

    def test_NothingIsCopiedAndNobodyMayWrite(self):
        with touchable.open(globe()) as clip:
            frame = clip[0]
            self.assertEqual(frame.depth.ctypes.data, frame._struct.depth.data)
            self.assertEqual(frame.colour.strides[0], frame._struct.colour.stride_bytes)
            with self.assertRaises(ValueError):
                frame.depth[0, 0] = 1

    def test_ArraysOutliveFrameAndClip(self):
        clip = touchable.open(globe())
        expected = clip[5].depth.copy()
        part = clip[5].depth[10:60:2, ::-1]
        clip.close()
        del clip
        gc.collect()
        [numpy.ones((120, 160), numpy.uint16) for _ in range(100)]  # would take the memory, were it free
        self.assertTrue(numpy.array_equal(part, expected[10:60:2, ::-1]))

    def test_AFramesetIsReleasedWithItsLastArray(self):
        with touchable.open(globe()) as clip:
            frame = clip[0]
            number, array = frame._handle.number, frame.colour[5:]
            del frame
            gc.collect()
            self.assertEqual(status_of_frameset(number), touchable.Status.OK)
            del array
            gc.collect()
            self.assertEqual(status_of_frameset(number), touchable.Status.STALE)

    def test_EachLoopBeginsAnewAndSeveralGoSideBySide(self):
        with touchable.open(globe()) as clip:
            self.assertEqual([frame.number for frame in clip], list(range(12)))
            pairs = [(a.number, b.number) for a, b in zip(clip, iter(clip))]
            self.assertEqual(pairs, [(k, k) for k in range(12)])
            self.assertEqual(clip[-1].number, 11)
            self.assertEqual(clip[3].number, 3)
            self.assertEqual([frame.number for frame in clip[2:11:4]], [2, 6, 10])
            self.assertEqual(clip[numpy.int64(4)].number, 4)
            for beyond in 12, -13:
                with self.assertRaisesRegex(IndexError, "12"):
                    clip[beyond]

    def test_TimesAreThoseOfTheRate(self):
        with touchable.open(globe()) as clip:
            self.assertEqual([frame.time_ns for frame in clip], [k * 10**9 // 30 for k in range(12)])
            self.assertAlmostEqual(clip[3].time_s, 0.1)

    def test_RecordingsOfRobotsHaveTheirCodes(self):
        for name, pictures in {"bag/depth_plain.bag": 2, "bag/tum_bz2.bag": 4, "bag/realsense_lz4.bag": 3,
                               "mcap/zstd.mcap": 2, "db3/recording.db3": 2}.items():
            path = source / "tests/fuzz/seeds" / name
            with tempfile.TemporaryDirectory() as folder, self.subTest(name), touchable.open(path) as clip:
                run("convert", path, folder + "/pictures")
                expected = [png(picture) for picture in sorted(pathlib.Path(folder, "pictures").glob("depth*.png"))]
                self.assertEqual(len(expected), pictures)
                self.assertTrue(numpy.array_equal([frame.depth for frame in clip], expected))

    def test_WhatIsSaidOfTheCameraCounts(self):
        with tempfile.TemporaryDirectory() as folder:
            depth = numpy.full((48, 64), 700, numpy.uint16)
            touchable.write(folder + "/pictures", [depth], camera=touchable.Camera(64, 48))
            os.remove(folder + "/pictures/scene.json")
            with touchable.open(folder + "/pictures", fx_px=80, cx_px=30, cy_px=20, metres_per_code=0.0002) as clip:
                scene = clip.scene
                self.assertEqual((scene.fx_px, scene.fy_px, scene.cx_px, scene.cy_px), (80, 80, 30, 20))
                self.assertAlmostEqual(float(clip[0].metres[0, 0]), 0.14)
                self.assertAlmostEqual(clip.camera.metres_per_code, 0.0002)
            with touchable.open(folder + "/pictures", fov_degrees=90) as clip:
                self.assertAlmostEqual(clip.camera.fx_px, 32)
                self.assertIn("guessed", " ".join(clip.notes))


class RealReading(unittest.TestCase):
    def test_CastelHasTheCodesOfItsPictures(self):
        castel = recording("castel_sr300")
        with touchable.open(castel, metres_per_code=0.000124986647) as clip, tempfile.TemporaryDirectory() as folder:
            self.assertEqual(len(clip), 30)
            for k, frame in enumerate(clip):
                expected = png(castel / f"depth_{k:04d}.png")
                self.assertTrue(numpy.array_equal(frame.depth, expected))
                metres = numpy.where(frame.valid, expected * 0.000124986647, numpy.nan)
                self.assertLess(numpy.nanmax(numpy.abs(frame.metres - metres)), 1e-6)
            self.assertEqual(touchable.write(folder + "/castel.mkv", clip), 30)
            with touchable.open(folder + "/castel.mkv") as back:
                for frame, again in zip(clip, back):
                    self.assertEqual(frame.depth.tobytes(), again.depth.tobytes())
                    self.assertEqual(frame.metres.tobytes(), again.metres.tobytes())

    def test_DepthAsHueStaysColoursThatMeanMetres(self):
        video = recording("depthkit_typing/Test.mov")
        with touchable.open(video, colour=False) as clip, tempfile.TemporaryDirectory() as folder:
            self.assertEqual((clip[0].depth.shape, clip[0].depth.dtype), ((424, 512, 3), numpy.uint8))
            self.assertTrue(0.52 < numpy.nanmin(clip[0].metres) < numpy.nanmax(clip[0].metres) < 1.26)
            touchable.write(folder + "/hue.mkv", clip[:3])
            with touchable.open(folder + "/hue.mkv") as back:
                for frame, again in zip(clip, back):
                    self.assertEqual(frame.depth.tobytes(), again.depth.tobytes())
                    self.assertEqual(frame.metres.tobytes(), again.metres.tobytes())

    def test_ABagHasTheCodesOfTheProgram(self):
        bags = sorted(recording(".").rglob("*.bag"))
        if not bags:
            self.skipTest(f"no real data at {recording('.')}/*.bag")
        with touchable.open(bags[0], colour=False) as clip, tempfile.TemporaryDirectory() as folder:
            for k in 0, 5:
                run("export", bags[0], "--frame", k, "--out", f"{folder}/{k}")
                self.assertTrue(numpy.array_equal(clip[k].depth, png(f"{folder}/{k}/codes.png")))


if __name__ == "__main__":
    unittest.main()
