# SPDX-License-Identifier: Apache-2.0
import contextlib
import copy
import gc
import os
import pathlib
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import numpy
import PIL.Image
import touchable
from common import globe, hill, longest_s, source, stroke
from touchable import _library


def in_child(work):
    """What `work` gives in a forked child, as text; of an exception its kind and line. Fails where the child hangs."""
    heard, said = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(longest_s)
        try:
            text = str(work())
        except BaseException as problem:
            text = f"{type(problem).__name__}: {problem}"
        os.write(said, text.encode())
        os._exit(0)
    os.close(said)
    with open(heard, "rb") as words:
        text = words.read().decode()
    status = os.waitpid(child, 0)[1]
    if status:
        raise AssertionError(f"the child ended with {status}")
    return text


class Forks(unittest.TestCase):
    """A forked child, such as multiprocessing's: it has the memory of its parent, but neither its threads nor its files."""

    def test_ChildCannotUseParentsObjects(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera, threads=2)
        with touchable.open(globe()) as clip, touchable.Solver(surface) as solver:
            clip[3]
            for what, used in {
                "clip": (lambda: clip[0], lambda: clip[7], lambda: list(clip), lambda: clip.touched_scene, clip.touch,
                         lambda: clip.times_ns),
                "surface": (lambda: surface.push(depth), lambda: touchable.Solver(surface), lambda: surface.newest_ns),
                "solver": (lambda: solver.tick(None), lambda: solver.run(stroke(camera)), lambda: solver.force_hash,
                           solver.come_back),
            }.items():
                for one in used:
                    if one == clip.touch:
                        one = lambda: clip.touch(stroke(camera))
                    self.assertRegex(in_child(one), f"^ClosedError: the {what} belongs to the parent process; open or make")
            self.assertEqual([frame.number for frame in clip], list(range(12)))
            self.assertEqual(solver.tick(None).tolist(), [[0, 0, 0]])

    def test_ChildLeavesParentsObjectsAlone(self):
        depth, camera = hill()
        held = {"clip": touchable.open(globe())}
        held["frame"] = held["clip"][2]
        held["array"] = held["clip"][3].depth
        held["surface"] = touchable.Surface(depth, camera, threads=2)
        held["solver"] = touchable.Solver(held["surface"])

        def close_all():
            for name in "solver", "surface", "clip":
                held[name].close()
            return held["clip"].closed

        def forget_all():
            held.clear()
            return gc.collect() >= 0

        self.assertEqual(in_child(close_all), "True")
        self.assertEqual(in_child(forget_all), "True")
        self.assertFalse(held["clip"].closed)
        self.assertEqual(held["clip"][5].number, 5)
        self.assertEqual(held["solver"].tick(None).shape, (1, 3))

    def test_ChildOpensForItself(self):
        with touchable.open(globe()) as clip:
            frame, scene = clip[2], clip.scene
            expected = frame.depth.sum(), numpy.nansum(scene.metres(frame.depth)), numpy.nansum(frame.metres)
            fresh = clip[2]  # whose metres were never read

            def work():
                with touchable.open(globe()) as own:
                    assert own[2].depth.tobytes() == frame.depth.tobytes()
                return frame.depth.sum(), numpy.nansum(scene.metres(frame.depth)), numpy.nansum(fresh.metres)

            self.assertEqual(in_child(work), str(expected))

    def test_ChildLeavesParentsClip(self):
        for then, status in ("sys.exit(0)", 0), ("pass", 1):  # the second one goes on writing, and is refused
            for name in "folder", "clip.mkv":
                with self.subTest(name, then=then), tempfile.TemporaryDirectory() as folder:
                    path = os.path.join(folder, name)
                    done = subprocess.run([sys.executable, "-c", (
                        "import os, sys, numpy, touchable\n"
                        "def frames():\n"
                        "    for k in range(6):\n"
                        "        if k == 3:\n"
                        "            child = os.fork()\n"
                        f"            if not child: {then}\n"
                        "            elif os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != %d:\n"
                        "                raise SystemExit('child')\n"
                        "        yield numpy.full((24, 32), 500 + k, numpy.uint16)\n"
                        "touchable.write(sys.argv[1], frames(), camera=touchable.Camera(32, 24))\n") % status, path],
                        capture_output=True, text=True, timeout=longest_s)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    if status:
                        self.assertRegex(done.stderr, "ClosedError: frame 3: the writer belongs to the parent process")
                    with touchable.open(path) as clip:
                        self.assertEqual([frame.depth[0, 0] for frame in clip], list(range(500, 506)))
                    self.assertEqual(os.listdir(folder), [name])


