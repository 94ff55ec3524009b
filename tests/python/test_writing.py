# SPDX-License-Identifier: Apache-2.0
import os
import tempfile
import unittest
import warnings

import numpy
import touchable
from common import globe, hill, png


def ramp(count, shape=(24, 32)):
    """Pictures of all kinds of codes."""
    size = shape[0] * shape[1]
    return [(numpy.arange(size) * 37 + k * 1000 & 0xFFFF).astype(numpy.uint16).reshape(shape) for k in range(count)]


class Writing(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.camera = touchable.Camera(32, 24, far_m=66)

    def path(self, name="out.mkv"):
        return os.path.join(self.folder, name)

    def read(self, name="out.mkv", role="depth"):
        with touchable.open(self.path(name)) as clip:
            return [getattr(frame, role).copy() for frame in clip]

    def test_ClipRoundTripsToBytes(self):
        with touchable.open(globe()) as clip:
            self.assertEqual(touchable.write(self.path(), clip, exact_colour=True), 12)
            with touchable.open(self.path()) as back:
                for frame, again in zip(clip, back):
                    for role in "depth", "haptic", "height":
                        self.assertEqual(getattr(frame, role).tobytes(), getattr(again, role).tobytes(), role)
                    self.assertEqual(frame.metres.tobytes(), again.metres.tobytes())

    def test_EveryFormatKeepsCodes(self):
        for name in "out.mkv", "out.mp4", "folder", "small.mkv":
            with self.subTest(name):
                written = touchable.write(self.path(name), iter(ramp(3)), camera=self.camera, small="small" in name)
                self.assertEqual(written, 3)
                self.assertTrue(numpy.array_equal(self.read(name), ramp(3)))
        self.assertTrue(numpy.array_equal(png(self.path("folder/depth_000001.png")), ramp(3)[1]))

    def test_SceneAsCameraIsTheScene(self):
        scene = touchable.Scene.from_camera(self.camera)
        touchable.write(self.path(), ramp(3), camera=scene, fps=25)
        self.assertTrue(numpy.array_equal(self.read(), ramp(3)))
        with touchable.open(self.path()) as clip:
            self.assertEqual((clip.scene.camera.far_m, clip.frames_per_second), (66, 25))

    def test_ReadsAllStrides(self):
        wide = numpy.arange(48 * 64, dtype=numpy.uint16).reshape(48, 64)
        for way, array in {
            "every second": wide[::2, ::2], "upside down": wide[24:][::-1, :32], "right to left": wide[:24, 63:31:-1],
            "columns first": numpy.asfortranarray(wide[:24, :32]), "a part": wide[5:29, 7:39],
            "swapped bytes": wide[:24, :32].astype(">u2"), "the same row": numpy.broadcast_to(wide[:1, :32], (24, 32)),
            "odd place": numpy.frombuffer(b"x" + wide[:24, :32].tobytes(), numpy.uint16, offset=1).reshape(24, 32),
        }.items():
            with self.subTest(way):
                touchable.write(self.path(), [array], camera=self.camera, overwrite=True)
                self.assertTrue(numpy.array_equal(self.read()[0], array))

    def test_FloatsRoundToCodes(self):
        metres = numpy.linspace(0.3, 5, 24 * 32).reshape(24, 32)
        metres[0, :6] = numpy.nan, numpy.inf, -1, 0, -numpy.inf, 70
        for kind in numpy.float64, numpy.float32, numpy.dtype(">f4"):
            with self.assertWarnsRegex(UserWarning, "^1 pixels have no surface"):
                touchable.write(self.path(), [metres.astype(kind)], camera=self.camera, overwrite=True)
            codes = self.read()[0]
            self.assertTrue((codes[0, :6] == 0).all())
            self.assertLessEqual(numpy.abs(codes[1:] * (66 / 65534) - metres[1:]).max(), 33.01 / 65534)

    def test_MetresRoundTripToCodes(self):
        """Guards the far plane: its depth as a float may lie beyond it, and is a surface all the same."""
        for far_m, metres_per_code in (0.6, 0.0001), (0.7, 0.001), (3.3, 0.001):
            camera = touchable.Camera(32, 24, far_m=far_m, metres_per_code=metres_per_code)
            last = round(far_m / metres_per_code)
            codes = (last - numpy.arange(24 * 32) % (last + 1)).astype(numpy.uint16).reshape(24, 32)
            with self.subTest(far_m=far_m):
                touchable.write(self.path(), [codes], camera=camera, overwrite=True)
                with touchable.open(self.path()) as clip:
                    metres = clip[0].metres
                self.assertEqual(numpy.isfinite(metres).sum(), numpy.count_nonzero(codes))
                touchable.write(self.path("back.mkv"), [metres], camera=camera, overwrite=True)
                self.assertTrue(numpy.array_equal(self.read("back.mkv")[0], codes))
                pushed = touchable.Surface(metres, camera).first_metres
                self.assertEqual(pushed.tobytes(), metres.tobytes())

    def test_MetresBeyondRangeAreHoles(self):
        for far_m, metres_per_code in (10, 0.0001), (10.0009, 0.001), (10, 0.001), (0.6, 0.0001):
            camera = touchable.Camera(32, 24, far_m=far_m, metres_per_code=metres_per_code)
            last = min(65535 * metres_per_code, far_m)
            metres = (last + numpy.linspace(-4.2, 2.3, 24 * 32) * metres_per_code).astype(numpy.float32).reshape(24, 32)
            with self.subTest(far_m=far_m, metres_per_code=metres_per_code):
                with self.assertWarnsRegex(UserWarning, "pixels have no surface") as written:
                    touchable.write(self.path(), [metres], camera=camera, overwrite=True)
                with touchable.open(self.path()) as clip:
                    valid = clip[0].valid
                self.assertTrue(valid[0, 0] and not valid[-1, -1])
                self.assertRegex(str(written.warning), f"^{(~valid).sum()} pixels")
                with self.assertWarnsRegex(UserWarning, f"^{(~valid).sum()} pixels"):
                    surface = touchable.Surface(metres, camera)
                self.assertEqual(numpy.isfinite(surface.first_metres).tolist(), valid.tolist())

    def test_ArraysReachTheirDepth(self):
        """Of floats and of codes, in each kind of sequence; the far plane is as `touchable info` finds it for files."""
        street = numpy.linspace(2, 80, 24 * 32).reshape(24, 32)
        plain = touchable.Camera(32, 24, metres_per_code=0.001)
        for frames in [street], ({"depth": street / 2}, street), numpy.stack([street, street + 1]):
            deepest = max(numpy.max(frame["depth"] if isinstance(frame, dict) else frame) for frame in frames)
            with self.assertWarnsRegex(UserWarning, f"reaches {deepest:.4g} m.*65535 codes of 0.001 m"):
                touchable.write(self.path(), frames, camera=plain, overwrite=True)
            with touchable.open(self.path()) as clip:
                self.assertAlmostEqual(clip.camera.far_m, deepest * 1.05, places=3)
                for frame, depth in zip(clip, frames):
                    depth = depth["depth"] if isinstance(depth, dict) else depth
                    self.assertTrue(frame.valid.all())
                    self.assertLess(numpy.abs(frame.metres - depth).max(), 0.00066)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            touchable.write(self.path(), [street / 2], camera=plain, overwrite=True)  # 65535 codes of 1 mm reach
            with touchable.open(self.path()) as clip:
                self.assertTrue(clip[0].valid.all())
                self.assertEqual(clip.camera.metres_per_code, 0.001)
            fine = touchable.Camera(32, 24, metres_per_code=1e-4)
            touchable.write(self.path(), [street / 13], camera=fine, overwrite=True)  # which reach 6.5535 m
            with touchable.open(self.path()) as clip:
                self.assertEqual((clip[0].valid.all(), clip.camera.metres_per_code), (True, 1e-4))
            codes = numpy.round(street * 500).astype(numpy.uint16)
            codes[0, :3] = 0, 65535, 65535  # none, and what cameras say of it
            touchable.write(self.path(), [codes], camera=plain, overwrite=True)
            with touchable.open(self.path()) as clip:
                self.assertEqual(numpy.count_nonzero(~clip[0].valid), 3)
                self.assertTrue(numpy.array_equal(clip[0].depth, codes))
            touchable.write(self.path(), [street / 100], camera=plain, overwrite=True)
            with touchable.open(self.path()) as clip:
                self.assertEqual(clip.camera.far_m, 10)
            for share, step_m in (1, 0.002), (0.01, 2e-5):  # unstated: 84 m / 65535, rounded up
                touchable.write(self.path(), [street * share], camera=touchable.Camera(32, 24), overwrite=True)
                with touchable.open(self.path()) as clip:
                    self.assertAlmostEqual(clip.camera.far_m, 84 * share, places=9)
                    self.assertEqual(clip.camera.metres_per_code, step_m)

    def test_OutliersDoNotSetRange(self):
        near = numpy.full((120, 160), 20.0)
        near[0, 0] = 50000  # one in 19200
        with self.assertWarnsRegex(UserWarning, "^1 pixels have no surface"):
            touchable.write(self.path(), [near], camera=touchable.Camera(160, 120))
        rendered = numpy.where(numpy.arange(160) < 150, 1e10, near[1])  # sky
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            touchable.write(self.path("sky.mkv"), [numpy.tile(rendered, (120, 1))], camera=touchable.Camera(160, 120))
        with touchable.open(self.path()) as stray, touchable.open(self.path("sky.mkv")) as sky:
            for clip in stray, sky:
                self.assertAlmostEqual(clip.camera.far_m, 21, places=3)
            self.assertEqual((sky[0].valid.sum(), stray[0].valid.sum()), (1200, 19199))

    def test_MostlyLostDepthIsRejected(self):
        street = numpy.linspace(2, 80, 24 * 32).reshape(24, 32)
        stated = touchable.Camera(32, 24, far_m=10)
        for frames, camera, words in (
                ([street * 1000], touchable.Camera(32, 24), "half of it is beyond.*depth / 1000.*millimetres.*far_m"),
                (iter([street * 1000]), touchable.Camera(32, 24), "frame 0: .*768 of its 768.*0 to 10 m.*millimetres.*far_m"),
                ([street], stated, "689 of its 768 depths.*0 to 10 m.*at 10.03 to 80.*far_m"),
                ((depth for depth in [street / 9, street]), touchable.Camera(32, 24), "frame 1: .*far_m")):
            with self.assertRaisesRegex(touchable.UsageError, words):
                touchable.write(self.path(), frames, camera=camera)
            self.assertEqual(os.listdir(self.folder), [])
        touchable.write(self.path(), [street * 1000], camera=touchable.Camera(32, 24, far_m=90000, metres_per_code=2))
        with touchable.open(self.path()) as clip:
            self.assertTrue(clip[0].valid.all())
        surface = touchable.Surface(camera=touchable.Camera(32, 24))
        surface.push(numpy.where(street < 10, street, 0), 0)
        with self.assertRaisesRegex(touchable.UsageError, "far_m"):
            surface.push(street, 1)
        self.assertEqual(surface.newest_ns, 0)
        surface.push(numpy.where(street < 10, street, numpy.nan), 1)

    def test_StreamWarnsOnce(self):
        metres = numpy.full((24, 32), 5.0)
        metres[0] = 12
        surface = touchable.Surface(camera=touchable.Camera(32, 24))
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            for time in range(3):
                surface.push(metres, time)
        self.assertEqual([str(one.message)[:32] for one in said], ["32 pixels have no surface: their"])
        self.assertEqual(said[0].filename, __file__)

    def test_AcceptsDictsAndTuples(self):
        colour = numpy.arange(24 * 32 * 3, dtype=numpy.uint8).reshape(24, 32, 3)
        depth = ramp(1)[0]
        touchable.write(self.path(), [{"depth": depth, "colour": colour, "haptic": colour[::-1]}], camera=self.camera,
                        exact_colour=True)
        self.assertTrue(numpy.array_equal(self.read(role="colour")[0], colour))
        self.assertTrue(numpy.array_equal(self.read(role="haptic")[0], colour[::-1]))
        touchable.write(self.path("tuple.mkv"), [(depth, colour)], camera=self.camera, exact_colour=True)
        self.assertTrue(numpy.array_equal(self.read("tuple.mkv", "colour")[0], colour))

    def test_ExceptionLeavesNoFile(self):
        def frames():
            yield ramp(1)[0]
            raise RuntimeError("the camera is gone")

        for name in "out.mkv", "out.mp4", "folder":
            with self.assertRaisesRegex(RuntimeError, "the camera is gone"):
                touchable.write(self.path(name), frames(), camera=self.camera)
        with self.assertRaisesRegex(touchable.UsageError, "frame 1.*33x24"):
            touchable.write(self.path(), [ramp(1)[0], ramp(1, (24, 33))[0]], camera=self.camera)
        self.assertEqual(os.listdir(self.folder), [])

    def test_OverwritesOnlyOnRequest(self):
        touchable.write(self.path(), ramp(1), camera=self.camera)
        with self.assertRaises(FileExistsError) as refused:
            touchable.write(self.path(), ramp(2), camera=self.camera)
        self.assertIsInstance(refused.exception, touchable.ExistingFileError)
        self.assertEqual(refused.exception.status, touchable.Status.EXISTS)
        self.assertEqual(len(self.read()), 1)
        touchable.write(self.path(), ramp(2), camera=self.camera, overwrite=True)
        self.assertEqual(len(self.read()), 2)

    def test_OverwritesOnlyClips(self):
        open(self.path("x.avi"), "w").close()
        touchable.write(self.path(), ramp(1), camera=self.camera)
        os.mkdir(self.path("others"))
        open(self.path("others/notes.txt"), "w").close()
        with touchable.open(self.path()) as clip:
            for name, words in ("x.avi", "NAME.mkv"), ("out.mkv", "clip that is open"), ("others", "holds other files"):
                with self.assertRaisesRegex(touchable.UsageError, words) as refused:
                    touchable.write(self.path(name), ramp(1), camera=self.camera)
                self.assertNotIsInstance(refused.exception, FileExistsError, name)
            self.assertEqual(len(clip), 1)

    def test_NoneIsNotAFrame(self):
        for wrong in [None], [ramp(1)[0], None, ramp(1)[0]], iter([ramp(1)[0], None]):
            with self.assertRaisesRegex(touchable.UsageError, "no depth"):
                touchable.write(self.path(), wrong, camera=self.camera)
            self.assertEqual(os.listdir(os.path.dirname(self.path())), [])

    def test_EachFrameHasOneTime(self):
        for times, frames, words in ([7], 3, "begins with 7"), ([7], 1, "begins with 7"), ([0], 3, "1 times.* 3 frames"), (
                [0, 10**7], 1, "2 times.* 1 frames"), ([0, 10**7], 3, "2 times.* 3 frames"), ([], 1, "times_ns"), (
                [[0], [1, 2]], 2, "times_ns: no array"), (numpy.zeros(0, int), 1, "0 times.* 1 frames|times is not 2"):
            with self.subTest(times=times, frames=frames), self.assertRaisesRegex(touchable.UsageError, words):
                touchable.write(self.path(), ramp(frames), camera=self.camera, times_ns=times)
            self.assertEqual(os.listdir(os.path.dirname(self.path())), [])
        self.assertEqual(touchable.write(self.path(), ramp(1), camera=self.camera, times_ns=[0]), 1)

    def test_RateAndTimesAreKept(self):
        touchable.write(self.path(), ramp(3), camera=self.camera, fps=12.5)
        times = [0, 10_000_000, 55_000_000]
        touchable.write(self.path("times.mkv"), ramp(3), camera=self.camera, times_ns=times)
        with touchable.open(self.path()) as even, touchable.open(self.path("times.mkv")) as uneven:
            self.assertEqual(even.scene.frames_per_second, 12.5)
            self.assertEqual([frame.time_ns for frame in uneven], times)
            self.assertEqual((even.has_own_times, uneven.has_own_times), (False, True))
            self.assertEqual((uneven.times_ns.tolist(), uneven.times_ns.dtype), (times, numpy.int64))
            self.assertEqual(even.times_ns.tolist(), [0, 80_000_000, 160_000_000])
            touchable.write(self.path("again.mkv"), uneven)
            with touchable.open(self.path("again.mkv")) as again:
                self.assertEqual([frame.time_ns for frame in again], times)
            with self.assertWarnsRegex(UserWarning, "times_ns"):
                touchable.write(self.path("lost.mkv"), list(uneven))
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                touchable.write(self.path("fast.mkv"), even)
                touchable.write(self.path("said.mkv"), uneven[:2], times_ns=times[:2])

    def test_CameraRoundTripsExactly(self):
        camera = touchable.Camera(32, 24, 31.7, 30.1, 15.25, 11.75, 0.00025, 7.5, 29.97, 432.1, 0.6, 0.5)
        touchable.write(self.path(), ramp(1), camera=camera)
        with touchable.open(self.path()) as clip:
            self.assertEqual(clip.camera, camera)
            self.assertEqual(touchable.Scene.from_text(clip.scene.text).text, clip.scene.text)

    def test_WrittenHillFeelsTheSame(self):
        depth, camera = hill()
        path = camera.points(numpy.linspace(5, 58, 200), 24.0, 0.48)
        touchable.write(self.path(), [depth], camera=camera)
        before = touchable.Surface(depth, touchable.Scene.from_camera(camera).with_filters([depth])).touch(path)
        self.assertEqual(touchable.touch(self.path(), path).force_hash, before.force_hash)
        self.assertTrue(before.touching.any())


if __name__ == "__main__":
    unittest.main()
