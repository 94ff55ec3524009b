# SPDX-License-Identifier: Apache-2.0
"""The C API of touchable.h by ctypes: its structs, its functions, and the libraries that they are in.

Handles are structs of one uint64_t in C; they go by value in the register that a uint64_t does.
"""

from __future__ import annotations

import ctypes
import functools
import math
import numbers
import operator
import os
import pathlib
import weakref
from ctypes import POINTER, c_char, c_char_p, c_double, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p
from typing import Any, Callable, NoReturn, TypeVar

import numpy

from .errors import ClosedError, Status, UsageError, error_of

U8, U16, F32 = 1, 2, 4  # TOUCH_U8, TOUCH_U16, TOUCH_F32
PLANAR, RANGE = 0, 1


farthest = 2**60  # largest magnitude of ticks and times


def whole(name: str, value: Any, least: int = -farthest, most: int = farthest) -> int:
    """An argument that is a whole number. ctypes would cut it to its bits; here one that is out of its range is refused."""
    try:
        number = operator.index(value)
    except TypeError:
        raise UsageError(Status.USAGE, f"{name} is {value!r}; must be a whole number") from None
    if not least <= number <= most:
        raise UsageError(Status.USAGE, f"{name} is {number}; must be {least} to {most}")
    return number


def number(name: str, value: Any) -> float:
    """An argument that is a finite number."""
    try:
        if math.isfinite(value):
            return float(value)
    except (TypeError, ValueError, OverflowError):
        pass
    raise UsageError(Status.USAGE, f"{name} is {value!r}; must be a finite number")


def of_kind(name: str, value: Any, kinds: Any, right: str) -> Any:
    """An argument that is of one of these types. Raises TypeError, as Python does, where it is not."""
    if not isinstance(value, kinds):
        raise TypeError(f"{name} is {type(value).__name__}; must be {right}")
    return value


def flag(name: str, value: Any) -> int:
    """An argument that is True or False."""
    return int(bool(of_kind(name, value, (numbers.Integral, numpy.bool_), "True or False")))


def encoded(what: str, text: str | os.PathLike, right: str = "the name of a file") -> bytes:
    """Text as the C API takes it: UTF-8, which ends at its first NUL. `right`: what it says."""
    try:
        data = os.fsencode(of_kind(what, text, (str, bytes, os.PathLike), right + ", as str, bytes or os.PathLike"))
    except UnicodeEncodeError:
        data = b"\0"
    if not data:
        raise UsageError(Status.USAGE, f"{what} is empty; must be {right}")
    if b"\0" in data:
        raise UsageError(Status.USAGE, f"{what} has a NUL or a lone surrogate; must be text without")
    return data


_ranges = {c_int32: (-(2**31), 2**31 - 1), c_int64: (-farthest, farthest), c_uint64: (0, 2**64 - 1)}


class Struct(ctypes.Structure):
    """A struct that begins with its size."""

    def __init__(self, **members: Any) -> None:
        kinds = dict(self._fields_)
        for name, value in members.items():
            if kinds[name] in _ranges:
                members[name] = whole(name, value, *_ranges[kinds[name]])
            elif kinds[name] is c_double:
                members[name] = number(name, value)
        super().__init__(**members)
        self.struct_size = ctypes.sizeof(self)


def struct(name: str, **members: Any) -> Any:
    """A struct of the header: its members and their types, in order."""
    return type(name, (Struct,), {"_fields_": [("struct_size", c_uint32), *members.items()]})


def several(names: str, kind: Any) -> dict[str, Any]:
    return {name: kind for name in names.split()}


class Plane(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("stride_bytes", c_int64), *several("width height sample channels", c_int32).items()]


class Vec3(ctypes.Structure):
    _fields_ = list(several("x y z", c_double).items())


ErrorLine = struct("ErrorLine", status=c_int32, line=c_char * 504)
CameraStruct = struct("CameraStruct", **several("width height depth_kind", c_int32), **several(
    "fx_px fy_px cx_px cy_px metres_per_code far_m frames_per_second stiffness_n_per_m static_friction"
    " dynamic_friction", c_double))
