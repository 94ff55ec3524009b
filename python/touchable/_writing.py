"""Depth video out: arrays or frames of clips become a clip that keeps every value of depth."""

from __future__ import annotations

import ctypes
import dataclasses
import fractions
import itertools
import os
import warnings
from typing import Any, Iterable

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _library, _planes
from ._clip import Clip, Frame
from ._library import Handle, Struct, WriterSettings, call, encoded, made, status_of
from ._scene import Camera, Scene, scene_of
from .errors import Error, ExistingFileError, error_of


def write(path: str | os.PathLike, frames: Iterable[Any], *, camera: Camera | None = None, scene: Scene | None = None,
          fps: float | fractions.Fraction | None = None, times_ns: ArrayLike | None = None, overwrite: bool = False,
          small: bool = False, exact_colour: bool = False) -> int:
    """Writes a clip; gives how many frames it has. Depth, haptic and height pictures keep every value.

    path: NAME.mkv, NAME.mp4, or a name without a dot: a folder of PNG pictures. It is there once the clip is whole; where
        something goes wrong, also in `frames`, nothing is left of it.
    frames: what has them one after the other, such as a Clip, a list or a generator. A frame is a Frame, a depth array,
        (depth, colour, haptic, height) or the first of these, or a dict of these. Shapes: depth (height, width) uint16
        codes (uint8 where the scene has 8 bits), or floats of metres (NaN, 0: no surface), rounded to the camera's
        metres_per_code; colour and haptic (height, width, 3) uint8; height (height, width). All have the pictures of the
        first.
    camera or scene: what the pictures mean. May be left out for Frames, whose own scene is taken.
    fps: frames per second, a number or an exact Fraction(30000, 1001); None: as camera or scene say.
    times_ns: (frames,) of frames at a variable rate: when each is shown, nanoseconds, the first at 0, each at least 1 ms
        after the one before. None: at the rate, or as a Clip that is given has them; other Frames
        that were shown at other times give a warning.
    overwrite: a file that is there already is replaced once this one is whole.
    small: few bytes rather than quick to decode. exact_colour: colour keeps every value too.

    Raises ExistingFileError (a FileExistsError), UsageError (a ValueError) where a picture or an option cannot be, Error
    where the disk refuses it, and whatever `frames` raises.
    """
    if camera is not None and scene is not None:
        raise _planes.refuse("camera and scene are given; right would be one of them")
    if times_ns is None and fps is None and isinstance(frames, Clip):
        times_ns = frames.times_ns if frames.has_own_times else None
    coming = iter(frames)
    first = list(itertools.islice(coming, 1))
    if not first:
        raise _planes.refuse("there are no frames to write")
    meaning = _meaning(first[0], camera, scene, fps)
    times = None if times_ns is None else _checked(times_ns)
    writer = _create(path, meaning, _settings(overwrite, small, exact_colour, times))
    count = 0
    watch = _Times(meaning.frames_per_second) if times is None else None
    try:
        for frame in itertools.chain(first, coming):
            struct = _planes.frame_struct(frame, count, count)
            status, line = status_of("writer_write", writer.number, struct)
            if status:
                raise error_of(status, line if line.startswith("frame ") else f"frame {count}: {line}")
            if watch and isinstance(frame, Frame):
                watch.look(count, frame)
            count += 1
        if times is not None and len(times) != count:
            raise _planes.refuse(f"times_ns has {len(times)} times, but there are {count} frames; right would be one for "
                                 "each")
        writer.ends_itself()
        call("writer_finish", writer.number)
    finally:
        writer.close("another thread is writing the clip")
    if watch:
        watch.warn()
    return count


def _meaning(first: Any, camera: Camera | None, scene: Scene | None, fps: Any) -> Scene:
    if camera is not None and fps is not None:
        camera = dataclasses.replace(camera, frames_per_second=_library.number("fps", fps))
    given = camera if camera is not None else scene
    if given is None and isinstance(first, Frame):
        given = first.scene
    if given is None:
        raise _planes.refuse("what the pictures mean is not said; right would be camera=touchable.Camera(...)")
    meaning = scene_of(given)
    return meaning if fps is None or camera is not None else meaning.with_rate(fps)


def _checked(times_ns: ArrayLike) -> NDArray[numpy.int64]:
    times = _planes.array_from("times_ns", times_ns)
    if times.ndim != 1 or times.dtype.kind not in "iu":
        raise _planes.refuse(f"times_ns has the shape {times.shape} of {times.dtype}; right would be (frames,) of whole "
                             "nanoseconds")
    if (times > _library.farthest).any():  # of uint64
        raise _planes.refuse(f"times_ns has {times.max()}; right would be at most {_library.farthest}")
    if times[:1].any():
        raise _planes.refuse(f"times_ns begins with {times[0]}; right would be 0")
    return numpy.ascontiguousarray(times, numpy.int64)


def _settings(overwrite: bool, small: bool, exact_colour: bool, times: NDArray[numpy.int64] | None) -> Struct:
    settings = WriterSettings()
    call("writer_settings_defaults", settings, settings.struct_size)
    settings.overwrite, settings.small, settings.exact_colour = int(overwrite), int(small), int(exact_colour)
    if times is None or len(times) == 1:  # of one frame, at any rate
        return settings
    settings.times_ns, settings.times = times.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)), len(times)
    settings.array = times
    return settings


def _create(path: str | os.PathLike, scene: Scene, settings: Struct) -> Handle:
    try:
        return made("writer_create", "writer_abandon", encoded(f"the path {path!r}", path), scene._handle.number, settings)
    except Error as problem:
        if " is there already; " in problem.line:  # no status tells it from other things that cannot be
            raise ExistingFileError(problem.status, problem.line) from None
        raise


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
