# SPDX-License-Identifier: Apache-2.0
"""Depth video out: arrays or frames of clips become a clip that keeps every value of depth."""

from __future__ import annotations

import ctypes
import dataclasses
import fractions
import itertools
import math
import os
import warnings
from typing import Any, Iterable

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _library, _planes
from ._clip import Clip, Frame
from ._library import Struct, WriterSettings, call, encoded, flag, made, status_of
from ._scene import Camera, Scene, most_codes, scene_of, usual_far_m
from .errors import Error, error_of


def write(path: str | os.PathLike, frames: Iterable[Any], *, camera: Camera | None = None, scene: Scene | None = None,
          fps: float | fractions.Fraction | None = None, times_ns: ArrayLike | None = None, overwrite: bool = False,
          small: bool = False, exact_colour: bool = False) -> int:
    """Writes a clip; gives how many frames it has. Depth, haptic and height pictures keep every value.

    path: NAME.mkv, NAME.mp4, or a name without a dot: a folder of PNG pictures. It is there once the clip is whole; where
        something goes wrong, also in `frames`, nothing is left of it.
    frames: what has them one after the other, such as a Clip, a list or a generator. A frame is a Frame, a depth array,
        (depth, colour, haptic, height) or the first of these, or a dict of these. Shapes: depth (height, width) uint16
        codes (uint8 where the scene has 8 bits), or floats of metres (NaN, 0: no surface), rounded as the camera's
        metres_per_code says; colour and haptic (height, width, 3) uint8; height (height, width). All have the pictures of the
        first.
    camera or scene: what the pictures mean. May be left out for Frames, whose own scene is taken. Of a camera whose far_m
        is None, and of frames in a list, a tuple or an array, the far plane lies behind what these hold; where codes of a
        stated metres_per_code do not reach as far as floats, they become coarser, which a warning says.
    fps: frames per second, a number or an exact Fraction(30000, 1001); None: as camera or scene say.
    times_ns: (frames,) of frames at a variable rate: when each is shown, nanoseconds, the first at 0, each at least 1 ms
        after the one before. None: at the rate, or as a Clip that is given has them; other Frames
        that were shown at other times give a warning.
    overwrite: a file that is there already is replaced once this one is whole.
    small: few bytes, but slow to write. exact_colour: colour keeps every value too.

    Floats outside the scene's depths, such as beyond far_m, have no surface; a warning says how many. A picture is refused
    if most of its depths are outside. A warning says where rounding turns the surface by more than a degree.

    Raises ExistingFileError (a FileExistsError), UsageError (a ValueError) where a picture or an option cannot be, Error
    where the disk refuses it, and whatever `frames` raises.
    """
    if camera is not None and scene is not None:
        raise _planes.refuse("camera and scene are given; use one of them")
    if times_ns is None and fps is None and isinstance(frames, Clip):
        times_ns = frames.times_ns if frames.has_own_times else None
    if isinstance(camera, Camera) and camera.far_m is None and isinstance(frames, (list, tuple, numpy.ndarray)):
        camera = reaching(camera, frames)
    coming = iter(frames)
    first = list(itertools.islice(coming, 1))
    if not first:
        raise _planes.refuse("there are no frames to write")
    meaning = _meaning(first[0], camera, scene, fps)
    times = None if times_ns is None else _checked(times_ns)
    writer = made("writer_create", "writer_abandon", encoded(f"the path {path!r}", path), meaning._handle.number,
                  _settings(overwrite, small, exact_colour, times))
    count = lost = 0
    degrees = 0.0
    watch = _Times(meaning.frames_per_second) if times is None else None
    try:
        for frame in itertools.chain(first, coming):
            struct = meaning._frame_struct(frame, count, count)
            status, line = status_of("writer_write", writer.number, struct)
            if status:
                raise error_of(status, line if line.startswith("frame ") else f"frame {count}: {line}")
            lost += struct.lost.value
            degrees = max(degrees, struct.degrees.value)
            if watch and isinstance(frame, Frame):
                watch.look(count, frame)
            count += 1
        if times is not None and len(times) != count:
            raise _planes.refuse(f"times_ns has {len(times)} times, but there are {count} frames; must be one for each")
        writer.ends_itself()
        call("writer_finish", writer.number)
    finally:
        writer.close("another thread is writing the clip")
    if watch:
        watch.warn()
    if lost:
        warnings.warn(_planes.lost_words(lost, meaning), stacklevel=2)
    if line := _planes.rounded_words(degrees):
        warnings.warn(line, stacklevel=2)
    return count


# The same rule as `touchable info` for the far plane of pictures.
_stray_of = 10_000  # one depth in this many may be stray
_far_margin, _room = 1.05, 2.0  # how far behind the deepest: of all frames, and of the first of several
_deep_m = 200.0  # no camera sees half of a scene beyond this, so floats are millimetres