SceneFacts = struct("SceneFacts", **several("width height depth_kind", c_int32), **several(
    "fx_px fy_px cx_px cy_px metres_per_scene_unit near_units far_units frames_per_second"
    " hand_metres_per_scene_unit", c_double), **several("unstated_filters reserved", c_int32))
FrameStruct = struct("FrameStruct", reserved=c_int32, number=c_int64, time_ns=c_int64,
                     **several("depth colour haptic height", Plane), lost_pixels=POINTER(c_int64),
                     lost_degrees=POINTER(c_double))
SurfaceSettings = struct("SurfaceSettings", **several("threads frames error_bars", c_int32))
FilteredStruct = struct("FilteredStruct", reserved=c_int32, metres=c_void_p, metres_stride_bytes=c_int64, normals=c_void_p,
                        normals_stride_bytes=c_int64, error_degrees=c_void_p, error_degrees_stride_bytes=c_int64)
SolverStruct = struct("SolverStruct", fingers=c_int32, **several(
    "metres_per_scene_unit max_force_n max_stiffness_n_per_m damping_n_s_per_m passivity_n_s_per_m stribeck_m_per_s",
    c_double), stale_after_ns=c_int64, **several("ramp_in_ticks ramp_out_ticks waits_to_be_free reserved", c_int32))
Tick = struct("Tick", reserved=c_int32, tick=c_int64, time_ns=c_int64, epoch=c_uint64, epoch_start_ns=c_int64)
Contact = struct("Contact", guard=c_uint32, **several("force_n goal proxy", Vec3), **several(
    "pixel_x pixel_y stiffness_n_per_m static_friction dynamic_friction", c_double),
    **several("touching in_hole", c_int32), **several("error_degrees error_newtons", c_double))
ClipSettings = struct("ClipSettings", colour=c_int32, scene_file=c_char_p, preset=c_char_p, **several(
    "fx_px fy_px cx_px cy_px fov_degrees metres_per_code near_m far_m", c_double), channel=c_char_p, dataset=c_char_p,
    **several("depth_kind reserved", c_int32))
ClipFacts = struct("ClipFacts", **several(
    "width height depth_sample depth_channels has_colour has_haptic has_height depth_is_lossless notes"
    " has_own_times reserved", c_int32),
    frames=c_int64, frames_per_second=c_double)
WriterSettings = struct("WriterSettings", **several("overwrite small exact_colour", c_int32),
                        times_ns=POINTER(c_int64), times=c_size_t)

_handle, _made = c_uint64, POINTER(c_uint64)
_error: Any = POINTER(ErrorLine)

