# SPDX-License-Identifier: Apache-2.0
"""What depth pictures mean: a camera in figures, or a scene, which can say more."""

from __future__ import annotations

import ctypes
import dataclasses
import fractions
import json
import itertools
import math
import numbers
from typing import Any, Iterable, Literal

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _library, _planes
from ._library import CameraStruct, SceneFacts, call, encoded, made, number, of_kind, text_of, whole
from .errors import UsageError, Status

DepthKind = Literal["planar", "range"]
_kinds: tuple[DepthKind, DepthKind] = ("planar", "range")  # TOUCH_PLANAR, TOUCH_RANGE
usual_far_m, most_codes = 10.0, 65535


def index_of_kind(kind: str) -> int:
    """TOUCH_PLANAR or TOUCH_RANGE. Raises UsageError where it is neither."""
    if kind not in _kinds:
        raise UsageError(Status.USAGE, f"depth_kind is {kind!r}; must be 'planar' or 'range'")
    return _kinds.index(kind)


def _points(x_px: ArrayLike, y_px: ArrayLike, depth: ArrayLike, facts: Any) -> NDArray[numpy.float64]:
    given = {"x_px": x_px, "y_px": y_px, "depth_m": depth}
    x, y, depth = (_planes.numbers(name, value) for name, value in given.items())
    ray = numpy.stack(numpy.broadcast_arrays((x - facts.cx_px) / facts.fx_px, (facts.cy_px - y) / facts.fy_px, -1.0), -1)
    if facts.depth_kind == "range":
        ray = ray / numpy.linalg.norm(ray, axis=-1, keepdims=True)
    return ray * depth[..., None]


@dataclasses.dataclass(frozen=True)
class Camera:
    """A pinhole camera, what its depth codes mean, and what its surface feels like. Its scene unit is a metre. Holes
    and the picture's edge have 100 N/m (`hole_stiffness` of a scene file).

    Every member is one number; what is left out is as stated here.

    width, height: pixels, 1 to 16384; 640 and 480.
    fx_px, fy_px: focal lengths, pixels. fx_px: 60 degrees are seen from left to right; fy_px: as fx_px.
    cx_px, cy_px: principal point, pixels, where (0, 0) is the centre of the first pixel; the middle.
    metres_per_code: what a uint16 code of 1 is, metres; depth as floats is rounded to it, and reaches 65535 times as far.
        None: uint16 codes are millimetres, and floats are rounded to far_m / 65534, or of arrays as Surface says.
    far_m: deeper pixels have no surface, metres. None: of arrays of floats without metres_per_code, 5 % beyond these in
        touchable.write, and as Surface says there; otherwise 10, or in touchable.write of arrays as far as these reach.
    frames_per_second: 0.001 to 1000, used where frames are counted and not timed; 30.
    stiffness_n_per_m: where no haptic picture says otherwise, N/m; 600.
    static_friction, dynamic_friction: likewise, coefficients, the second at most the first; 0.4 and 0.3.
    depth_kind: "planar": depth is along -Z, as depth cameras give it; or "range": along the pixel's ray.
    takes_codes: False without metres_per_code, as of a clip whose codes are no multiples of a length: depth is floats alone.

    Raises UsageError (a ValueError) where depth_kind is neither, or metres_per_code is not above 0; and where a scene is made
    of it and a member is out of its range.
    """

    width: int = 640
    height: int = 480
    fx_px: float | None = None
    fy_px: float | None = None
    cx_px: float | None = None
    cy_px: float | None = None
    metres_per_code: float | None = None
    far_m: float | None = None
    frames_per_second: float = 30.0
    stiffness_n_per_m: float = 600.0
    static_friction: float = 0.4
    dynamic_friction: float = 0.3
    depth_kind: DepthKind = "planar"
    takes_codes: bool = True

    def __post_init__(self) -> None:
        for name in "width", "height":
            whole(name, getattr(self, name))
        fx = self.width / 2 / math.tan(math.radians(30)) if self.fx_px is None else self.fx_px
        middle = (self.width - 1) / 2, (self.height - 1) / 2
        for name, value in ("fx_px", fx), ("fy_px", fx), ("cx_px", middle[0]), ("cy_px", middle[1]):
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        index_of_kind(self.depth_kind)
        step = self.metres_per_code
        if step is not None and not number("metres_per_code", step) > 0:
            raise UsageError(Status.USAGE, f"metres_per_code is {step}; must be above 0, such as 0.001, or None: not stated")

    @classmethod
    def from_fov(cls, fov_degrees: float, width: int = 640, height: int = 480, **others: Any) -> Camera:
        """A camera that sees `fov_degrees` from left to right, in a picture of width x height pixels. `others`: further
        members. Raises UsageError where the angle is not above 0 and below 180 degrees."""
        if not 0 < number("fov_degrees", fov_degrees) < 180:
            raise UsageError(Status.USAGE, f"fov_degrees is {fov_degrees}; must be above 0 and below 180")
        return cls(width, height, whole("width", width) / 2 / math.tan(math.radians(fov_degrees) / 2), **others)

    def points(self, x_px: ArrayLike, y_px: ArrayLike, depth_m: ArrayLike) -> NDArray[numpy.float64]:
        """Where pixels at a depth are, metres: X right, Y up, the camera at the origin looks along -Z.

        `x_px`, `y_px` (pixels; column, row) and `depth_m` (metres, as depth_kind says) are numbers or arrays of any
        shapes that fit each other, (...). Gives (..., 3) float64. These are goals of fingers, too.
        """
        return _points(x_px, y_px, depth_m, self)

    def _struct(self) -> _library.Struct:
        far_m = usual_far_m if self.far_m is None else number("far_m", self.far_m)
        members = {**dataclasses.asdict(self), "depth_kind": _kinds.index(self.depth_kind), "far_m": far_m,
                   "metres_per_code": self.metres_per_code or 0.0}
        del members["takes_codes"]
        return CameraStruct(**members)


