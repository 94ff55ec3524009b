# SPDX-License-Identifier: Apache-2.0
import contextlib
import os
import pickle
import queue
import re
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest

import numpy
import touchable
from common import globe, hill, longest_s, source, stroke
from touchable import _library


class Refusals(unittest.TestCase):
    """Whatever cannot be gives an exception of the right kind, with one line that says what would be right."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.file = self.folder.name + "/x.mkv"  # which is never written

    def refuses(self, kind, words, called, *arguments, **options):
        with self.assertRaisesRegex(kind, words) as refused:
            called(*arguments, **options)
        self.assertNotIn("\n", str(refused.exception))
        return refused.exception

    def test_MissingFiles(self):
        problem = self.refuses(FileNotFoundError, "nowhere.bag", touchable.open, "/nowhere.bag")
        self.assertIsInstance(problem, touchable.Error)
        self.assertEqual(problem.status, touchable.Status.INPUT)
        self.assertEqual(problem.status.name, "INPUT")

    def test_ForeignFiles(self):
        with tempfile.NamedTemporaryFile(suffix=".mkv") as file:
            file.write(b"no clip at all" * 100)
            file.flush()
            problem = self.refuses(touchable.Error, re.escape(file.name), touchable.open, file.name)
            self.assertNotIsInstance(problem, FileNotFoundError)

    def test_SettingsOfClips(self):
        self.refuses(ValueError, "fov_degrees", touchable.open, globe(), fov_degrees=500)
        self.refuses(ValueError, "fx_px", touchable.open, globe(), fx_px=-5)
        self.refuses(ValueError, "metres_per_code.*finite", touchable.open, globe(), metres_per_code=float("nan"))
        self.refuses(touchable.UsageError, "fx_px is '5'; must be a finite number", touchable.open, globe(), fx_px="5")
        with touchable.open(globe()) as clip:
            for index in 1.5, 0.0, "0", None:
                self.refuses(touchable.UsageError, f"index is {index!r}.*whole", clip.read, index)
        bag = source / "tests/fuzz/seeds/bag/depth_plain.bag"
        self.refuses(touchable.Error, "kinekt", touchable.open, bag, preset="kinekt")
        self.refuses(touchable.Error, "scene_file", touchable.open, globe(), preset="tum")
        self.refuses(TypeError, "", touchable.open, None)
        self.refuses(TypeError, "", touchable.open, globe(), fov="wide")
        for words, known in {"depth_kind is 'x'": {"depth_kind": "x"}, "near_m.*1e-06 to": {"near_m": -1},
                             "near and far need each other": {"near_m": 1}, "channel is empty": {"channel": ""}}.items():
            self.refuses(touchable.Error, words, touchable.open, bag, **known)

    def test_Pictures(self):
        depth, camera = hill()
        for words, wrong in {
            "int64.*uint16": depth.astype(numpy.int64), "bool": depth > 5, r"shape \(\)": numpy.float32(3),
            r"shape \(3072,\).*\(height, width\)": depth.ravel(), "object": numpy.full((48, 64), None),
            "64x47|47": depth[:47], "8 bits; must be 16": depth.astype(numpy.uint8), "masked": numpy.ma.masked_array(depth),
            "2 channels|shape": numpy.zeros((48, 64, 2), numpy.uint16), "shape": depth[:0], "complex": depth.astype(complex),
            "<U": "depth.png", "no depth": {"depth": None}, "picture 'color'": {"depth": depth, "color": depth},
            "tuple of 5": (depth,) * 5, "no array": [[1, 2], [3]],
        }.items():
            with self.subTest(words):
                self.refuses(ValueError, words, touchable.Surface(camera=camera).push, wrong)
                with tempfile.TemporaryDirectory() as folder:
                    self.refuses(ValueError, words, touchable.write, folder + "/x.mkv", [wrong], camera=camera)
                    self.assertEqual(os.listdir(folder), [])
        self.refuses(ValueError, "colour", touchable.Surface(camera=camera).push, {"depth": depth, "colour": depth})
        self.refuses(ValueError, "haptic|stiffness", touchable.Surface, depth, camera, haptic=depth.astype(numpy.float32))

    def test_Meanings(self):
        depth, camera = hill()
        self.refuses(TypeError, "camera is NoneType.*Camera", touchable.Surface, depth)
        self.refuses(ValueError, "preset is given without a depth array", touchable.Surface, camera=camera, preset="tum")
        self.refuses(ValueError, "far_m is given without preset", touchable.Surface, depth, camera, far_m=3)
        self.refuses(ValueError, "kinekt.*realsense", touchable.Surface, depth, camera, preset="kinekt")
        self.refuses(ValueError, "sun stores values in another order", touchable.Scene.from_camera, camera, preset="sun")
        self.refuses(TypeError, "camera is dict", touchable.Surface, depth, {"fx": 3})
        self.refuses(ValueError, "camera=touchable.Camera", touchable.write, self.file, [depth])
        self.refuses(ValueError, "one of them", touchable.write, self.file, [depth], camera=camera,
                     scene=touchable.Scene.from_camera(camera))
        self.refuses(ValueError, "no frames", touchable.write, self.file, [], camera=camera)
        self.refuses(ValueError, "x.avi.*mkv", touchable.write, self.folder.name + "/x.avi", [depth], camera=camera)
        self.refuses(ValueError, "times_ns", touchable.write, self.file, [depth] * 2, camera=camera, times_ns=[0, 0])
        self.refuses(ValueError, "nanoseconds", touchable.write, self.file, [depth] * 2, camera=camera, times_ns=[0, 0.5])

    def test_Cameras(self):
        for words, wrong in {"size|width": {"width": 0}, "far_m": {"far_m": -1}, "metres_per_code": {"metres_per_code": 0},
                             "fx_px is nan.*finite": {"fx_px": float("nan")}, "friction": {"dynamic_friction": 2},
                             "width is 64.5.*whole": {"width": 64.5}, "width is 4294967360": {"width": 2**32 + 64}, "frames_per_second": {"frames_per_second": 0}}.items():
            with self.subTest(words):
                self.refuses(ValueError, words, lambda: touchable.Scene.from_camera(touchable.Camera(**wrong)))
        self.refuses(ValueError, "planar.*range", touchable.Camera, depth_kind="round")
        self.refuses(ValueError, "fov_degrees", touchable.Camera.from_fov, 180)
        self.refuses(touchable.UsageError, "fov_degrees is 'wide'.*number", touchable.Camera.from_fov, "wide")
        self.refuses(touchable.UsageError, "width is 'a'; must be a whole number", touchable.Camera, "a", 24)
        self.refuses(touchable.UsageError, "width is 'a'.*whole", touchable.Camera.from_fov, 60, "a")
        scene = touchable.Scene.from_camera(touchable.Camera())
        for rate in float("nan"), float("inf"), "25", None:
            self.refuses(touchable.UsageError, f"frames_per_second is {rate!r}.*number", scene.with_rate, rate)
            if rate is not None:
                self.refuses(touchable.UsageError, "is .*number", touchable.write, self.file, [hill()[0]],
                             camera=hill()[1], fps=rate)
        self.refuses(touchable.Error, "depht", touchable.Scene.from_text, '{"touchable_scene": 1, "depht": 3}')

    def test_TextWithNul(self):
        depth, camera = hill()
        with tempfile.TemporaryDirectory() as folder:
            for wrong in folder + "/x.mkv\0y.mkv", folder + "/\ud800.mkv", folder.encode() + b"/x.mkv\0":
                self.refuses(touchable.UsageError, "the path .*NUL or a lone surrogate", touchable.write, wrong, [depth],
                             camera=camera)
                self.refuses(touchable.UsageError, "the path .*NUL or a lone surrogate", touchable.open, wrong)
            self.assertEqual(os.listdir(folder), [])
        for wrong in "\0", "\ud800":
            self.refuses(touchable.UsageError, "the path", touchable.open, globe() + wrong)
            self.refuses(touchable.UsageError, "scene_file has", touchable.open, globe(), scene_file=wrong)
            self.refuses(touchable.UsageError, "preset has", touchable.open, globe(), preset="tum" + wrong)
            self.refuses(touchable.UsageError, "the text", touchable.Scene.from_text, wrong)

    def test_NamesThatAreNone(self):
        depth, camera = hill()
        touched = touchable.Surface(depth, camera).touch(stroke(camera, 3))
        for called in (touchable.open, lambda path: touchable.touch(path, stroke(camera)),
                       lambda path: touchable.write(path, [depth], camera=camera), lambda path: touchable.plot(touched, path)):
            for empty in "", b"":
                self.refuses(touchable.UsageError, "^the path .* is empty; must be the name of a file", called, empty)
            for wrong in 5, float("nan"), ["a.mkv"]:
                self.refuses(TypeError, "^the path .* is (int|float|list); must be the name .*PathLike", called, wrong)
        for name in "scene_file", "preset":
            self.refuses(touchable.UsageError, f"^{name} is empty", touchable.open, globe(), **{name: ""})
            self.refuses(TypeError, f"^{name} is int; must be the name of a", touchable.open, globe(), **{name: 5})
        self.refuses(touchable.UsageError, "^the text of the scene is empty", touchable.Scene.from_text, "")
        self.refuses(TypeError, "^the text of the scene is NoneType", touchable.Scene.from_text, None)

    def test_ArgumentsOfAnotherType(self):
        depth, camera = hill()
        surface, scene = touchable.Surface(depth, camera), touchable.Scene.from_camera(camera)
        at = camera.points(32, 24, 0.48)
        for called, right in {
            lambda wrong: touchable.plot(wrong, self.folder.name + "/a.png"): "touched is .*a touchable.Touched",
            touchable.Solver: "surface is .*a touchable.Surface", touchable.Scene: "handle is .*use Scene.from_camera",
            touchable.Scene.from_camera: "camera is .*a touchable.Camera",
            lambda wrong: touchable.write(self.file, [depth], camera=wrong): "camera is .*a touchable.Camera or a touch",
            lambda wrong: touchable.write(self.file, [depth], scene=wrong): "scene is .*a touchable.Camera or a touch",
            lambda wrong: touchable.Frame(wrong, scene): "handle is .*touchable.open gives frames",
            lambda wrong: touchable.Clip(globe(), wrong): "settings is .*use touchable.open",
        }.items():
            for wrong in 5, "x", [depth], touchable.ForcesAt:
                self.refuses(TypeError, f"^{right}", called, wrong)
        self.refuses(TypeError, "touched is ForcesAt; must be", touchable.plot, surface.forces_at(at))
        for called in lambda wrong: touchable.write(self.file, wrong, camera=camera), scene.with_filters:
            self.refuses(TypeError, "'int' object is not iterable", called, 5)
        with touchable.open(globe()) as clip:
            for wrong in 1.0, "0", None:
                self.refuses(TypeError, "^index is .*; must be a whole number or a slice", lambda: clip[wrong])
        for wrong in 0, 257, 2.0, "1":
            self.refuses(touchable.UsageError, f"^fingers is {wrong!r}; must be (1 to 256|a whole)", touchable.Solver, surface,
                         wrong)

    def test_Flags(self):
        depth, camera = hill()
        surface, at = touchable.Surface(depth, camera), camera.points(32, 24, 0.48)
        write = lambda **flag: touchable.write(self.file, [depth], camera=camera, **flag)
        for name, called in {"colour": lambda **flag: touchable.open(globe(), **flag).close(),
                             "friction": lambda **flag: surface.forces_at(at, **flag), "small": write, "exact_colour": write,
                             "overwrite": write, "waits_to_be_free": lambda **flag: touchable.Solver(surface, **flag).close(),
                             }.items():
            for wrong in "yes", None, 0.5, float("nan"), []:
                self.refuses(TypeError, f"^{name} is .*; must be True or False", called, **{name: wrong})
            if called is not write:
                called(**{name: numpy.bool_(True)})

    def test_Paths(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        for shape in (3,), (5, 2), (5, 2, 4), (5, 0, 3), (1, 2, 3, 3):
            wrong = numpy.zeros(shape)
            self.refuses(ValueError, re.escape(str(wrong.shape)), surface.touch, wrong)
        for wrong in None, "path", [["a", "b", "c"]], [(1, 2), (3,)]:
            self.refuses(ValueError, "path", surface.touch, wrong)
        self.refuses(ValueError, "fingers", surface.touch, numpy.zeros((5, 300, 3)))
        self.assertEqual(surface.touch(numpy.zeros((0, 3))).force_n.shape, (0, 1, 3))
        self.assertTrue(numpy.isfinite(surface.touch(numpy.full((50, 3), numpy.inf)).force_n).all())

    def test_Settings(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        self.refuses(ValueError, "max_force|force", surface.touch, stroke(camera), max_force_n=-1)
        self.refuses(ValueError, "metres_per_scene_unit", surface.touch, stroke(camera), metres_per_scene_unit=0)
        self.refuses(ValueError, "number", surface.touch, stroke(camera), max_force_n="strong")
        self.refuses(touchable.UsageError, "no setting max_farce_n; must be.* max_force_n,", surface.touch, stroke(camera),
                     max_farce_n=3)
        for wrong in "1", None, float("nan"), 10**400, 1j:
            self.refuses(touchable.UsageError, "max_force_n is .*a finite number", touchable.Solver, surface, max_force_n=wrong)
            if wrong is not None:
                self.refuses(touchable.UsageError, "metres_per_scene_unit is .*a finite number", touchable.Solver, surface,
                             metres_per_scene_unit=wrong)
        self.refuses(ValueError, "threads", touchable.Surface, depth, camera, threads=0)

    def test_Ticks(self):
        depth, camera = hill()
        with touchable.Solver(touchable.Surface(depth, camera), 2) as solver:
            self.refuses(ValueError, r"\(3,\).*\(2, 3\)", solver.tick, (0, 0, 0))
            self.refuses(ValueError, "2", solver.run, stroke(camera))
            for wrong in [(1, 2), (3,)], "goals", [1j, 2, 3], [10**400, 0, 0], [numpy.ma.ones(3), (1, 2)]:
                self.refuses(touchable.UsageError, "goals.*no array of numbers", solver.tick, wrong)
            self.refuses(touchable.UsageError, "time_ns is 1.0.*whole", solver.tick, None, time_ns=1.0)
            solver.tick(None, tick=10)
            self.refuses(ValueError, "tick 10.*11", solver.tick, None, tick=10)
            self.assertEqual(solver.next_tick, 11)

    def test_NumbersBeyondCRange(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        with touchable.Solver(surface) as solver:
            for name in "tick", "time_ns", "epoch_start_ns":
                for far in 2**60 + 1, -(2**60) - 1, 2**64 + 5, 1.5:
                    with self.subTest(name, far=far):
                        self.refuses(touchable.UsageError, f"^{name} is {far}; must be", solver.tick, None, **{name: far})
                        self.refuses(touchable.UsageError, f"^{name} is {far}; must be", solver.run, numpy.zeros((1, 3)),
                                     **{name: far})
            self.refuses(ValueError, "epoch is -1", solver.tick, None, epoch=-1)
            for empty in {}, "", None:
                self.refuses(ValueError, f"epoch is {empty!r}; must be a whole number", solver.tick, None, epoch=empty)
            self.refuses(ValueError, "time_ns is 1100000000000000000000", solver.tick, None, tick=11 * 10**14)
            self.assertEqual(solver.next_tick, 0)
            solver.tick(None, tick=numpy.int64(5), time_ns=2**60)
            self.assertEqual(solver.next_tick, 6)
        cut = 2**32 + 1
        self.refuses(ValueError, f"fingers is {cut}", touchable.Solver, surface, cut)
        self.refuses(ValueError, f"ramp_in_ticks is {cut}", touchable.Solver, surface, ramp_in_ticks=cut)
        self.refuses(ValueError, f"stale_after_ns is {2**64}", touchable.Solver, surface, stale_after_ns=2**64)
        self.refuses(ValueError, f"threads is {cut}", touchable.Surface, depth, camera, threads=cut)
        self.refuses(ValueError, f"frames is {cut + 3}", touchable.Surface, depth, camera, frames=cut + 3)
        self.refuses(ValueError, f"time_ns is {2**64 + 9}", surface.push, depth, 2**64 + 9)
        self.refuses(ValueError, f"epoch is {2**64 + 1}", surface.begin_epoch, 2**64 + 1)
        with touchable.open(globe()) as clip:
            self.refuses(ValueError, f"index is {2**64}", clip.read, 2**64)
        self.refuses(ValueError, f"times_ns has {2**63 + 5}", touchable.write, self.file, [depth] * 2, camera=camera,
                     times_ns=numpy.array([0, 2**63 + 5], numpy.uint64))

    def test_ClosedObjects(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        solver = touchable.Solver(surface)
        busy = self.refuses(touchable.Error, "", surface.close)
        self.assertEqual(busy.status, touchable.Status.BUSY)
        self.assertEqual(self.refuses(touchable.Error, "solver", touchable.Solver, surface).status, touchable.Status.BUSY)
        solver.close()
        solver.close()
        self.assertTrue(solver.closed)
        for used in (lambda: solver.tick(None), lambda: solver.run(stroke(camera)), lambda: solver.force_hash,
                     solver.come_back):
            self.refuses(ValueError, "solver was closed", used)
        surface.close()
        surface.close()
        for used in (lambda: surface.push(depth), lambda: surface.touch(stroke(camera)), lambda: surface.newest_ns,
                     lambda: surface.hand_metres_per_scene_unit, surface.end_epoch):
            self.refuses(touchable.ClosedError, "surface was closed", used)
        clip = touchable.open(globe())
        clip.close()
        clip.close()
        for used in (lambda: clip[0], lambda: list(clip), lambda: clip.scene, lambda: clip.touch(stroke(camera))):
            self.assertEqual(self.refuses(ValueError, "clip.*was closed", used).status, touchable.Status.STALE)
        self.assertEqual(len(clip), 12)

    def test_BusySolverStaysOpen(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        path = numpy.tile(camera.points(32, 24, 0.48), (300_000, 1))
        busy, end = None, time.monotonic() + longest_s
        while busy is None and time.monotonic() < end:  # the run may be over before it is looked at
            solver = touchable.Solver(surface)
            thread = threading.Thread(target=solver.run, args=(path,))
            thread.start()
            try:
                while thread.is_alive():
                    solver.force_hash  # refused once the run has begun
            except touchable.Error:
                try:
                    solver.close()
                except touchable.Error as problem:
                    busy, stays_open = problem, not solver.closed
            thread.join()
            solver.close()
            self.assertTrue(solver.closed)
        self.assertIsNotNone(busy)
        self.assertTrue(stays_open)
        self.assertIn("close the solver after that", str(busy))
        self.assertEqual(busy.status, touchable.Status.BUSY)
        touchable.Solver(surface).close()
        surface.close()

    def test_LateOrTooManyPictures(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        self.refuses(ValueError, "later", surface.push, depth, 0)
        with touchable.Solver(surface) as solver:
            solver.tick(None)
            full = None
            for k in range(1, 9):
                try:
                    surface.push(depth, k * 10**9)
                except touchable.Error as problem:
                    full = problem.status
            self.assertEqual(full, touchable.Status.FULL)

    def test_ErrorsTravelBetweenProcesses(self):
        problem = self.refuses(touchable.Error, "", touchable.open, "/nowhere.bag")
        again = pickle.loads(pickle.dumps(problem))
        self.assertEqual((type(again), str(again), again.status), (type(problem), str(problem), problem.status))


class Words:
    """Lines that a process says, read by a thread, so that no wait for one lasts for ever."""

    def __init__(self, process):
        self._lines = queue.Queue()
        threading.Thread(target=self._read, args=(process.stdout,), daemon=True).start()

    def _read(self, out):
        for line in out:
            self._lines.put(line)
        self._lines.put("")

    def next(self, timeout_s=longest_s):
        """The next line; "" at the end. queue.Empty where none comes."""
        return self._lines.get(timeout=timeout_s)

    def skip_until_silent(self):
        with contextlib.suppress(queue.Empty):
            while self.next(timeout_s=1):
                pass


class CtrlC(unittest.TestCase):
    """At the end of a wait of a main thread, in a process of its own."""

    # A shell's background commands begin with SIGINT ignored.
    beginning = "import signal, touchable\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"

    def start(self, *command):
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process, Words(process)

    def interrupt(self, process):
        """Sends it SIGINT until it ends: one that comes while Python collects garbage is lost."""
        for _ in range(longest_s // 10):
            process.send_signal(signal.SIGINT)
            try:
                return process.wait(10)
            except subprocess.TimeoutExpired:
                pass
        self.fail(f"it has not ended in {longest_s} s")

    def test_EndsWaitForSilentStream(self):
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(longest_s)
            process, words = self.start(os.sys.executable, "-c", self.beginning + (
                "try:\n    touchable.open('tcp://127.0.0.1:%d')\n"
                "except KeyboardInterrupt:\n    print('ended', flush=True)" % server.getsockname()[1]))
            connection, _ = server.accept()
            with connection:
                self.interrupt(process)
                self.assertEqual(words.next(), "ended\n")

    def test_EndsWaitForFrame(self):
        stream, said = self.start(os.environ["TOUCHABLE_PROGRAM"], "serve", globe(), "tcp://127.0.0.1:0", "--loop")
        address = None
        while not address:
            line = said.next()
            self.assertTrue(line, "the program ended")
            address = re.search(r"tcp://127\.0\.0\.1:[1-9]\d*", line)
        process, words = self.start(os.sys.executable, "-c", self.beginning + (
            "from touchable import _library\ntry:\n    with touchable.open('%s') as clip:\n"
            "        for frame in clip: print(frame.depth.shape, flush=True)\n"
            "except KeyboardInterrupt:\n    print('ended', clip.closed, flush=True)\n"
            "print(_library.function('clip_describe')(clip._handle.number, _library.ClipFacts()))" % address[0]))
        self.assertEqual(words.next(), "(120, 160)\n")
        stream.send_signal(signal.SIGSTOP)  # from now on no frame comes
        words.skip_until_silent()
        self.interrupt(process)
        self.assertEqual(words.next(), "ended True\n")
        self.assertEqual(words.next(), f"{int(touchable.Status.STALE)}\n")  # the library has closed it


if __name__ == "__main__":
    unittest.main()
