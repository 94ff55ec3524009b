# SPDX-License-Identifier: Apache-2.0
"""Depth pictures as a surface that can be touched, also while it moves."""

from __future__ import annotations

import contextlib
import ctypes
import json
import warnings
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _library, _planes
from ._clip import Frame, open_array
from ._library import Closable, SurfaceSettings, call, flag, made
from ._scene import Camera, Scene, scene_of
from ._writing import depth_of, reaching
from .errors import Error, UsageError

if TYPE_CHECKING:
    from ._touch import ForcesAt, Touched


class Surface(Closable):
    """A surface made of depth pictures, still or moving.

    A still one: Surface(depth, camera).touch(path). One that moves: Surface(camera=camera), then push() a picture for
    each moment, and a Solver that ticks. One thread may push while another ticks; neither waits for the other.

    scene: the Scene that says what the pictures mean.
    """

    def __init__(self, depth: ArrayLike | Frame | None = None, camera: Camera | Scene | None = None, *,
                 haptic: ArrayLike | None = None, height: ArrayLike | None = None, threads: int = 1,
                 frames: int = 4, error_bars: bool = False, preset: str | None = None, near_m: float | None = None,
                 far_m: float | None = None) -> None:
        """A surface; of `depth`, at time 0, if that is given.

        depth: (height, width) uint16 codes (uint8 where a Scene has 8 bits), or floats of metres, where what is not above
            0 or not finite has no surface; or a Frame of a clip. Any strides; nothing is kept of it.
        camera: what it means: a Camera or a Scene (with filters: Scene.with_filters). May be left out for a Frame.
        haptic: (height, width, 3) uint8 codes of stiffness, static and dynamic friction. height: (height, width) codes
            of roughness. Both as the scene says.
        threads: that filter a picture, 1 to 16. frames: pictures that are kept at once, 4 to 64 (1: the newest, without touch).
        error_bars: measure each picture for how wrong its touch may be: error_degrees and error_newtons of contacts.
        preset: how `depth` is stored, by name ("relative-inverse", "tum", ...), with near_m and far_m, as touchable.open takes
            them: values become the codes of a file of them (needs libtouchable-media).

        Floats are rounded to the finest decimal step by which 16 bits reach twice as deep as `depth`, so that later pictures
        may be deeper; where this step would turn the surface by a degree, to the finest that reaches 5 % beyond `depth`. A
        camera that states metres_per_code or far_m decides itself. Warnings say once where rounding turns the surface by more
        than a degree, where the first picture has no surface or looks like disparity, and where floats are outside the
        scene's depths, such as beyond far_m. Raises UsageError (a ValueError) if most of a picture is outside, or it has
        another size or kind than the scene.
        """
        if preset is not None:
            if depth is None or isinstance(depth, Frame):
                raise _planes.refuse("preset is given without a depth array; use Scene.from_camera(camera, preset=...)")
            read, _ = open_array(numpy.asarray(depth), camera, preset=preset, near_m=near_m, far_m=far_m)
            depth, meaning = read.depth, read.scene
        else:
            if near_m is not None or far_m is not None:
                raise _planes.refuse("near_m or far_m is given without preset; a camera has far_m")
            meaning = depth.scene if camera is None and isinstance(depth, Frame) else camera
            meaning = meaning_of(meaning, [] if depth is None else [depth])
        self.scene: Scene = scene_of(meaning)
        self._may_be_disparity = preset is None and isinstance(camera, Camera)
        settings = SurfaceSettings(threads=threads, frames=frames, error_bars=flag("error_bars", error_bars))
        self._handle = made("surface_create", "surface_destroy", self.scene._handle.number, settings)
        self._pushed = 0
        self._epoch = 0
        self._warned: set[str] = set()
        self._first: NDArray[Any] | None = None
        self._first_metres: NDArray[numpy.float32] | None = None
        if depth is not None:
            extra: dict[str, Any] = {"haptic": haptic, "height": height}
            plain = isinstance(depth, Frame) or all(picture is None for picture in extra.values())
            self._push(depth if plain else dict(extra, depth=depth), 0)
        elif haptic is not None or height is not None:
            raise _planes.refuse("haptic or height is given without depth; give all of them, or push()")

    def push(self, frame: Any, time_ns: int | None = None) -> None:
        """Adds the picture of a later moment.

        frame: a Frame, a depth array, or a dict or tuple of planes (depth, colour, haptic, height), shapes as above.
        time_ns: when it is there, nanoseconds, later than the one before; None: a Frame's own time, otherwise counted at
            the scene's frames_per_second.

        Raises Error with Status.FULL while the solver still needs all pictures that there are (try again once it has
        ticked on), UsageError where the picture has another size or kind than the scene, most of its floats are outside the
        scene's depths, or the time is not later, ClosedError. Then the surface stays as it was.
        """
        self._push(frame, time_ns)

    def _push(self, frame: Any, time_ns: int | None) -> None:
        """Of push and __init__, whose callers are warned."""
        self._check_open()
        if time_ns is None:
            counted = round(self._pushed * 1e9 / self.scene.frames_per_second)
            time_ns = frame.time_ns if isinstance(frame, Frame) else counted
        struct = self.scene._frame_struct(frame, self._pushed, time_ns)
        call("surface_push", self._handle.number, struct)
        lines = {"lost": _planes.lost_words(struct.lost.value, self.scene) if struct.lost.value else "",
                 "rounded": _planes.rounded_words(struct.degrees.value)}
        if self._first is None:
            self._first = _copy_of(struct.depth)
            lines["first"] = (self._may_be_disparity and _disparity_words(self._first)) or _no_surface_words(
                self._first, self.first_metres)
        self._pushed += 1
        for kind, line in lines.items():
            if line and kind not in self._warned:
                self._warned.add(kind)
                warnings.warn(line, stacklevel=3)

    def begin_epoch(self, epoch: int) -> None:
        """Times of what is pushed from now on may begin anywhere, as after a seek. `epoch`: a larger number than before;
        the first is 0. Ticks that name it meet it once two of its pictures are there. Raises UsageError, ClosedError."""
        self._check_open()
        call("surface_begin_epoch", self._handle.number, _library.whole("epoch", epoch, 0, 2**64 - 1))
        self._epoch = epoch

    def end_epoch(self) -> None:
        """The epoch has no more pictures: its last one stands still. Of use where it has only one. Raises ClosedError."""
        self._check_open()
        call("surface_end_epoch", self._handle.number)

    @property
    def newest_ns(self) -> int | None:
        """Time of the newest picture, nanoseconds; None before the first. In virtual time, push until it is later than
        the tick's time. Raises ClosedError."""
        self._check_open()
        time = ctypes.c_int64()
        call("surface_newest_ns", self._handle.number, time)
        return None if time.value == -(2**63) else time.value

    @property
    def hand_metres_per_scene_unit(self) -> float:
        """How far a hand moves for a scene unit, metres, unless a solver is told otherwise: what the scene states; else
        the picture's width at the median depth of the first picture is 0.16 m. Raises UsageError before that one."""
        self._check_open()
        scale = ctypes.c_double()
        call("surface_hand_scale", self._handle.number, scale)
        return scale.value

    @property
    def first_metres(self) -> NDArray[numpy.float32]:
        """Depth of the first picture that was pushed, metres, (height, width) float32, NaN where there is no surface.
        Raises UsageError before that one."""
        if self._first_metres is None:
            self._first_metres = metres_of(self._first, self.scene)
        return self._first_metres

    def touch(self, path: ArrayLike, **settings: Any) -> Touched:
        """Touches the surface along a path, in one call, from rest at time 0.

        path: (ticks, 3) or (ticks, fingers, 3) float64, a tick for each millisecond: where each finger would be if
            nothing were in its way (its goal), in scene units: X right, Y up, the camera at the origin looks along -Z.
            Camera.points gives such places. NaN: no goal; its force goes to zero.
        settings: members of SolverSettings, such as max_force_n=5.

        Gives a Touched, with arrays of (ticks, fingers, ...). Raises UsageError where the path's shape or a setting
        cannot be, Error with Status.BUSY while a Solver of the surface is open, ClosedError.
        """
        from ._touch import Solver, path_of

        goals = path_of(path)
        with Solver(self, fingers=goals.shape[1], **settings) as solver:
            return solver.run(goals)

    def forces_at(self, points: ArrayLike, *, friction: bool = False, time_ns: int | None = None,
                  **settings: Any) -> ForcesAt:
        """The force at any number of places: each as of a finger alone that came to it along its pixel's ray, from the
        camera, and stays there until its force is steady.

        points: (..., 3) float64, scene units, as Camera.points gives them. A place that is no number has no force.
        friction: False: the force pushes along the surface's normal; True: friction may hold the finger where it met the
            surface, and its force then leans along the ray.
        time_ns: the moment of the pictures' clock; None: that of the newest picture. Later ticks of the surface do not go
            back before it.
        settings: members of SolverSettings, such as metres_per_scene_unit=1; ramps, waits_to_be_free and stale_after_ns
            do not count.

        Gives a ForcesAt, with arrays of the same shape (...). Raises UsageError where shape or setting cannot be or no
        picture was pushed, Error with Status.BUSY while a Solver of the surface is open, ClosedError.
        """
        from ._touch import forces_at

        self._check_open()
        return forces_at(self, points, friction, time_ns, settings)

    def close(self) -> None:
        """Ends the surface. Raises Error with Status.BUSY while a Solver of it is open. Closing twice does nothing."""
        self._handle.close("a solver of the surface is open, or another thread pushes a picture; end that first")

    def _check_open(self) -> None:
        self._handle.check_open("the surface was closed; make another one")