class Scene:
    """What pictures mean: camera, coding of depth and height, haptic ranges, filters. It does not change.

    Made by Scene.from_camera, Scene.from_text, or of a clip (clip.scene).

    width, height: of depth pictures, pixels.
    depth_kind: "planar" or "range", as Camera has it.
    fx_px, fy_px, cx_px, cy_px: focal lengths and principal point, pixels.
    metres_per_scene_unit: of the world that the camera saw; 1 for scenes from a camera.
    near_units, far_units: depths that count, scene units.
    frames_per_second: of frames that are counted and not timed.
    hand_metres_per_scene_unit: how far a hand moves for a scene unit, metres, as the scene states it; None: it does not.
    has_unstated_filters: whether with_filters would choose some.
    """

    def __init__(self, handle: _library.Handle) -> None:
        """Of a handle of the C API; programs use Scene.from_camera or Scene.from_text."""
        self._handle = of_kind("handle", handle, _library.Handle, "the C API's; use Scene.from_camera or Scene.from_text")
        self._takes_codes = True
        facts = SceneFacts()
        call("scene_describe", handle.number, facts)
        self.width: int = facts.width
        self.height: int = facts.height
        self.depth_kind: DepthKind = _kinds[facts.depth_kind]
        self.fx_px: float = facts.fx_px
        self.fy_px: float = facts.fy_px
        self.cx_px: float = facts.cx_px
        self.cy_px: float = facts.cy_px
        self.metres_per_scene_unit: float = facts.metres_per_scene_unit
        self.near_units: float = facts.near_units
        self.far_units: float = facts.far_units
        self.frames_per_second: float = facts.frames_per_second
        self.hand_metres_per_scene_unit: float | None = facts.hand_metres_per_scene_unit or None
        self.has_unstated_filters: bool = bool(facts.unstated_filters)

    @classmethod
    def from_camera(cls, camera: Camera, preset: str | None = None) -> Scene:
        """A scene of a camera: unit metre, no filter. `preset`: how 16-bit codes store depth, as in touchable.open; where
        a preset gives values another order, Surface(depth, camera, preset=...) takes it. Raises UsageError, which names
        a member out of its range."""
        struct = of_kind("camera", camera, Camera, "a touchable.Camera")._struct()
        scene = cls(made("scene_from_camera", "scene_destroy", struct))
        scene._takes_codes = camera.takes_codes or camera.metres_per_code is not None
        if preset is None:
            return scene
        from ._clip import open_array

        codes = numpy.linspace(0, most_codes, camera.width * camera.height).astype(numpy.uint16)
        frame, _ = open_array(codes.reshape(camera.height, camera.width), camera, preset=preset)
        if not numpy.array_equal(frame.depth[frame.valid], codes.reshape(frame.depth.shape)[frame.valid]):
            raise UsageError(Status.USAGE, f"preset {preset} stores values in another order than that of codes; use "
                             "touchable.Surface(depth, camera, preset=...)")
        return frame.scene

    @classmethod
    def from_text(cls, text: str) -> Scene:
        """A scene of the text of a scene file (docs/scene_file.md). Raises Error, which names a wrong member."""
        data = encoded("the text of the scene", text, "that of a scene file")
        return cls(made("scene_from_text", "scene_destroy", data, len(data)))

    @property
    def text(self) -> str:
        """The scene as the text of a scene file, JSON, which gives the same scene again, to the last bit."""
        return text_of("scene_text", self._handle.number)

    @property
    def camera(self) -> Camera:
        """The scene as a camera, as far as one can say it. Lengths in metres.

        Where codes are no multiples of a length (rendered depth between two planes, disparities), `metres_per_code` is
        None and `takes_codes` False: no number turns such codes into metres; frame.metres and scene.metres do. For pictures
        of codes keep the scene; the camera is for depth in metres.
        """
        said = json.loads(self.text)
        metric = said["depth"].get("scale") if said["depth"]["coding"] == "metric" else None
        is_open = "float_scale" in said["depth"]
        far_m = self.far_units * self.metres_per_scene_unit
        feel = said["default_properties"]
        stiffness = feel["stiffness_n_per_m"] if "stiffness_n_per_m" in feel else feel["stiffness"] * 1000
        return Camera(
            self.width, self.height, self.fx_px, self.fy_px, self.cx_px, self.cy_px,
            metric * self.metres_per_scene_unit if metric and not is_open else None, far_m, self.frames_per_second,
            stiffness, feel["static_friction"], feel["dynamic_friction"], self.depth_kind, metric is not None)

    def points(self, x_px: ArrayLike, y_px: ArrayLike, depth_m: ArrayLike) -> NDArray[numpy.float64]:
        """Where pixels at a depth in metres are, in scene units, as Camera.points has it: (..., 3) float64. These are
        goals of fingers, too."""
        return _points(x_px, y_px, depth_m, self) / self.metres_per_scene_unit

    def metres(self, depth: ArrayLike) -> NDArray[numpy.float32]:
        """Depth of a picture of codes in metres; NaN where there is no surface.

        `depth`: (height, width) uint8 or uint16, or of hue coding (height, width, 3) uint8. Gives
        (height, width) float32, along -Z, or along the pixel's ray where depth_kind is "range".
        Raises UsageError where shape or kind is not the scene's.
        """
        return self._metres(_planes.depth_plane(depth))

    def _metres(self, plane: _library.Plane) -> NDArray[numpy.float32]:
        metres = numpy.empty((self.height, self.width), numpy.float32)
        call("scene_metres", self._handle.number, plane, metres.ctypes.data, metres.strides[0])
        return metres

    def with_filters(self, frames: Iterable[Any]) -> Scene:
        """The scene with the filters that the program would choose by these frames of a recording, from the first on.

        `frames`: up to 16 Frames, depth arrays or dicts of planes, one after the other; more are not taken. Filters that
        the scene states stay. Raises UsageError where a picture has not the scene's size or kind.
        """
        looked_at = list(itertools.islice(frames, 16))
        structs = [self._frame_struct(frame, place, place) for place, frame in enumerate(looked_at)]
        array: Any = (_library.FrameStruct * len(structs))(*structs)
        size = ctypes.sizeof(_library.FrameStruct)
        return self._alike(Scene(made("scene_with_filters", "scene_destroy", self._handle.number, array, size, len(structs))))

    def with_rate(self, frames_per_second: float | fractions.Fraction) -> Scene:
        """The same scene at another rate, frames per second: a number, or an exact Fraction(30000, 1001). Raises
        UsageError where it is no number, Error where it is out of its range."""
        exact = isinstance(frames_per_second, numbers.Rational)
        rate = fractions.Fraction(frames_per_second if exact else number("frames_per_second", frames_per_second))
        rate = rate.limit_denominator(1_000_000)
        text = json.dumps({**json.loads(self.text), "rate": [rate.numerator, rate.denominator]})
        return self._alike(Scene.from_text(text))

    def _alike(self, other: Scene) -> Scene:
        other._takes_codes = self._takes_codes
        return other

    def _frame_struct(self, frame: Any, number: int, time_ns: int) -> _library.Struct:
        """A frame for the library, which is refused where its depth is of codes and the scene has no meaning for them."""
        struct = _planes.frame_struct(frame, number, time_ns)
        if not self._takes_codes and struct.depth.sample != _library.F32:
            raise _planes.refuse(
                "the camera's takes_codes is False and its metres_per_code None, so that its depth is floats of metres, and "
                "not codes; use the clip's scene (clip.scene) for its codes, or a camera that states metres_per_code")
        return struct

    def __reduce__(self) -> tuple:
        return Scene.from_text, (self.text,), {"_takes_codes": self._takes_codes}

    def __repr__(self) -> str:
        return (f"<touchable.Scene {self.width}x{self.height}, fx {self.fx_px:.6g} px, unit "
                f"{self.metres_per_scene_unit:.6g} m, {self.frames_per_second:.6g} frames/s>")


def scene_of(meaning: Camera | Scene | None, what: str = "camera") -> Scene:
    """The scene that was given, or of the camera that was given."""
    if isinstance(meaning, Scene):
        return meaning
    return Scene.from_camera(of_kind(what, meaning, Camera, "a touchable.Camera or a touchable.Scene"))
