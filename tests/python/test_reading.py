# SPDX-License-Identifier: Apache-2.0
import gc
import json
import os
import pathlib
import pickle
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import numpy
import touchable
from common import globe, made, png, recording, run, source
from touchable import _library


def status_of_frameset(number):
    return _library.function("frameset_frame")(number, _library.FrameStruct())


def compare_with_the_program(test, path, step=1):
    """Frames, of which it looks at every `step`th, have the codes that the program exports; and all keep theirs where they
    are written. Gives how many there are."""
    with tempfile.TemporaryDirectory() as folder, touchable.open(path) as clip:
        frames = list(clip)
        for k in range(0, len(frames), step):
            run("export", path, "--filters", "off", "--frame", k, "--out", f"{folder}/{k}")
            test.assertTrue(numpy.array_equal(frames[k].depth, png(f"{folder}/{k}/codes.png")), f"frame {k}")
        test.assertEqual(touchable.write(folder + "/back.mkv", clip), len(frames))
        with touchable.open(folder + "/back.mkv") as back:
            for frame, again in zip(frames, back, strict=True):
                test.assertEqual(frame.depth.tobytes(), again.depth.tobytes())
                test.assertEqual(frame.metres.tobytes(), again.metres.tobytes())
        return len(frames)


class Reading(unittest.TestCase):
    def test_CodesMatchProgramsFolder(self):
        with tempfile.TemporaryDirectory() as folder, touchable.open(globe()) as clip:
            run("convert", globe(), folder + "/pictures")
            self.assertEqual(len(clip), 12)
            for k, frame in enumerate(clip):
                self.assertEqual(frame.number, k)
                for role in "depth", "haptic", "height":
                    expected = png(f"{folder}/pictures/{role}_{k:06d}.png")
                    self.assertTrue(numpy.array_equal(getattr(frame, role), expected), role)

    def test_CodesAndMetresMatchExport(self):
        with tempfile.TemporaryDirectory() as folder, touchable.open(globe()) as clip:
            run("export", globe(), "--frame", "3", "--out", folder + "/3")
            frame = clip[3]
            self.assertTrue(numpy.array_equal(frame.depth, png(folder + "/3/codes.png")))
            self.assertTrue(numpy.array_equal(frame.valid, png(folder + "/3/valid.png") > 0))
            # Linear between two planes, 40 and 180 mm, the largest code at the near one.
            expected = (180 - frame.depth / 65535 * 140) * 1e-3
            self.assertLess(numpy.abs(frame.metres - expected).max(), 1e-7)
            self.assertEqual(frame.metres.dtype, numpy.float32)

    def test_OnlyMetricCodingHasStep(self):
        codings = {"linear": {"near": 0.5, "far": 4}, "inverse": {"near": 0.5, "far": 4}, "log": {"near": 0.5, "far": 4},
                   "hue": {"near": 0.5, "far": 4}, "metric": {"scale": 0.0005, "far": 4}}
        for coding, depth in codings.items():
            text = {"touchable_scene": 1, "width": 16, "height": 12, "metres_per_unit": 2.0,
                    "camera": {"fx": 20, "fy": 20, "cx": 8, "cy": 6}, "depth": {"coding": coding, **depth}}
            camera = touchable.Scene.from_text(json.dumps(text)).camera
            self.assertEqual(camera.metres_per_code, 0.001 if coding == "metric" else None, coding)
            self.assertEqual(camera.takes_codes, coding == "metric")
            self.assertEqual(camera.far_m, 8)
        with touchable.open(globe()) as clip:
            frame, camera = clip[0], clip.camera
            self.assertIsNone(camera.metres_per_code)
            scene = touchable.Scene.from_camera(camera)
            for again in scene, scene.with_filters([frame.metres]), scene.with_rate(5), pickle.loads(pickle.dumps(scene)):
                with self.assertRaisesRegex(touchable.UsageError, "takes_codes is False.*clip.scene"):
                    touchable.Surface(frame.depth, again)
            with tempfile.TemporaryDirectory() as folder:
                with self.assertRaisesRegex(touchable.UsageError, "takes_codes is False.*clip.scene"):
                    touchable.write(folder + "/x.mkv", [frame.depth], camera=camera)
            # For floats it is as good as any.
            metres = touchable.Surface(frame.metres, camera).first_metres
            self.assertTrue(numpy.array_equal(numpy.isfinite(metres), frame.valid))
            with tempfile.TemporaryDirectory() as folder:
                touchable.write(folder + "/x.mkv", [frame.metres], camera=camera)
                with touchable.open(folder + "/x.mkv") as back:
                    self.assertAlmostEqual(back.camera.metres_per_code, camera.far_m / 65534, places=12)
                    self.assertLess(numpy.nanmax(numpy.abs(back[0].metres - frame.metres)), camera.far_m / 65534)

    def test_ColourCanBeOmitted(self):
        with touchable.open(globe()) as clip, touchable.open(globe(), colour=False) as plain:
            self.assertEqual(clip[0].colour.shape, (120, 160, 3))
            self.assertGreater(clip[0].colour.std(), 10)
            self.assertIsNone(plain[0].colour)
            self.assertTrue(numpy.array_equal(plain[0].depth, clip[0].depth))

    def test_MissingPicturesAreNone(self):
        with touchable.open(made("plane", "--frames", "2", "--size", "64x48")) as clip:
            self.assertEqual((clip.has_haptic, clip.has_height), (False, False))
            self.assertIsNone(clip[0].haptic)
            self.assertIsNone(clip[0].height)

    def test_ArraysAreReadOnlyViews(self):
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

    def test_LastArrayReleasesFrameset(self):
        with touchable.open(globe()) as clip:
            frame = clip[0]
            number, array = frame._handle.number, frame.colour[5:]
            del frame
            gc.collect()
            self.assertEqual(status_of_frameset(number), touchable.Status.OK)
            del array
            gc.collect()
            self.assertEqual(status_of_frameset(number), touchable.Status.STALE)

    def test_ArraysLastUntilExit(self):
        program = ("import atexit\ndef look(): print(lies_over(number, _library.FrameStruct()), int(array.sum()))\n"
                   "atexit.register(look)\nimport touchable\nfrom touchable import _library\n"
                   "lies_over = _library.function('frameset_frame')\n"
                   f"frame = touchable.open({globe()!r})[0]\nnumber, array = frame._handle.number, frame.depth\n"
                   "print(0, int(array.sum()))")
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        while_it_runs, at_exit = done.stdout.splitlines()
        self.assertEqual(at_exit, while_it_runs, done.stderr)

    def test_LoopsAreIndependent(self):
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

    def test_TimesFollowRate(self):
        with touchable.open(globe()) as clip:
            self.assertEqual([frame.time_ns for frame in clip], [k * 10**9 // 30 for k in range(12)])
            self.assertAlmostEqual(clip[3].time_s, 0.1)
            self.assertFalse(clip.has_own_times)
            self.assertEqual(clip.times_ns.tolist(), [frame.time_ns for frame in clip])
        with self.assertRaisesRegex(touchable.ClosedError, "was closed"):
            clip.times_ns

    def test_RobotRecordingsRoundTrip(self):
        pictures = 0
        for kind in "bag", "mcap", "db3":
            found = sorted((source / "tests/fuzz/seeds" / kind).iterdir())
            self.assertTrue(found, kind)
            for path in found:
                with self.subTest(path.name):
                    pictures += compare_with_the_program(self, path)
        self.assertGreater(pictures, 12)

    def test_EveryClipRoundTrips(self):
        codecs = set()
        for path in sorted((source / "tests/fuzz/seeds/clip").glob("*.mkv")):
            with self.subTest(path.name):
                codecs.add(re.search(r"depth: (\w+)", run("info", path))[1])
                compare_with_the_program(self, path)
        self.assertEqual(codecs, {"t3dz", "t3d2"})

    def test_CameraSettingsApply(self):
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
            ramp = (numpy.arange(48 * 64, dtype=numpy.uint16) % 401 + 501).reshape(48, 64)
            touchable.write(folder + "/ramp", [ramp], camera=touchable.Camera(64, 48))
            os.remove(folder + "/ramp/scene.json")
            with touchable.open(folder + "/ramp") as clip:
                self.assertIn("metres_per_code=0.00390625", " ".join(clip.notes))
            numpy.savez(folder + "/two.npz", near=ramp, far=3 * ramp)
            for name, times in ("near", 1), ("far", 3):
                with touchable.open(folder + "/two.npz", dataset=name, metres_per_code=0.001, depth_kind="range") as clip:
                    self.assertLess(numpy.nanmax(numpy.abs(clip[0].metres - times * ramp * 0.001)), 1e-6)
                    self.assertEqual(clip.scene.depth_kind, "range")
            numpy.save(folder + "/relative.npy", ramp.astype(numpy.uint8))
            with touchable.open(folder + "/relative.npy", near_m=0.25, far_m=3) as clip:
                self.assertAlmostEqual(numpy.nanmin(clip[0].metres), 0.25)
                self.assertEqual(clip.scene.far_units, 3)


class RealReading(unittest.TestCase):
    def test_CastelMatchesItsPictures(self):
        castel = recording("castel_sr300")
        with touchable.open(castel, metres_per_code=0.000124986647) as clip:
            self.assertEqual(len(clip), 30)
            for k, frame in enumerate(clip):
                expected = png(castel / f"depth_{k:04d}.png")
                self.assertTrue(numpy.array_equal(frame.depth, expected))
                metres = numpy.where(frame.valid, expected * 0.000124986647, numpy.nan)
                self.assertLess(numpy.nanmax(numpy.abs(frame.metres - metres)), 1e-6)
        self.assertEqual(compare_with_the_program(self, castel, step=10), 30)

    def test_HueDepthGivesMetres(self):
        video = recording("depthkit_typing/Test.mov")
        with touchable.open(video, colour=False) as clip, tempfile.TemporaryDirectory() as folder:
            self.assertEqual((clip[0].depth.shape, clip[0].depth.dtype), ((424, 512, 3), numpy.uint8))
            self.assertTrue(0.52 < numpy.nanmin(clip[0].metres) < numpy.nanmax(clip[0].metres) < 1.26)
            touchable.write(folder + "/hue.mkv", clip[:3])
            with touchable.open(folder + "/hue.mkv") as back:
                for frame, again in zip(clip, back):
                    self.assertEqual(frame.depth.tobytes(), again.depth.tobytes())
                    self.assertEqual(frame.metres.tobytes(), again.metres.tobytes())


class MissingData(unittest.TestCase):
    """Tests that lack something."""

    def test_AllExistWithoutDebiansModules(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "matplotlib.py").write_text("raise ImportError")
            done = subprocess.run([source / "tests/python/run.sh", folder], capture_output=True, text=True,
                                  env={**os.environ, "PYTHONPATH": folder})
        self.assertEqual(done.returncode, 77, done.stderr)  # the SKIP_RETURN_CODE of CMakeLists.txt
        self.assertRegex(done.stdout, "has no matplotlib .*python3-matplotlib")

    def test_MissingRecordingSkipsOrFails(self):
        for environment, outcome in (({}, unittest.SkipTest), ({"TOUCHABLE_REQUIRE_DATA": "1"}, AssertionError), (
                {"TOUCHABLE_REQUIRE_DATA": "1", "TOUCHABLE_TEST_DATA": "/nothing-beside"}, unittest.SkipTest)):
            with unittest.mock.patch.dict(os.environ):
                for name in "TOUCHABLE_REQUIRE_DATA", "TOUCHABLE_TEST_DATA":
                    os.environ.pop(name, None)
                os.environ.update(environment)
                with self.assertRaisesRegex(outcome, "no real data at .*missing.bag"):
                    recording("missing.bag")


if __name__ == "__main__":
    unittest.main()
