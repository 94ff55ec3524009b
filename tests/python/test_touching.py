# SPDX-License-Identifier: Apache-2.0
import concurrent.futures
import dataclasses
import gc
import itertools
import json
import os
import re
import tempfile
import threading
import unittest
import warnings
import weakref

import numpy
import touchable
from common import globe, hill, longest_s, made, recording, run, stroke
from touchable import _library


def hash_that_the_program_prints(*arguments):
    return re.search(r"force hash\s+([0-9a-f]{16})", run("touch", *arguments, "--verbose"))[1]


class ErrorBars(unittest.TestCase):
    def test_HoldOnNoisyBalls(self):
        """A ball bends everywhere: its bars are wide, but not by much."""
        camera = touchable.Camera(width=320, height=240, fx_px=285.0, fy_px=285.0, cx_px=159.5, cy_px=119.5,
                                  metres_per_code=0.001, far_m=6.0)
        columns, rows = numpy.meshgrid(numpy.arange(320.0), numpy.arange(240.0))
        rays = camera.points(columns, rows, numpy.ones_like(columns))
        noise = numpy.random.default_rng(3)
        for radius, distance in (0.15, 0.7), (0.4, 1.2), (1.0, 2.0):
            middle = numpy.array([0, 0, -distance])
            along, square = rays @ middle, (rays**2).sum(-1)
            under_root = along**2 - square * (distance**2 - radius**2)
            hit = under_root > 0
            depth = numpy.where(hit, (along - numpy.sqrt(numpy.where(hit, under_root, 0))) / square, distance + radius)
            film = [(1000 * depth + noise.normal(size=depth.shape) * depth**2 + 0.5).astype(numpy.uint16) for _ in range(16)]
            surface = touchable.Surface(camera=touchable.Scene.from_camera(camera).with_filters(film), frames=24, error_bars=True)
            for number, codes in enumerate(film):
                surface.push(codes, time_ns=number * 33_000_000)
            places = (rays * depth[..., None])[20:220:5, 20:300:5].reshape(-1, 3)
            normals = (places - middle) / radius
            facing = -(normals * places).sum(-1) / numpy.linalg.norm(places, axis=-1) > 0.35
            facing &= hit[20:220:5, 20:300:5].reshape(-1)
            places, normals = places[facing], normals[facing]
            scale = surface.scene.metres_per_scene_unit
            pressed = surface.forces_at((places - 0.004 * normals) / scale)
            force = pressed.force_n[pressed.touching]
            cosine = (force * normals[pressed.touching]).sum(-1) / numpy.linalg.norm(force, axis=-1)
            error = numpy.degrees(numpy.arccos(numpy.clip(cosine, -1, 1)))
            bar = pressed.error_degrees[pressed.touching]
            with self.subTest(radius=radius):
                self.assertGreater(len(error), 250)
                self.assertGreater((error <= bar).mean(), 0.92)
                self.assertLess(bar.mean(), 3 * numpy.quantile(error, 0.95))