def meaning_of(camera: Camera | Scene | None, pictures: list[Any]) -> Camera | Scene | None:
    """What pictures mean: a camera that leaves far_m and metres_per_code open gets them by the floats of these."""
    given = [depth for picture in pictures if (depth := depth_of(picture)) is not None and depth.dtype.kind == "f"]
    if not given or not isinstance(camera, Camera) or camera.far_m is not None or camera.metres_per_code is not None:
        return camera
    try:
        return reaching(camera, given, later_come=True)
    except UsageError as problem:
        raise _planes.refuse("; ".join(filter(None, (problem.line, _disparity_words(given[0]))))) from None


def metres_of(depth: NDArray[Any] | None, scene: Scene) -> NDArray[numpy.float32]:
    """Depth that was pushed, in metres; NaN where there is no surface."""
    if depth is None:
        raise _planes.refuse("no picture was pushed yet; push the first one before")
    if depth.dtype != numpy.float32:
        return scene.metres(depth)
    # Compare as floats, like the library: depth exactly at the far plane has a surface.
    near, far = (numpy.float32(units * scene.metres_per_scene_unit) for units in (scene.near_units, _deepest(scene)))
    return numpy.where((depth > 0) & (depth >= near) & (depth <= far), depth, numpy.float32(numpy.nan))


