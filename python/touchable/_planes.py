# SPDX-License-Identifier: Apache-2.0
"""numpy arrays as the planes of touchable.h, and its planes as arrays. Nothing is copied where that can be."""

from __future__ import annotations

import ctypes
from typing import Any, Callable, Mapping

import numpy
from numpy.typing import ArrayLike, NDArray

from ._library import F32, U8, U16, FrameStruct, Handle, Plane, Struct
from .errors import Status, UsageError

roles = ("depth", "colour", "haptic", "height")
_samples = {"uint8": U8, "uint16": U16, "float32": F32}
_types = {U8: "|u1", U16: numpy.dtype(numpy.uint16).str, F32: numpy.dtype(numpy.float32).str}

_Masked = numpy.ma.MaskedArray


def refuse(line: str) -> UsageError:
    return UsageError(Status.USAGE, line)


def array_from(what: str, given: Any, kind: Any = None, read: Callable[..., Any] = numpy.asarray) -> Any:
    """An argument as an array, of the type `kind`, or of its own. Raises UsageError where it is none."""
    try:
        return read(given, kind)
    except (TypeError, ValueError, OverflowError) as problem:
        raise refuse(f"{what}: no array of numbers: {problem}") from None


def numbers(what: str, given: ArrayLike) -> NDArray[numpy.float64]:
    """An argument as an array of float64, NaN where it is masked."""
    if isinstance(given, _Masked) or (isinstance(given, (list, tuple)) and _Masked in map(type, given)):
        return array_from(what, given, numpy.float64, numpy.ma.array).filled(numpy.nan)
    return array_from(what, given, numpy.float64)


def _as_stored(given: ArrayLike, role: str) -> NDArray[Any]:
    """An array of a kind that planes have, whose pixels lie side by side; rows may lie anywhere."""
    if isinstance(given, _Masked):
        raise refuse(f"the {role} picture is a masked array; fill it first, such as picture.filled(0)")
    array = array_from(f"the {role} picture", given)
    wide = role == "depth" and array.dtype.kind == "f"
    if not wide and array.dtype.newbyteorder("=").name not in _samples:
        right = "uint16 or uint8 codes, or floats of metres" if role == "depth" else "uint8"
        raise refuse(f"the {role} picture is of {array.dtype}; must be {right}, as by picture.astype(...)")
    kind = numpy.dtype(numpy.float32) if wide else array.dtype.newbyteorder("=")
    right = "(height, width)" if role in ("depth", "height") else "(height, width, 3)"
    if array.ndim not in (2, 3) or 0 in array.shape or (array.ndim == 3 and array.shape[2] not in (1, 3)):
        raise refuse(f"the {role} picture has the shape {array.shape}; must be {right}")
    array = array.astype(kind, copy=False)
    pixel = array.itemsize * (array.shape[2] if array.ndim == 3 else 1)
    side_by_side = (array.strides[1] == pixel and (array.ndim == 2 or array.strides[2] == array.itemsize)
                    and abs(array.strides[0]) >= pixel * array.shape[1])
    return array if side_by_side else numpy.ascontiguousarray(array)


def plane_of(given: ArrayLike, role: str) -> Plane:
    """A picture as a plane, which keeps the array alive."""
    array = _as_stored(given, role)
    plane = Plane(array.ctypes.data, array.strides[0], array.shape[1], array.shape[0], _samples[array.dtype.name],
                  array.shape[2] if array.ndim == 3 else 1)
    plane.array = array
    return plane


def depth_plane(depth: ArrayLike) -> Plane:
    return plane_of(depth, "depth")


def frame_struct(frame: Any, number: int, time_ns: int) -> Struct:
    """A frame of whatever has pictures, with this number and time: a Frame, a depth array, a dict or a tuple of planes.
    It is good for as long as the frame is. The library writes to `lost` how many pixels are outside the scene's depths,
    and to `degrees` how much rounding turns the surface."""
    lost, degrees = ctypes.c_int64(), ctypes.c_double()
    stored = getattr(frame, "_struct", None)
    if isinstance(stored, FrameStruct):
        struct = FrameStruct(number=number, time_ns=time_ns, **{role: getattr(stored, role) for role in roles})
        struct.lost, struct.degrees = lost, degrees
        return struct
    planes = planes_of(frame)
    made = {role: plane_of(given, role) for role, given in planes.items() if given is not None}
    struct = FrameStruct(number=number, time_ns=time_ns, **made)
    struct.arrays = [plane.array for plane in made.values()]
    struct.lost, struct.lost_pixels = lost, ctypes.pointer(lost)
    struct.degrees, struct.lost_degrees = degrees, ctypes.pointer(degrees)
    return struct


def planes_of(frame: Any) -> dict[str, Any]:
    """Pictures by role, of a depth array, a dict or a tuple of planes."""
    if isinstance(frame, tuple):
        if not 1 <= len(frame) <= len(roles):
            raise refuse(f"a frame is a tuple of {len(frame)}; must be (depth, colour, haptic, height) or the first of these")
        frame = dict(zip(roles, frame))
    planes = dict(frame) if isinstance(frame, Mapping) else {"depth": frame}
    unknown = [name for name in planes if name not in roles]
    if unknown:
        raise refuse(f"a frame has a picture {unknown[0]!r}; must be one of {', '.join(roles)}")
    if planes.get("depth") is None:
        raise refuse("a frame has no depth; it must be there, other pictures may be")
    return planes


def lost_words(lost: int, scene: Any) -> str:
    """What a warning says of depths that became holes."""
    near, far = scene.near_units * scene.metres_per_scene_unit, scene.far_units * scene.metres_per_scene_unit
    return (f"{lost} pixels have no surface: their depth as floats, in metres, is outside {near:.4g} to {far:.4g} m or beyond "
            "the last code; a larger far_m (and metres_per_code) of the camera keeps them, 0 or NaN says that there is none")


def rounded_words(degrees: float) -> str:
    """What a warning says of floats that are rounded too much; empty up to a degree."""
    return "" if degrees <= 1 else (
            f"rounding turns the surface by {degrees:.2g} degrees on average: depth as floats is finer than the steps that "
            "it is rounded to; a camera with a smaller far_m, or a finer metres_per_code, loses less")


class _Owner:
    """What numpy sees as a plane's owner: it keeps the frameset for as long as an array refers to its memory."""

    def __init__(self, plane: Plane, handle: Handle | None) -> None:
        shape: tuple[int, ...] = (plane.height, plane.width)
        size = plane.sample
        strides: tuple[int, ...] = (plane.stride_bytes, size * plane.channels)
        if plane.channels > 1:
            shape, strides = (*shape, plane.channels), (*strides, size)
        self.handle = handle
        self.__array_interface__ = {"version": 3, "typestr": _types[size], "shape": shape, "strides": strides,
                                    "data": (plane.data, True)}


def array_of(plane: Plane, handle: Handle) -> NDArray[Any] | None:
    """The plane of a frameset as an array over its memory, read-only; None where there is no such picture."""
    return numpy.asarray(_Owner(plane, handle)) if plane.data else None
