# SPDX-License-Identifier: Apache-2.0
"""Files of depth video as sequences of frames, whose pictures are numpy arrays over the memory that the clip decodes to."""

from __future__ import annotations

import concurrent.futures
import functools
import json
import operator
import os
import stat
import tempfile
import threading
from typing import TYPE_CHECKING, Any, Callable, Iterator, SupportsIndex, overload

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _library, _planes
from ._library import (ClipFacts, ClipSettings, Closable, FrameStruct, Handle, call, encoded, flag, made, of_kind, refuse_copies,
                       text_of)
from ._scene import Camera, Scene, index_of_kind
from .errors import Error, MissingFileError, Status, error_of

if TYPE_CHECKING:
    from ._filtering import ClipFilter, Filtered
    from ._touch import Touched

_filters_stated, _filters_chosen = 0, 1
_longest_end_s = 10


class Frame:
    """The pictures of one moment of a clip. They do not change, and may be kept: also where the clip is closed.

    Arrays lie over the memory that the clip decoded to (nothing is copied) and are read-only; that memory is kept as
    long as an array refers to it. picture.copy() gives an array of your own. At most 65536 frames are kept at a time.

    scene: the Scene that says what the pictures mean.
    number: from 0.
    time_ns: when it is shown, nanoseconds of the clip's clock.

    filtered_metres, normals and error_degrees are of the depth that the filters leave by which the program touches the clip
    (clip.touched_scene). With a filter that remembers, frames that are asked in turn are filtered in turn; another one as
    the program does after a jump: from 16 frames earlier, which are read again. They have to be asked before the clip is
    closed, and then are kept.
    """

    __reduce__ = refuse_copies

    def __init__(self, handle: Handle, scene: Scene, colour: bool = True, clip_filter: ClipFilter | None = None) -> None:
        """Of a handle of the C API; programs get frames from a Clip."""
        self._handle = of_kind("handle", handle, Handle, "the C API's; touchable.open gives frames")
        self._struct = FrameStruct()
        call("frameset_frame", handle.number, self._struct)
        if not colour:  # some formats decode colour nevertheless
            self._struct.colour = _library.Plane()
        self.scene = scene
        self._clip_filter = clip_filter
        self.number: int = self._struct.number
        self.time_ns: int = self._struct.time_ns

    @property
    def time_s(self) -> float:
        """When it is shown, seconds of the clip's clock."""
        return self.time_ns * 1e-9

    @functools.cached_property
    def depth(self) -> NDArray[Any]:
        """Depth as it is stored: (height, width) uint8 or uint16 codes; of hue coding (height, width, 3) uint8."""
        return numpy.asarray(_planes.array_of(self._struct.depth, self._handle))  # depth is never None

    @functools.cached_property
    def colour(self) -> NDArray[numpy.uint8] | None:
        """(height, width, 3) uint8: red, green, blue. None where the clip has none."""
        return _planes.array_of(self._struct.colour, self._handle)

    @functools.cached_property
    def haptic(self) -> NDArray[numpy.uint8] | None:
        """(height, width, 3) uint8 codes: stiffness, static and dynamic friction. None where the clip has none."""
        return _planes.array_of(self._struct.haptic, self._handle)

    @functools.cached_property
    def height(self) -> NDArray[Any] | None:
        """(height, width) uint8 or uint16 codes of roughness. None where the clip has none."""
        return _planes.array_of(self._struct.height, self._handle)

    @functools.cached_property
    def metres(self) -> NDArray[numpy.float32]:
        """Depth in metres, (height, width) float32, NaN where there is no surface. As the codes say it: along -Z, or
        along the pixel's ray where scene.depth_kind is "range"."""
        return self.scene._metres(self._struct.depth)

    @functools.cached_property
    def valid(self) -> NDArray[numpy.bool_]:
        """Where there is a surface, (height, width) bool."""
        return numpy.isfinite(self.metres)

    @property
    def filtered_metres(self) -> NDArray[numpy.float32]:
        """Depth in metres as the filters leave it, (height, width) float32, NaN where there is no surface, which filters
        may fill. Raises UsageError where the clip was closed before."""
        return self._filtered.metres

    @property
    def normals(self) -> NDArray[numpy.float32]:
        """The filtered surface's normals, (height, width, 3) float32 of length 1, towards the camera: X right, Y up, the
        camera looks along -Z. NaN where there is none. Raises as filtered_metres."""
        return self._filtered.normals

    @property
    def error_degrees(self) -> NDArray[numpy.float32]:
        """How wrong normals may be, (height, width) float32: about 95 of 100 are off by less, as far as pictures show it.
        NaN where that cannot be told. Raises as filtered_metres."""
        return self._filtered.error_degrees

    @functools.cached_property
    def _filtered(self) -> Filtered:
        from ._filtering import filtered

        return filtered(self) if self._clip_filter is None else self._clip_filter.of(self)

    def __repr__(self) -> str:
        have = ", ".join(role for role in _planes.roles if getattr(self._struct, role).data)
        return f"<touchable.Frame {self.number} at {self.time_s:.6f} s: {have}>"