# Argument types by function name without touch_; all functions return a status. A last `_error` receives the error
# line.
_solver_functions = {
    "camera_defaults": (POINTER(CameraStruct), c_uint32),
    "scene_from_camera": (POINTER(CameraStruct), _made, _error),
    "scene_from_text": (c_char_p, c_size_t, _made, _error),
    "scene_text": (_handle, c_char_p, c_size_t, POINTER(c_size_t)),
    "scene_describe": (_handle, POINTER(SceneFacts)),
    "scene_metres": (_handle, POINTER(Plane), c_void_p, c_int64, _error),
    "frame_defaults": (POINTER(FrameStruct), c_uint32),
    "scene_with_filters": (_handle, POINTER(FrameStruct), c_size_t, c_size_t, _made, _error),
    "scene_destroy": (_handle,),
    "surface_settings_defaults": (POINTER(SurfaceSettings), c_uint32),
    "surface_create": (_handle, POINTER(SurfaceSettings), _made, _error),
    "surface_push": (_handle, POINTER(FrameStruct), _error),
    "surface_begin_epoch": (_handle, c_uint64, _error),
    "surface_end_epoch": (_handle,),
    "surface_newest_ns": (_handle, POINTER(c_int64)),
    "surface_hand_scale": (_handle, POINTER(c_double), _error),
    "surface_filtered": (_handle, POINTER(FilteredStruct), _error),
    "surface_destroy": (_handle,),
    "solver_settings_defaults": (POINTER(SolverStruct), c_uint32),
    "solver_create": (_handle, POINTER(SolverStruct), _made, _error),
    "solver_tick": (_handle, POINTER(Tick), c_void_p, c_void_p, c_size_t),
    "solver_run": (_handle, POINTER(Tick), c_size_t, c_void_p, c_void_p, c_size_t),
    "solver_come_back": (_handle,),
    "solver_force_hash": (_handle, POINTER(c_uint64)),
    "solver_save": (_handle, c_char_p, c_size_t, POINTER(c_size_t)),
    "solver_load": (_handle, c_char_p, c_size_t, _error),
    "solver_state_hash": (_handle, POINTER(c_uint64)),
    "solver_destroy": (_handle,),
    "surface_forces_at": (_handle, POINTER(SolverStruct), POINTER(Tick), c_int32, c_void_p, c_size_t, c_void_p, c_size_t,
                          _error),
}
_media_functions = {
    "clip_settings_defaults": (POINTER(ClipSettings), c_uint32),
    "clip_open": (c_char_p, POINTER(ClipSettings), _made, _error),
    "clip_describe": (_handle, POINTER(ClipFacts)),
    "clip_time": (_handle, c_int64, POINTER(c_int64)),
    "clip_note": (_handle, c_int32, c_char_p, c_size_t, POINTER(c_size_t)),
    "clip_scene": (_handle, c_int32, _made, _error),
    "clip_next": (_handle, _made, _error),
    "clip_seek": (_handle, c_int64, _error),
    "clip_interrupt": (_handle,),
    "clip_close": (_handle,),
    "frameset_frame": (_handle, POINTER(FrameStruct)),
    "frameset_release": (_handle,),
    "writer_settings_defaults": (POINTER(WriterSettings), c_uint32),
    "writer_create": (c_char_p, _handle, POINTER(WriterSettings), _made, _error),
    "writer_write": (_handle, POINTER(FrameStruct), _error),
    "writer_finish": (_handle, _error),
    "writer_abandon": (_handle,),
}

bundled = pathlib.Path(__file__).parent / "lib"


def _load(soname: str, what: str, comes_with: str, folder: str | None = None) -> ctypes.CDLL:
    """The library in a folder that is named, else in the wheel, else the system's. Others find it by its soname."""
    places = [pathlib.Path(folder, "lib", soname), pathlib.Path(folder, soname)] if folder else [bundled / soname]
    path = next((str(place) for place in places if place.exists()), str(places[0]) if folder else soname)
    try:
        return ctypes.CDLL(path, mode=ctypes.RTLD_GLOBAL)
    except OSError as problem:
        raise ImportError(f"{soname}, {what}, cannot be loaded: {problem}. It comes with {comes_with} (docs/python.md)") from None


def _bind(library: ctypes.CDLL, functions: dict[str, tuple]) -> dict[str, Any]:
    bound = {}
    for name, takes in functions.items():
        try:
            function = getattr(library, "touch_" + name)
        except AttributeError:
            raise ImportError(f"{library._name} has no touch_{name}: it is older than this package; "
                              "install both of one version") from None
        function.argtypes, function.restype = takes, c_int32
        bound[name] = function
    return bound


_solver_library = _load("libtouchable.so.0", "the touch solver", "the wheel of touchable and the Debian package touchable")
_solver_library.touch_version.restype = c_uint32
_solver_library.touch_status_name.argtypes, _solver_library.touch_status_name.restype = (c_int32,), c_char_p
_functions = _bind(_solver_library, _solver_functions)


def version() -> str:
    """Of the library that was loaded, such as "0.2.0"."""
    number = _solver_library.touch_version()
    return f"{number // 10000}.{number // 100 % 100}.{number % 100}"


@functools.lru_cache(maxsize=None)
def _media() -> dict[str, Any]:
    # Loaded only when a file is opened or written: it needs FFmpeg, which the solver does not.
    return _bind(_load("libtouchable-media.so.0", "which opens and writes files", "the Debian package touchable; or unpack the "
                       "portable archive touchable-VERSION-linux-x86_64.tar.xz and set TOUCHABLE_MEDIA to its folder",
                       os.environ.get("TOUCHABLE_MEDIA")), _media_functions)