def _deepest(scene: Scene) -> float:
    """Scene units: the far plane, or what is still rounded to the last code before it."""
    coding = json.loads(scene.text)["depth"]
    if coding["coding"] != "metric":
        return scene.far_units
    step = coding.get("float_scale", coding["scale"])
    last = min(round(scene.far_units / step), coding["code_max"])
    while last * step > scene.far_units or last in coding["invalid"]:
        last -= 1
    return min(scene.far_units, (last + 0.5) * step)


def _no_surface_words(depth: NDArray[Any], metres: NDArray[numpy.float32]) -> str:
    """What a warning says of a picture without any surface; empty: it has one."""
    if numpy.isfinite(metres).any():
        return ""
    if depth.dtype.kind == "f" and (depth < 0).any():
        return "the picture has no surface: its depths are below 0; depth is positive away from the camera, so give -depth"
    return "the picture has no surface: all of its pixels are 0, NaN, or outside the depths that the camera or scene has"


def _disparity_words(depth: NDArray[Any]) -> str:
    """What the library says of depth that looks like disparity, as of a file; empty: nothing."""
    valid = (depth > 0) & (depth < 1e9)
    third = len(depth) // 3
    upper, lower = depth[:third][valid[:third]], depth[-third:][valid[-third:]]
    if upper.size and lower.size and lower.mean() > upper.mean():
        scaled = numpy.where(valid, depth * (5 / numpy.median(depth[valid])), 0)  # surely lengths, by their size
        with contextlib.suppress(ImportError, Error):  # without libtouchable-media it stays unsaid
            return next((note for note in open_array(scaled)[1] if "relative-inverse" in note), "")
    return ""


def _copy_of(plane: _library.Plane) -> NDArray[Any]:
    return numpy.array(numpy.asarray(_planes._Owner(plane, None)))