def _interruptibly(work: Callable[[], Any], interrupt: Callable[[], Any] | None = None) -> Any:
    """Work that may wait for others, on a thread of its own, so that Ctrl-C ends the wait. Where the work can be
    interrupted it is over then: what it used is used no more."""
    outcome: concurrent.futures.Future[Any] = concurrent.futures.Future()

    def run() -> None:
        try:
            outcome.set_result(work())
        except BaseException as problem:
            outcome.set_exception(problem)

    try:
        threading.Thread(target=run, daemon=True).start()
        return outcome.result()
    except BaseException:
        if interrupt and not outcome.done():
            interrupt()
            concurrent.futures.wait([outcome], _longest_end_s)
        raise


def _next_of(clip: Handle) -> Handle | None:
    try:
        return made("clip_next", "frameset_release", clip.number, at_exit=False)
    except Error as problem:
        if problem.status == Status.END:
            return None
        raise


class Clip(Closable):
    """A clip that is open: a sequence of Frames. touchable.open makes it.

    `for frame in clip` begins at the first frame each time (a stream, which cannot go back, only once). clip[5] and
    clip[-1] give one frame, clip[2:8] a list; len(clip) how many there are, where that is known. One thread at a time
    uses a clip. Use it in `with`, or close() it; otherwise it closes when nothing refers to it any more.

    pickle takes its path and what open() was told, not its pictures: where it is unpickled, also on another machine with
    the same files, it is opened again, at its first frame, by its absolute path. That raises what open() raises, and
    Error where the file's size or time of change is another one. copy does the same. A stream is refused (TypeError).

    path: as it was given; absolute where it was unpickled.
    width, height: of every picture, pixels.
    has_colour, has_haptic, has_height: whether frames have such a picture.
    depth_is_lossless: whether the codec of depth keeps every value.
    frames_per_second: their mean where frames have times of their own.
    has_own_times: whether frames come at a variable rate.
    frame_count: how many frames; None: only reading tells.
    notes: lines of text that a person should know of the clip, such as what was guessed of it.
    """

    _reopening: tuple[Any, ...] | None = None  # what _reopened takes

    def __init__(self, path: str | os.PathLike, settings: _library.Struct) -> None:
        """Programs use touchable.open."""
        of_kind("settings", settings, ClipSettings, "the C API's; use touchable.open")
        name = encoded(f"the path {path!r}", path, "the name of a file or folder, or the address of a stream")
        self.path = os.fspath(path)
        self._is_stream = b"://" in name or name == b"-"
        self._position: int | None = 0
        self._with_colour = bool(settings.colour)
        opening = functools.partial(made, "clip_open", "clip_close", name, settings)
        try:
            self._handle = _interruptibly(opening) if self._is_stream else opening()
        except Error as problem:
            if problem.status == Status.INPUT and not self._is_stream and not os.path.exists(path):
                raise MissingFileError(problem.status, problem.line) from None
            raise
        facts = ClipFacts()
        call("clip_describe", self._handle.number, facts)
        self.width: int = facts.width
        self.height: int = facts.height
        self.has_colour: bool = self._with_colour and bool(facts.has_colour)
        self.has_haptic: bool = bool(facts.has_haptic)
        self.has_height: bool = bool(facts.has_height)
        self.depth_is_lossless: bool = bool(facts.depth_is_lossless)
        self.has_own_times: bool = bool(facts.has_own_times)
        self.frames_per_second: float = facts.frames_per_second
        self.frame_count: int | None = facts.frames if facts.frames >= 0 else None
        self.notes: list[str] = [text_of("clip_note", self._handle.number, k) for k in range(facts.notes)]

    @property
    def times_ns(self) -> NDArray[numpy.int64]:
        """When each frame is shown, (frames,) nanoseconds from 0, without reading any. Raises ClosedError, and TypeError
        where the number of frames is not known."""
        self._check_open()
        time = _library.c_int64()
        times = numpy.empty(len(self), numpy.int64)
        for index in range(len(times)):
            call("clip_time", self._handle.number, index, time)
            times[index] = time.value
        return times

    @functools.cached_property
    def scene(self) -> Scene:
        """What the pictures mean: a Scene, with the filters that the clip states (others are off). Raises ClosedError."""
        return self._scene(_filters_stated)

    @functools.cached_property
    def touched_scene(self) -> Scene:
        """The Scene by which the program touches the clip: filters that the clip leaves open are chosen by up to 16 of
        its first frames, which are read for it. Raises Error where these cannot be read, ClosedError."""
        return self._scene(_filters_chosen)

    @property
    def camera(self) -> Camera:
        """The clip's camera, lengths in metres; see Scene.camera."""
        return self.scene.camera

    def _scene(self, filters: int) -> Scene:
        self._check_open()
        return Scene(self._waiting(functools.partial(made, "clip_scene", "scene_destroy", self._handle.number, filters)))

    def read(self, index: int) -> Frame | None:
        """Frame `index`, from 0; None behind the last one. In order from 0 this is quickest, and all that streams do.
        Raises Error, which names file, track and frame, where it cannot be read; frames behind it may be."""
        self._check_open()
        index = _library.whole("index", index)
        if self._position != index:
            call("clip_seek", self._handle.number, index)
        self._position = None  # unknown if the next call fails
        handle = self._waiting(functools.partial(_next_of, self._handle))
        if handle is None:
            return None
        self._position = index + 1
        return Frame(handle, self.scene, self._with_colour, self._filter)

    @functools.cached_property
    def _filter(self) -> ClipFilter:
        from ._filtering import ClipFilter

        return ClipFilter(self)

    def _waiting(self, work: Callable[[], Any]) -> Any:
        if not self._is_stream:
            return work()
        return _interruptibly(work, functools.partial(_library.function("clip_interrupt"), self._handle.number))

    def touch(self, path: ArrayLike, **settings: Any) -> Touched:
        """Touches the clip along a path; see touchable.touch."""
        from ._touch import touch

        return touch(self, path, **settings)

    def close(self) -> None:
        """Closes the file. Frames and arrays that were read stay. Raises Error with Status.BUSY while another thread reads
        it. Closing twice does nothing."""
        self._handle.close(f"another thread is reading {self.path}; close it after that")

    def __reduce__(self) -> tuple:
        if self._reopening is None:
            refuse_copies(self)
        self._check_open()
        return _reopened, self._reopening

    def _check_open(self) -> None:
        self._handle.check_open(f"the clip {self.path} was closed; open it again")

    def __iter__(self) -> Iterator[Frame]:
        index = 0
        while (frame := self.read(index)) is not None:
            yield frame
            index += 1

    def __len__(self) -> int:
        if self.frame_count is None:
            raise TypeError(f"how many frames {self.path} has is known only once all are read")
        return self.frame_count

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...

    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        wanted = operator.index(of_kind("index", index, SupportsIndex, "a whole number or a slice"))
        place = wanted + len(self) if wanted < 0 else wanted
        beyond = place < 0 or (self.frame_count is not None and place >= self.frame_count)
        frame = None if beyond else self.read(place)
        if frame is None:
            count = "" if self.frame_count is None else f", which has {self.frame_count}"
            raise IndexError(f"there is no frame {wanted} in {self.path}{count}")
        return frame

    def __repr__(self) -> str:
        count = "?" if self.frame_count is None else self.frame_count
        return (f"<touchable.Clip {self.path}: {count} frames, {self.width}x{self.height}, "
                f"{self.frames_per_second:.6g} frames/s{', closed' if self.closed else ''}>")