def function(name: str) -> Any:
    """A function of the header, its name without touch_, as ctypes has it."""
    return _functions[name] if name in _functions else _media()[name]


def line_of(status: int, kind: str = "object") -> str:
    line = _solver_library.touch_status_name(status).decode()
    return f"the {kind} {line}; open or make another one after fork()" if status == Status.FORKED else line


def status_of(name: str, *arguments: Any) -> tuple[int, str]:
    """Calls a function; its status, and what was wrong in a line."""
    called = function(name)
    if called.argtypes[-1] is not _error:
        status = called(*arguments)
        return status, line_of(status, name.partition("_")[0]) if status else ""
    error = ErrorLine()
    status = called(*arguments, error)
    return status, error.line.decode("utf-8", "replace") or line_of(status) if status else ""


def call(name: str, *arguments: Any) -> None:
    """Calls a function, and raises what it refuses."""
    status, line = status_of(name, *arguments)
    if status:
        raise error_of(status, line)


def bytes_of(name: str, *arguments: Any) -> bytes:
    """The bytes that a function writes, which first says how many there are."""
    length = c_size_t()
    call(name, *arguments, None, 0, length)
    written = ctypes.create_string_buffer(length.value)
    call(name, *arguments, written, len(written), length)
    return written.raw


def text_of(name: str, *arguments: Any) -> str:
    """The text that a function writes."""
    return bytes_of(name, *arguments).decode()


def _end(end: Callable[..., int], number: int, kept: tuple) -> None:
    try:
        end(number)
    except KeyboardInterrupt:  # before or after the call; a second call with a stale handle is harmless
        end(number)
        raise


def refuse_copies(held: Any) -> NoReturn:
    """The __reduce__ of what holds a C object, by which pickle and copy would take its number alone."""
    raise TypeError(f"a {type(held).__name__} holds memory, threads or files of its process and cannot be pickled or "
                    "copied; pass on what it is made of, such as a path or arrays")


class Handle:
    """A C object. It ends when there is no reference to it any more, or it is closed; what it needs is kept until then."""

    __reduce__ = refuse_copies

    def __init__(self, number: int, end: str, *needs: Any, at_exit: bool = True) -> None:
        """`at_exit`: False: it stays when Python exits, as arrays may lie over its memory until the very end."""
        self.number = number  # the C handle
        self._name_of_end = end
        self._end = weakref.finalize(self, _end, function(end), number, needs)
        self._end.atexit = at_exit

    def check_open(self, line: str) -> None:
        """Raises ClosedError: with `line` where it was closed."""
        if self.closed:
            raise ClosedError(Status.STALE, line)

    def close(self, busy: str) -> None:
        """Ends it. Where it cannot yet, raises Error with Status.BUSY and the line `busy`, and it stays open."""
        if self.closed:
            return
        status, line = status_of(self._name_of_end, self.number)
        if status:
            raise error_of(status, busy if status == Status.BUSY else line)
        self._end.detach()

    def ends_itself(self) -> None:
        """The next call ends it, whatever comes of it."""
        self._end.detach()

    @property
    def closed(self) -> bool:
        return not self._end.alive


_Self = TypeVar("_Self")  # typing.Self is of Python 3.11


class Closable:
    """What holds a C object until it is closed, at the latest where its `with` ends."""

    __reduce__ = refuse_copies
    _handle: Handle

    def close(self) -> None:
        """Ends the object."""

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._handle.closed

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *problem: Any) -> None:
        self.close()


def made(name: str, end: str, *arguments: Any, needs: tuple = (), at_exit: bool = True) -> Handle:
    """A new C object of a function that makes one. Its handle stands before the error, behind what is given here."""
    number = c_uint64()
    try:
        call(name, *arguments, number)
        return Handle(number.value, end, *needs, at_exit=at_exit)
    except BaseException:  # for example Ctrl-C after the object was made
        if number.value:
            function(end)(number.value)
        raise