class ProgramForces(unittest.TestCase):
    """The program touches with a hand of its own; its goals, from its file of forces, are touched here."""

    def compare(self, clip, *options):
        with tempfile.TemporaryDirectory() as folder:
            forces = os.path.join(folder, "forces.csv")
            expected = hash_that_the_program_prints(clip, *options, "--forces", forces)
            rows = numpy.genfromtxt(forces, delimiter=",", names=True)
            fingers = int(rows["finger"].max()) + 1
            column = lambda name: rows[name].reshape(-1, fingers)
            path = numpy.stack([column(f"goal_{axis}") for axis in "xyz"], -1)
            touched = touchable.touch(clip, path, error_bars=True)
            self.assertEqual(touched.force_hash, expected)
            self.assertEqual(touchable.touch(clip, path).force_hash, expected)
            for here in "error_degrees", "error_newtons":
                self.assertTrue(numpy.array_equal(getattr(touched, here), column(here), True), here)
                self.assertTrue(numpy.isnan(getattr(touchable.touch(clip, path[:300]), here)).all())
            self.assertTrue(numpy.isfinite(touched.error_degrees[touched.touching]).mean() > 0.5)
            for k, axis in enumerate("xyz"):
                self.assertTrue(numpy.array_equal(touched.force_n[..., k], column(f"force_{axis}")))
                self.assertTrue(numpy.array_equal(touched.proxy[..., k], column(f"proxy_{axis}")))
                self.assertTrue(numpy.array_equal(touched.goal[..., k], path[..., k]))
            self.assertTrue(numpy.array_equal(touched.pixel, numpy.stack([column("pixel_x"), column("pixel_y")], -1), True))
            self.assertTrue(numpy.array_equal(touched.touching, column("contact") == 1))
            for here, there in ("guard", "guard"), ("stiffness_n_per_m", "stiffness"), ("static_friction", "mu_static"), (
                    "dynamic_friction", "mu_dynamic"):
                self.assertTrue(numpy.array_equal(getattr(touched, here), column(there)), here)
            self.assertGreater(touched.touching.mean(), 0.2)
            if fingers == 1:
                again = hash_that_the_program_prints(
                    clip, "--hand", f"csv:{forces}:columns=goal_x+goal_y+goal_z,time=time_s,space=scene")
                self.assertEqual(again, expected)
            return expected

    def test_MatchOnClipsOfAllKinds(self):
        for clip, *options in (
                (globe(), "--seconds", "0.7"),  # longer than the clip
                (globe(), "--seconds", "0.6", "--fingers", "3", "--hand", "stroke"),
                (made("moving", "--frames", "60", "--rate", "240", "--size", "96x64"), "--seconds", "0.5"),
                (made("noise", "--frames", "10"), "--seconds", "0.5", "--hand", "press"),
                (made("bumps", "--frames", "1", "--size", "96x64"), "--seconds", "0.5")):
            with self.subTest(options=options):
                self.compare(clip, *options)


class RealForces(unittest.TestCase):
    def test_MatchProgramOnCastel(self):
        ProgramForces().compare(str(recording("castel_sr300")), "--seconds", "1.2")