def _stamp(path: str | os.PathLike) -> tuple[int, int] | None:
    """What tells a changed file: its size (0 of a folder) and the nanosecond of its last change. None: no single file."""
    try:
        status = os.stat(path)
    except OSError:
        return None
    return 0 if stat.S_ISDIR(status.st_mode) else status.st_size, status.st_mtime_ns


def _reopened(path: str, options: dict[str, Any], stamp: tuple[int, int] | None) -> Clip:
    """A clip that was pickled, opened again."""
    clip = open(path, **options)
    if _stamp(path) != stamp:
        clip.close()
        raise Error(Status.INPUT, f"{os.fsdecode(path)}: has another size or time of change than where the clip was pickled; "
                    "copy files with their times (cp -p, rsync -t), and open a changed one anew")
    return clip


def open(path: str | os.PathLike, *, colour: bool = True, scene_file: str | os.PathLike | None = None,
         preset: str | None = None, fx_px: float | None = None, fy_px: float | None = None,
         cx_px: float | None = None, cy_px: float | None = None, fov_degrees: float | None = None,
         metres_per_code: float | None = None, depth_kind: str | None = None, near_m: float | None = None,
         far_m: float | None = None, channel: str | None = None, dataset: str | None = None) -> Clip:
    """Opens whatever the program `touchable` opens: a clip, a recording of a camera, a folder of pictures, a picture with
    depth, the address of a stream. docs/formats.md lists them.

    What a file does not say of its camera is guessed, which clip.notes tell, unless it is said here:
    colour: False: frames come without colour, which saves decoding.
    scene_file: a scene file that describes the clip instead of its own.
    preset: what is known of a camera by name, such as "realsense" or "tum".
    fx_px, fy_px: focal lengths, pixels (fy_px: as fx_px). cx_px, cy_px: principal point, pixels (the middle).
    fov_degrees: degrees seen from left to right, where focal lengths are not given.
    metres_per_code: of a stored 1. depth_kind: "planar" or "range", as Camera has it.
    near_m, far_m: planes of a renderer's depth buffer, or nearest and farthest depth where it has no scale; both or neither.
    channel: of an OpenEXR file, dataset: of an HDF5 or .npz file: the name of what is depth.

    Raises MissingFileError (a FileNotFoundError) where there is no such file, Error with Status.INPUT where it cannot be
    read, UsageError (a ValueError) where a setting cannot be. A stream that does not answer is given up after 20 s.
    """
    options = {name: value for name, value in locals().items() if name != "path"}
    settings = ClipSettings()
    call("clip_settings_defaults", settings, settings.struct_size)
    settings.colour = flag("colour", colour)
    if scene_file is not None:
        settings.scene_file = encoded("scene_file", scene_file, "the name of a scene file")
        options["scene_file"] = os.path.abspath(scene_file)
    for name, text in {"preset": preset, "channel": channel, "dataset": dataset}.items():
        if text is not None:
            setattr(settings, name, encoded(name, text, f"the name of a {name}"))
    if depth_kind is not None:
        settings.depth_kind = index_of_kind(depth_kind)
    given = {"fx_px": fx_px, "fy_px": fx_px if fy_px is None else fy_px, "cx_px": cx_px, "cy_px": cy_px,
             "fov_degrees": fov_degrees, "metres_per_code": metres_per_code, "near_m": near_m, "far_m": far_m}
    for name, value in given.items():
        if value is not None:
            setattr(settings, name, _library.number(name, value))
    clip = Clip(path, settings)
    if not clip._is_stream:
        clip._reopening = os.path.abspath(path), options, _stamp(path)
    return clip


def open_array(depth: NDArray[Any], camera: Camera | None = None, **known: Any) -> tuple[Frame, list[str]]:
    """An array as touchable.open reads a file of it, with what is `known`, and its notes. The scene of the Frame is the
    camera's, if one is given, with the coding of depth that was found."""
    if camera is not None:
        of_kind("camera", camera, Camera, "a touchable.Camera beside preset")
        known |= {name: getattr(camera, name) for name in ("fx_px", "fy_px", "cx_px", "cy_px", "depth_kind")}
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "depth.npy")
        numpy.save(path, depth)
        try:
            with open(path, **known) as clip:
                frame = clip[0]
        except Error as problem:
            raise error_of(problem.status, problem.line.replace(path, "the depth picture")) from None
    if camera is not None:
        text = json.loads(Scene.from_camera(camera).text)
        text["depth"] = json.loads(frame.scene.text)["depth"]
        if camera.far_m is not None and text["depth"]["coding"] == "metric":
            text["depth"]["far"] = min(text["depth"]["far"], camera.far_m)
        frame.scene = Scene.from_text(json.dumps(text))
    return frame, clip.notes