def reaching(camera: Camera, frames: Any, later_come: bool = False) -> Camera:
    """The camera, which states no far_m, with one behind all that frames of arrays hold; `later_come`: of floats, with
    one that has room for deeper frames, and steps of far_m / 65534."""
    depths = [depth for frame in frames if (depth := depth_of(frame)) is not None]
    kinds = {depth.dtype.kind for depth in depths}
    are_floats = kinds == {"f"}
    step = 1.0 if are_floats else camera.metres_per_code or 0.001
    if len(kinds) != 1:
        return camera
    most_kept = sum(depth.size for depth in depths) // _stray_of + 1
    deepest, medians, count = numpy.zeros(0), [], 0
    for depth in depths:
        there = _valid(depth)
        if there.size:
            count += there.size
            medians.append(numpy.median(there))
            deepest = numpy.concatenate([deepest, there])
            deepest = numpy.partition(deepest, -most_kept)[-most_kept:] if deepest.size > most_kept else deepest
    if not count:
        return camera
    reach_m = float(numpy.sort(deepest)[-1 - count // _stray_of]) * step
    is_open = are_floats and camera.metres_per_code is None  # the nearer, the finer
    far_m = max(0 if is_open else usual_far_m, reach_m * _far_margin)
    if not are_floats:
        return dataclasses.replace(camera, far_m=min(far_m, most_codes * step))
    if (median_m := float(numpy.median(medians))) > _deep_m:
        raise _planes.refuse(f"depth as floats is metres, and half of it is beyond {median_m:.4g} m; use depth / 1000 "
                             f"where these are millimetres, or a camera that states far_m={far_m:.4g}")
    if camera.metres_per_code is not None and reach_m > most_codes * camera.metres_per_code:
        far_m = reach_m * _far_margin
        warnings.warn(f"depth as floats reaches {reach_m:.4g} m, farther than {most_codes} codes of {camera.metres_per_code} m: "
                      f"it is rounded to {far_m / most_codes:.3g} m; a camera that states far_m keeps its metres_per_code",
                      stacklevel=3)
        return dataclasses.replace(camera, far_m=far_m, metres_per_code=far_m / most_codes)
    step = _decimal(far_m / most_codes) if is_open else camera.metres_per_code
    if not later_come:
        return dataclasses.replace(camera, far_m=far_m, metres_per_code=step)
    roomy = _decimal(_room * reach_m / most_codes)
    # Rounding turns a surface by some 30 degrees times the step's share of a pixel's width: by less than one here.
    if 30 * roomy * camera.fx_px < median_m:
        step = roomy
    # The step stays open, as uint16 is millimetres, of which one has to fit.
    return dataclasses.replace(camera, far_m=max(step * (most_codes - 1), 0.001))


def _decimal(step: float) -> float:
    """1, 2 or 5 times a power of ten, not below it: so millimetres that come as floats stay exact."""
    exponent = math.floor(math.log10(step))
    return next(even for digit in (1, 2, 5, 10) if (even := float(f"{digit}e{exponent}")) >= step)


def depth_of(frame: Any) -> NDArray[Any] | None:
    """Depth of a frame of arrays; None where it is none, which is refused when it is written."""
    if isinstance(frame, Frame):
        return None
    try:
        depth = numpy.asarray(_planes.planes_of(frame)["depth"])
    except (Error, TypeError, ValueError):
        return None
    return depth if depth.dtype.kind == "f" or depth.dtype.newbyteorder("=") == numpy.uint16 else None


def _valid(depth: NDArray[Any]) -> NDArray[Any]:
    """Depths that are there: of codes all but the first and the last, of floats what is no renderer's background."""
    if depth.dtype.kind != "f":
        return depth[(depth > 0) & (depth < most_codes)]
    there = depth[(depth > 0) & (depth < 1e9)]
    return there[there != 65504] if there.size and there.max() == 65504 else there


def _meaning(first: Any, camera: Camera | None, scene: Scene | None, fps: Any) -> Scene:
    if isinstance(camera, Camera) and fps is not None:
        camera = dataclasses.replace(camera, frames_per_second=_library.number("fps", fps))
    given = camera if camera is not None else scene
    if given is None and isinstance(first, Frame):
        given = first.scene
    if given is None:
        raise _planes.refuse("what the pictures mean is not said; give camera=touchable.Camera(...)")
    meaning = scene_of(given, "scene" if camera is None else "camera")
    return meaning if fps is None or isinstance(camera, Camera) else meaning.with_rate(fps)


def _checked(times_ns: ArrayLike) -> NDArray[numpy.int64]:
    times = _planes.array_from("times_ns", times_ns)
    if times.ndim != 1 or times.dtype.kind not in "iu":
        raise _planes.refuse(f"times_ns has the shape {times.shape} of {times.dtype}; must be (frames,) of whole nanoseconds")
    if (times > _library.farthest).any():  # possible for uint64
        raise _planes.refuse(f"times_ns has {times.max()}; must be at most {_library.farthest}")
    if times[:1].any():
        raise _planes.refuse(f"times_ns begins with {times[0]}; must be 0")
    return numpy.ascontiguousarray(times, numpy.int64)


def _settings(overwrite: bool, small: bool, exact_colour: bool, times: NDArray[numpy.int64] | None) -> Struct:
    settings = WriterSettings()
    call("writer_settings_defaults", settings, settings.struct_size)
    settings.overwrite, settings.small = flag("overwrite", overwrite), flag("small", small)
    settings.exact_colour = flag("exact_colour", exact_colour)
    if times is None or len(times) == 1:  # one frame: at the scene's rate
        return settings
    settings.times_ns, settings.times = times.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)), len(times)
    settings.array = times
    return settings


class _Times:
    """Whether frames of a clip were shown at the times that they are written with."""

    def __init__(self, frames_per_second: float) -> None:
        self._interval_ns = 1e9 / frames_per_second
        self._first: int | None = None
        self._off: int | None = None

    def look(self, count: int, frame: Frame) -> None:
        if self._first is None:
            self._first = frame.time_ns
        if self._off is None and abs(frame.time_ns - self._first - count * self._interval_ns) > 2e6:
            self._off = frame.number

    def warn(self) -> None:
        if self._off is not None:
            warnings.warn(f"frame {self._off} was shown at another time than the rate says; times are kept by "
                          "times_ns=[frame.time_ns for frame in frames]", stacklevel=3)