class ForcesAt(unittest.TestCase):
    def test_WallPushesAlongNormal(self):
        camera = touchable.Camera(64, 48, fx_px=64, stiffness_n_per_m=400)
        surface = touchable.Surface(numpy.full((48, 64), 500, numpy.uint16), camera)
        x, y = numpy.meshgrid(numpy.arange(3, 61), numpy.arange(3, 45))  # all but the edge, which is soft
        for depth_m in 0.501, 0.52:
            points = camera.points(x, y, depth_m)
            found = surface.forces_at(points, metres_per_scene_unit=1)
            self.assertEqual(found.force_n.shape, (42, 58, 3))
            expected = [0, 0, 400 * (depth_m - 0.5)]
            self.assertLess(numpy.abs(found.force_n - expected).max(), 1e-9)
            self.assertTrue(found.touching.all() and found.steady.all() and (found.guard == 0).all())
            self.assertLess(numpy.abs(found.proxy - [0, 0, -0.5] - points * [1, 1, 0]).max(), 1e-12)
        free = surface.forces_at(camera.points(x, y, 0.49))
        self.assertTrue(free.steady.all() and not free.touching.any() and not free.force_n.any())
        none = surface.forces_at([[numpy.nan, 0, -1], [0, 0, -0.3]])
        self.assertEqual(none.steady.tolist(), [False, True])
        self.assertFalse(none.force_n.any())

    def test_PaintedFrictionCanBeOff(self):
        with touchable.open(globe()) as clip:
            points = clip.scene.points(70, 60, numpy.float64(clip[0].metres[60, 70]) + 0.004)
            surface = touchable.Surface(clip[0])
            smooth, rough = surface.forces_at(points), surface.forces_at(points, friction=True)
        self.assertEqual((smooth.static_friction, smooth.dynamic_friction), (0, 0))
        self.assertGreater(rough.static_friction, 0)
        self.assertEqual(smooth.force_n.shape, (3,))

    def test_UnsteadyForceIsReported(self):
        """Where a finger comes out of a soft hole stiffness rises by 0.04 N a tick: 20 N in 500."""
        random = numpy.random.default_rng(1)
        depth = random.integers(500, 520, (120, 160)).astype(numpy.uint16)
        depth[random.random(depth.shape) < 0.2] = 0
        camera = touchable.Camera(160, 120, fx_px=140)
        text = {**json.loads(touchable.Scene.from_camera(camera).text), "hole_stiffness": 0.05}
        scene = touchable.Scene.from_text(json.dumps(text))
        x, y = numpy.meshgrid(numpy.linspace(5, 150, 40), numpy.linspace(5, 110, 30))
        found = touchable.Surface(depth, scene).forces_at(camera.points(x, y, 0.8), friction=True, max_force_n=1000,
                                                          metres_per_scene_unit=1)
        self.assertTrue(found.steady.any() and not found.steady.all())
        unsteady = touchable.Guard.UNSTEADY | touchable.Guard.RISE
        self.assertTrue((found.guard[~found.steady] & unsteady == unsteady).all())

    def test_UsesNewestPicture(self):
        depth, camera = hill()
        surface = touchable.Surface(camera=camera)
        point = camera.points(32, 24, 0.5)
        with self.assertRaisesRegex(touchable.UsageError, "no picture was pushed"):
            surface.forces_at(point)
        surface.push(depth, 0)
        first = surface.forces_at(point).force_n[2]
        surface.push(depth - 10, 10**9)
        self.assertGreater(surface.forces_at(point, time_ns=500_000_000).force_n[2], first)
        newest = surface.forces_at(point).force_n[2]
        self.assertAlmostEqual(newest, first + 600 * 0.01 * surface.hand_metres_per_scene_unit, places=9)
        surface.begin_epoch(3)
        surface.push(depth, 0)
        surface.end_epoch()
        self.assertEqual(surface.forces_at(point).force_n[2], first)
        with self.assertRaisesRegex(touchable.UsageError, r"points have the shape \(2,\)"):
            surface.forces_at([1, 2])
        with self.assertRaisesRegex(touchable.UsageError, "no setting stiffness"):
            surface.forces_at(point, stiffness=3)
        with touchable.Solver(surface), self.assertRaisesRegex(touchable.Error, "has a solver already") as refused:
            surface.forces_at(point)
        self.assertEqual(refused.exception.status, touchable.Status.BUSY)
        self.assertEqual(surface.forces_at(numpy.zeros((0, 3))).force_n.shape, (0, 3))