class Copies(unittest.TestCase):
    """By pickle, as multiprocessing sends arguments, and by copy."""

    def copies_of(self, thing):
        return pickle.loads(pickle.dumps(thing)), copy.copy(thing), copy.deepcopy(thing)

    def test_ScenesPickleByText(self):
        depth, camera = hill()
        for make in (lambda: touchable.Scene.from_camera(camera)), (lambda: touchable.open(globe()).scene):
            scene = make()
            text, facts = scene.text, {name: value for name, value in vars(scene).items() if name != "_handle"}
            del scene
            for copied in (lambda scene: pickle.loads(pickle.dumps(scene))), copy.copy, copy.deepcopy:
                again = copied(make())  # which ends now
                self.assertEqual(again.text, text)
                self.assertEqual({name: value for name, value in vars(again).items() if name != "_handle"}, facts)

    def test_TouchResultsPickleWhole(self):
        depth, camera = hill()
        touched = touchable.Surface(depth, camera).touch(stroke(camera))
        for again in self.copies_of(touched):
            self.assertEqual(again.force_n.tobytes(), touched.force_n.tobytes())
            self.assertEqual(again.surface_metres.tobytes(), touched.surface_metres.tobytes())
            self.assertEqual((again.force_hash, again.scene.text), (touched.force_hash, touched.scene.text))

    def test_ThreadsAndFilesNeverPickle(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        with touchable.open(globe()) as clip, touchable.Solver(surface) as solver:
            for thing in clip[0], surface, solver, surface._handle:
                for copied in pickle.dumps, copy.copy, copy.deepcopy:
                    with self.assertRaisesRegex(TypeError, f"{type(thing).__name__}.*pickled or copied; pass on"):
                        copied(thing)

    def test_ClipsPickleAsWhatTheyWereOpenedFrom(self):
        bag = source / "tests/fuzz/seeds/bag/depth_plain.bag"
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            shutil.copy(globe(), "clip.mkv")
            shutil.copy(bag, "clip.bag")
            os.mkdir("pictures")
            PIL.Image.fromarray(hill()[0]).save("pictures/depth_0.png")
            for path, options in (("clip.mkv", {"colour": False}), ("clip.bag", {"preset": "realsense"}),
                                  (pathlib.Path("pictures"), {"fov_degrees": 40, "metres_per_code": 0.0002}),
                                  (b"clip.mkv", {"scene_file": "scene.json"})):
                with self.subTest(path):
                    if "scene_file" in options:
                        with touchable.open(path) as clip:
                            pathlib.Path("scene.json").write_text(clip.scene.with_rate(7).text)
                    with touchable.open(path, **options) as clip:
                        clip[-1]
                        pickled = pickle.dumps(clip)
                        with contextlib.chdir("/"):
                            copies = [pickle.loads(pickled), copy.copy(clip), copy.deepcopy(clip)]
                            copies.append(pickle.loads(pickle.dumps(copies[0])))
                        for again in copies:
                            self.assertEqual(again.path, os.path.abspath(path))
                            self.assertEqual((again.scene.text, again.has_colour), (clip.scene.text, clip.has_colour))
                            self.assertEqual([frame.depth.tobytes() for frame in again],
                                             [frame.depth.tobytes() for frame in clip])
                            again.close()
                        self.assertFalse(clip.closed)
                    self.assertRaisesRegex(touchable.ClosedError, "clip.*was closed; open it again", pickle.dumps, clip)

    def test_PickledClipsMeetChangedFiles(self):
        with tempfile.TemporaryDirectory() as folder:
            path = folder + "/clip.mkv"
            shutil.copy(globe(), path)
            with touchable.open(path) as clip:
                pickled = pickle.dumps(clip)
            status = os.stat(path)
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns + 1))
            with self.assertRaisesRegex(touchable.Error, f"^{path}: has another size or time of change") as refused:
                pickle.loads(pickled)
            self.assertEqual(refused.exception.status, touchable.Status.INPUT)
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
            pickle.loads(pickled).close()
            os.remove(path)
            self.assertRaisesRegex(touchable.MissingFileError, path, pickle.loads, pickled)

    def test_StreamsNeverPickle(self):
        program = ("import copy, pickle, touchable\nclip = touchable.open('-')\n"
                   "for copied in pickle.dumps, copy.copy, copy.deepcopy:\n"
                   "    try: copied(clip)\n    except TypeError as problem: print(problem)")
        with open(globe(), "rb") as file:
            done = subprocess.run([sys.executable, "-c", program], stdin=file, capture_output=True, text=True, timeout=longest_s)
        self.assertEqual(done.stdout.count("a Clip holds memory"), 3, done.stderr)


class Interrupted(unittest.TestCase):
    def test_InterruptBeforeHandleLeaksNothing(self):
        surface = touchable.Surface(*hill())
        with unittest.mock.patch.object(_library, "Handle", side_effect=KeyboardInterrupt):
            self.assertRaises(KeyboardInterrupt, touchable.Solver, surface)
        touchable.Solver(surface).close()  # a surface has one at a time
        surface.close()

    def test_InterruptDuringReleaseLeaksNothing(self):
        ended = []

        def end(number):
            ended.append(number)
            if len(ended) == 1:
                raise KeyboardInterrupt

        with unittest.mock.patch.object(_library, "function", return_value=end), \
                unittest.mock.patch("sys.unraisablehook") as said:
            handle = _library.Handle(7, "surface_destroy")
            del handle
        self.assertEqual(ended, [7, 7])
        said.assert_called_once()


if __name__ == "__main__":
    unittest.main()