class Surfaces(unittest.TestCase):
    def test_ForceIsStiffnessTimesDepth(self):
        depth = numpy.full((48, 64), 500, numpy.uint16)
        camera = touchable.Camera(64, 48, fx_px=64, stiffness_n_per_m=400)
        touched = touchable.Surface(depth, camera).touch(numpy.tile(camera.points(32, 24, 0.505), (200, 1)),
                                                         metres_per_scene_unit=1)
        self.assertAlmostEqual(touched.force_n[-1, 0, 2], 400 * 0.005, places=9)
        self.assertAlmostEqual(touched.proxy[-1, 0, 2], -0.5, places=12)
        self.assertEqual(touchable.Guard(int(touched.guard[0, 0])), touchable.Guard.RAMP)
        self.assertEqual(touched.guard[-1, 0], 0)
        self.assertEqual(touched.time_s[-1], 0.199)

    def test_BatchesEqualTicks(self):
        depth, camera = hill()
        path = numpy.stack([stroke(camera), stroke(camera, depth_m=0.49)], 1)
        whole = touchable.Surface(depth, camera).touch(path)
        self.assertEqual(whole.force_n.shape, (300, 2, 3))
        with touchable.Solver(touchable.Surface(depth, camera), 2) as solver:
            forces = [solver.tick(goals) for goals in path[:150]]
            rest = solver.run(path[150:])
            self.assertEqual(solver.force_hash, whole.force_hash)
        self.assertTrue(numpy.array_equal(numpy.concatenate([forces, rest.force_n]), whole.force_n))
        self.assertEqual(rest.time_s[0], 0.150)

    def test_GoesOnFromSavedState(self):
        depth, camera = hill()
        path = stroke(camera)
        with touchable.Solver(touchable.Surface(depth, camera)) as solver:
            with self.assertRaises(touchable.UsageError):
                solver.save()
            solver.run(path[:100])
            state, state_hash = solver.save(), solver.state_hash
            rest, force_hash = solver.run(path[100:]), solver.force_hash
        with touchable.Solver(touchable.Surface(depth, camera)) as other:
            other.load(state)
            self.assertEqual((other.next_tick, other.save(), other.state_hash), (100, state, state_hash))
            self.assertTrue(numpy.array_equal(other.run(path[100:]).force_n, rest.force_n))
            self.assertEqual(other.force_hash, force_hash)
            other.load(state)  # and back
            self.assertTrue(numpy.array_equal(other.run(path[100:]).force_n, rest.force_n))
            for wrong in (b"", state[:-1], state[:200] + bytes([state[200] ^ 1]) + state[201:]):
                with self.assertRaises(touchable.Error):
                    other.load(wrong)
            self.assertEqual(other.force_hash, force_hash)
        with touchable.Solver(touchable.Surface(depth + numpy.uint16(1), camera)) as elsewhere:
            with self.assertRaisesRegex(touchable.Error, "not those on which the moment was saved|another scene"):
                elsewhere.load(state)

    def test_MovingSurfaceMatchesClip(self):
        path = None
        with touchable.open(globe()) as clip:
            ticks = numpy.arange(300)
            depth_m = numpy.float64(clip[0].metres[60, 80]) + 0.001
            path = clip.scene.points(80 + 20 * numpy.sin(ticks / 50), 60 + 0 * ticks, depth_m + 0 * ticks)
            surface = touchable.Surface(camera=clip.touched_scene)
            self.assertIsNone(surface.newest_ns)
            coming, solver = iter(clip), None
            for tick in ticks:
                while (surface.newest_ns if surface.newest_ns is not None else -1) <= tick * 1_000_000:
                    surface.push(next(coming))
                solver = solver or touchable.Solver(surface)
                solver.tick(path[tick])
            self.assertEqual(solver.force_hash, clip.touch(path).force_hash)
            self.assertTrue(solver.contacts["touching"].any())

    def test_ArraySurfaceMatchesFrame(self):
        with touchable.open(globe()) as clip:
            frame = clip[0]
            path = clip.scene.points(numpy.linspace(60, 100, 200), numpy.full(200, 60.0),
                                     numpy.full(200, numpy.float64(frame.metres[60, 80]) + 0.002))
            of_frame = touchable.Surface(frame).touch(path)
            own = touchable.Surface(frame.depth.copy(), clip.scene, haptic=frame.haptic, height=frame.height)
            of_arrays = own.touch(path)
            without = touchable.Surface(frame.depth, clip.scene).touch(path)
        self.assertEqual(of_frame.force_hash, of_arrays.force_hash)
        self.assertNotEqual(of_frame.force_hash, without.force_hash)

    def test_MetresAndCodesFeelAlike(self):
        depth, camera = hill()
        depth[10:14, 20:30] = 0
        metres = numpy.where(depth > 0, depth * 0.001, numpy.nan)
        camera = dataclasses.replace(camera, metres_per_code=0.001)
        hashes = {touchable.Surface(given, camera).touch(stroke(camera)).force_hash
                  for given in (depth, metres, metres.astype(numpy.float32), depth[::-1][::-1], numpy.asfortranarray(depth))}
        self.assertEqual(len(hashes), 1)

    def test_MissingGoalRampsForceOut(self):
        depth, camera = hill()
        for missing in None, numpy.full(3, numpy.nan):
            with touchable.Solver(touchable.Surface(depth, camera)) as solver:
                inside = camera.points(32, 24, 0.48)
                before = [solver.tick(inside) for _ in range(200)][-1]
                after = [solver.tick(missing) for _ in range(101)]
                self.assertGreater(numpy.linalg.norm(before), 0.1)
                self.assertEqual(numpy.abs(after[-1]).max(), 0)
                self.assertTrue(numpy.isfinite(after).all())
                self.assertTrue(solver.contacts["guard"][0] & touchable.Guard.FAULT)

    def test_MaskedGoalIsMissing(self):
        depth, camera = hill()
        goals = stroke(camera)
        masked = numpy.ma.masked_array(goals, mask=numpy.zeros_like(goals, bool))
        masked[150:] = numpy.ma.masked
        missing = masked.filled(numpy.nan)
        surface = touchable.Surface(depth, camera)
        expected = surface.touch(missing)
        self.assertTrue(expected.force_n[149].any() and not expected.force_n[-1].any())
        for path in masked, list(masked):
            self.assertEqual(surface.touch(path).force_hash, expected.force_hash)
        for given in (lambda goal: goal), (lambda goal: [goal]):
            with touchable.Solver(surface) as solver:
                for goal in masked:
                    solver.tick(given(goal))
                self.assertEqual(solver.force_hash, expected.force_hash)
        points = camera.points(numpy.ma.masked_array([1, 2], mask=[False, True]), 3, 0.5)
        self.assertEqual(numpy.isnan(points[:, 0]).tolist(), [False, True])

    def test_SecondThreadIsRejected(self):
        depth, camera = hill()
        free, deep = numpy.tile(camera.points(32, 24, 0.4), (2, 1)), numpy.tile(camera.points(32, 24, 0.48), (2, 1))
        with touchable.Solver(touchable.Surface(depth, camera), 2, ramp_in_ticks=0) as solver, \
                concurrent.futures.ThreadPoolExecutor(1) as other:
            in_c = solver._run

            def while_the_other_comes(*arguments):
                for called, goals in (solver.tick, deep), (solver.run, deep[None]):
                    refused = other.submit(called, goals, tick=1000, time_ns=10**9).exception(longest_s)
                    self.assertIsInstance(refused, touchable.Error)
                    self.assertEqual(refused.status, touchable.Status.BUSY)
                return in_c(*arguments)

            solver._run = while_the_other_comes
            self.assertFalse(solver.tick(free).any())
            self.assertEqual((solver.next_tick, solver.contacts["goal"].tolist()), (1, free.tolist()))
            self.assertFalse(solver.run(free[None]).force_n.any())
            self.assertEqual(solver.next_tick, 2)
            solver._run = in_c
            self.assertTrue(other.submit(solver.tick, deep).result(longest_s).any())

    def test_ForceLimitHolds(self):
        depth, camera = hill()
        path = stroke(camera, depth_m=0.6)
        touched = touchable.Surface(depth, camera).touch(path, metres_per_scene_unit=1, max_force_n=1.5)
        longest = numpy.linalg.norm(touched.force_n, axis=-1).max()
        self.assertTrue(1.4 < longest <= 1.5 + 1e-12)
        self.assertTrue((touched.guard & touchable.Guard.FORCE).any())

    def test_EpochBeginsAnywhere(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        solver = touchable.Solver(surface)
        inside = camera.points(32, 24, 0.50)
        [solver.tick(inside) for _ in range(150)]
        surface.begin_epoch(1)
        surface.push(depth + numpy.uint16(100), 5_000_000_000)
        surface.end_epoch()
        for k in range(300):
            force = solver.tick(inside, time_ns=5_000_000_000 + k * 1_000_000, epoch=1, epoch_start_ns=5_000_000_000)
        self.assertEqual(numpy.abs(force).max(), 0)  # the surface of the other epoch is 100 mm deeper

    def test_PushesWhileTicking(self):
        depth, camera = hill()
        surface = touchable.Surface(depth, camera)
        faults, pushed = [], threading.Event()

        def push():
            for k in range(1, 60):
                while True:
                    try:
                        surface.push(depth + numpy.uint16(k % 3), k * 1_000_000)
                        break
                    except touchable.Error as problem:
                        if problem.status != touchable.Status.FULL:
                            faults.append(problem)
                            return
            pushed.set()

        thread = threading.Thread(target=push)
        with touchable.Solver(surface) as solver:
            thread.start()
            while thread.is_alive():
                force = solver.tick(camera.points(32, 24, 0.48))
                self.assertTrue(numpy.isfinite(force).all())
            thread.join()
        self.assertEqual(faults, [])
        self.assertTrue(pushed.is_set())
        self.assertEqual(surface.newest_ns, 59_000_000)

    def test_CyclesReleaseHandles(self):
        depth, camera = hill(16, 12)

        class Owner:
            pass

        for _ in range(1500):  # there is room for 1024 of each
            owner = Owner()
            owner.surface = touchable.Surface(depth, camera)
            owner.solver, owner.itself = touchable.Solver(owner.surface), owner
        self.assertEqual(owner.solver.tick((0, 0, 0)).shape, (1, 3))

    def test_ResultsKeepNoSurface(self):
        depth, camera = hill()
        metres = touchable.Scene.from_camera(camera).metres(depth)
        for given in depth, metres:
            surface = touchable.Surface(given, camera)
            touched, alive = surface.touch(stroke(camera)), weakref.ref(surface)
            del surface
            gc.collect()
            self.assertIsNone(alive())
            self.assertEqual(touched.surface_metres.tobytes(), metres.tobytes())
        early = touchable.Surface(camera=camera).touch(stroke(camera), metres_per_scene_unit=1)
        with self.assertRaisesRegex(touchable.UsageError, "no picture"):
            early.surface_metres


class OpenSteps(unittest.TestCase):
    """A wall that leans by 10 degrees, and a ball, half a metre away, in pixels of 1.7 mm."""

    camera = touchable.Camera(160, 120, fx_px=300)
    columns, rows = numpy.meshgrid(numpy.arange(160.0), numpy.arange(120.0))
    ray = camera.points(columns, rows, 1.0)
    lean = numpy.array([numpy.sin(numpy.radians(10)), 0, numpy.cos(numpy.radians(10))])
    wall = -0.5 * lean[2] / (ray @ lean)
    middle, radius = numpy.array([0, 0, -0.6]), 0.1
    under_root = (ray @ middle) ** 2 - (ray**2).sum(-1) * (middle @ middle - radius**2)
    ball = numpy.where(under_root > 0, (ray @ middle - numpy.sqrt(numpy.maximum(under_root, 0))) / (ray**2).sum(-1), 0)

    def error_degrees(self, surface, depth, normal_at):
        some = (slice(30, 90, 3), slice(50, 110, 3))
        found = surface.forces_at(self.camera.points(self.columns[some], self.rows[some], depth[some] + 0.005))
        cosine = (found.force_n * normal_at(found.proxy)).sum(-1) / numpy.linalg.norm(found.force_n, axis=-1)
        return numpy.degrees(numpy.arccos(numpy.minimum(cosine, 1))).mean()

    def test_FloatsKeepTheirDirection(self):
        for name, depth, normal_at in ("wall", self.wall, lambda at: self.lean), (
                "ball", self.ball, lambda at: (at - self.middle) / self.radius):
            coarse = dataclasses.replace(self.camera, metres_per_code=0.001)
            with self.subTest(name):
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    surface = touchable.Surface(depth, self.camera)
                    self.assertLess(self.error_degrees(surface, depth, normal_at), 0.9)
                with self.assertWarnsRegex(UserWarning, "turns the surface by .* degrees") as said:
                    surface = touchable.Surface(depth, coarse)
                error = self.error_degrees(surface, depth, normal_at)
                self.assertGreater(error, 5)
                self.assertAlmostEqual(float(re.search(r"by (\S+) deg", str(said.warning))[1]) / error, 1, delta=0.4)
                with tempfile.TemporaryDirectory() as folder:
                    with self.assertWarnsRegex(UserWarning, "turns the surface by"):
                        touchable.write(folder + "/coarse.mkv", [depth], camera=coarse)
                    touchable.write(folder + "/fine.mkv", [depth], camera=self.camera)
                    with touchable.open(folder + "/fine.mkv") as clip:
                        self.assertLess(self.error_degrees(touchable.Surface(clip[0]), depth, normal_at), 0.9)
                self.assertEqual(said.filename, __file__)

    def test_LaterPicturesMayBeDeeper(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            surface = touchable.Surface(self.wall, self.camera)
            self.assertLess(self.error_degrees(surface, self.wall, lambda at: self.lean), 0.4)
            for second, later in (1, 1.9 * self.wall), (2, (1900 * self.wall).astype(numpy.uint16)):  # millimetres
                surface.push(later, second * 10**9)
                found = surface.forces_at(self.camera.points(80, 60, 1.9 * self.wall[60, 80] + 0.005))
                self.assertAlmostEqual(found.proxy[2], -1.9 * self.wall[60, 80], delta=0.001, msg=second)
            narrow = touchable.Surface(self.wall, dataclasses.replace(self.camera, fx_px=1600, fy_px=1600))
            self.assertAlmostEqual(narrow.scene.far_units, 0.65534)  # no room: it would turn the wall by 2 degrees

    def test_FirstPictureGetsALine(self):
        noise = numpy.random.default_rng(1).normal(size=self.ball.shape)
        for words, depth in {
            "no surface: all": self.wall * 0, "surface: all of its pixels": (self.wall * 0).astype(numpy.uint16),
            "0, NaN": self.wall * numpy.nan, "below 0.*-depth": -self.wall,
            "preset=relative-inverse": 20 + self.rows / 3 + noise,  # as of a street: the lower, the nearer
            "1/depth of networks": (20000 + 300 * self.rows + 20 * noise).astype(numpy.uint16),
        }.items():
            with self.subTest(words), self.assertWarnsRegex(UserWarning, words):
                touchable.Surface(depth, self.camera)
        with self.assertRaisesRegex(touchable.UsageError, "depth / 1000.*preset=relative-inverse"):
            touchable.Surface(2000 + 30 * self.rows + 20 * noise, self.camera)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            touchable.Surface(self.wall[::-1], self.camera)
            surface = touchable.Surface(self.wall, self.camera)
            surface.push(self.wall * numpy.nan, 10**9)  # later pictures may be empty

    def test_PresetsReadAsFiles(self):
        surface = touchable.Surface((1 / self.wall).astype(numpy.float32), self.camera, preset="relative-inverse",
                                    near_m=self.wall.min(), far_m=self.wall.max())
        self.assertLess(numpy.abs(surface.first_metres - self.wall).max(), 2e-5)
        self.assertLess(self.error_degrees(surface, self.wall, lambda at: self.lean), 0.5)
        codes = (5000 * self.wall).astype(numpy.uint16)
        scene = touchable.Scene.from_camera(self.camera, preset="tum")
        for made in touchable.Surface(codes, self.camera, preset="tum"), touchable.Surface(codes, scene):
            self.assertLess(numpy.abs(made.first_metres - codes / 5000).max(), 1e-7)
            self.assertEqual((made.scene.fx_px, made.scene.camera.metres_per_code), (300, 0.0002))
        soft = numpy.full((100, 160, 3), 0, numpy.uint8)
        self.assertEqual(touchable.Surface(codes[:100], preset="tum", haptic=soft).scene.height, 100)
        near = touchable.Scene.from_camera(self.camera, preset="relative-inverse").metres(codes * 0 + 65535)
        self.assertAlmostEqual(near.max(), 0.5)  # as `touchable info` takes the nearest


class CamerasAndScenes(unittest.TestCase):
    def test_DefaultsMatchLibrary(self):
        struct = _library.CameraStruct()
        _library.call("camera_defaults", struct, struct.struct_size)
        mine = touchable.Camera()._struct()
        for name, _ in struct._fields_:
            self.assertAlmostEqual(getattr(mine, name), getattr(struct, name), places=10, msg=name)
        settings = _library.SolverStruct()
        _library.call("solver_settings_defaults", settings, settings.struct_size)
        mine = touchable.SolverSettings()._struct(1)
        for name, _ in settings._fields_:
            self.assertEqual(getattr(mine, name), getattr(settings, name), name)

    def test_StructSizesMatchLibrary(self):
        for name, struct in (("surface_settings_defaults", _library.SurfaceSettings), (
                "clip_settings_defaults", _library.ClipSettings), ("writer_settings_defaults", _library.WriterSettings), (
                "frame_defaults", _library.FrameStruct)):
            value = struct()
            self.assertEqual(_library.function(name)(value, value.struct_size), touchable.Status.OK, name)

    def test_PointsLieOnPixelRays(self):
        camera = touchable.Camera(64, 48, 80, 90, 31, 23)
        self.assertTrue(numpy.allclose(camera.points(31, 23, 2), (0, 0, -2)))
        self.assertTrue(numpy.allclose(camera.points([31 + 80, 31], [23, 23 - 90], [1, 2]), [(1, 0, -1), (0, 2, -2)]))
        along_rays = touchable.Camera(64, 48, 80, 90, 31, 23, depth_kind="range")
        self.assertAlmostEqual(numpy.linalg.norm(along_rays.points(5, 7, 2)), 2)
        self.assertEqual(camera.points(numpy.zeros((3, 4)), 0, 1).shape, (3, 4, 3))

    def test_PointsLieOnSurface(self):
        depth, camera = hill()
        x, y = numpy.array((20.0, 30.0, 40.0)), 20.0
        depth_m = depth[20, [20, 30, 40]] * 0.001
        over, under = (camera.points(x, y, depth_m + way)[None].repeat(5, 0) for way in (-0.0001, 0.0001))
        surface = touchable.Surface(depth, camera)
        self.assertFalse(surface.touch(over).touching.any())
        self.assertTrue(surface.touch(under).touching.all())

    def test_FieldsOfViewAreAngles(self):
        camera = touchable.Camera.from_fov(90, 640, 480, far_m=3)
        self.assertAlmostEqual(camera.fx_px, 320)
        self.assertEqual((camera.fy_px, camera.cx_px, camera.cy_px, camera.far_m), (camera.fx_px, 319.5, 239.5, 3))

    def test_FramesChooseFilters(self):
        with touchable.open(made("noise", "--frames", "10")) as clip:
            self.assertTrue(clip.scene.has_unstated_filters)
            chosen = clip.scene.with_filters(clip[:10])
            self.assertEqual(chosen.text, clip.touched_scene.text)
            for frames in clip, (frame for frame in clip), ({"depth": frame.depth.copy()} for frame in clip):
                self.assertEqual(clip.scene.with_filters(frames).text, chosen.text)
            endless = itertools.repeat(clip[0])
            self.assertFalse(clip.scene.with_filters(endless).has_unstated_filters)
            self.assertFalse(chosen.has_unstated_filters)
            self.assertNotEqual(chosen.text, clip.scene.text)

    def test_MetresOfCodes(self):
        scene = touchable.Scene.from_camera(touchable.Camera(4, 3, far_m=2))
        codes = numpy.array([[0, 1, 1000, 1999], [2000, 2001, 65535, 3], [4, 5, 6, 7]], numpy.uint16)
        expected = numpy.where((codes > 0) & (codes <= 2000), codes * 0.001, numpy.nan)
        self.assertTrue(numpy.allclose(scene.metres(codes), expected, equal_nan=True))
        self.assertTrue(numpy.allclose(scene.metres(codes.T.copy().T), expected, equal_nan=True))


if __name__ == "__main__":
    unittest.main()
