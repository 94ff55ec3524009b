# SPDX-License-Identifier: Apache-2.0
"""Depth as the filters of `touchable` leave it: smooth and steady, with normals and how wrong they may be."""

from __future__ import annotations

import itertools
import json
import weakref
from typing import TYPE_CHECKING, Any, Iterable, NamedTuple

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _planes
from ._library import FilteredStruct, call
from ._scene import Camera, Scene, scene_of
from ._surface import Surface, meaning_of

if TYPE_CHECKING:
    from ._clip import Clip, Frame

_warm_up_frames = 16  # as the program: frames before a first one from which a filter that remembers begins


class Filtered(NamedTuple):
    """A depth picture as filters leave it. NaN where there is no surface; holes stay, unless a filter fills them.

    metres: (height, width) float32, along -Z, or along the pixel's ray where the scene's depth_kind is "range".
    normals: (height, width, 3) float32, of length 1, towards the camera; X right, Y up, the camera looks along -Z.
    error_degrees: (height, width) float32: about 95 of 100 normals are off by less, as far as pictures show it.
    """

    metres: NDArray[numpy.float32]
    normals: NDArray[numpy.float32]
    error_degrees: NDArray[numpy.float32]


class Filter:
    """Filters for a live loop: a picture in, a picture out.

        smooth = touchable.Filter(camera, first)            # first: up to 16 pictures, by which filters are chosen
        while True:
            metres = smooth(read_depth())                   # (height, width) float32, NaN where there is no surface
            smooth.normals                                  # of the same picture, where they are wanted

    scene: the Scene with the filters that were chosen; before the first picture None, where `first` was not given.
    """

    def __init__(self, camera: Camera | Scene, first: Iterable[Any] = (), *, threads: int = 1,
                 error_bars: bool = False) -> None:
        """camera: what the pictures mean. Filters that a Scene states stay; others are chosen.
        first: pictures of this camera, one after the other, as Surface.push takes them; 16 tell noise from relief best. They
            are not filtered. Without any, filters are chosen by the first picture alone, which shows no flicker.
        threads: that filter a picture, 1 to 16. error_bars: measure error_degrees, too.

        Raises UsageError as Surface does.
        """
        self.scene: Scene | None = None
        self._camera, self._settings = camera, {"threads": threads, "error_bars": error_bars, "frames": 1}
        self._epoch = 0
        if pictures := list(itertools.islice(first, 16)):
            self._begin(pictures)

    def __call__(self, picture: Any) -> NDArray[numpy.float32]:
        """Depth of the next picture as the filters leave it: metres, (height, width) float32. `picture`: a Frame, a depth array,
        or a dict or tuple of planes, as Surface.push takes them. Raises UsageError as Surface.push does."""
        if self.scene is None:
            self._begin([picture])
        self._surface._push(picture, None)
        return self._of("metres")

    def restart(self) -> None:
        """The next picture does not follow the last one: nothing is remembered of it, as after a gap or a cut."""
        if self.scene is not None:
            self._epoch += 1
            self._surface.begin_epoch(self._epoch)

    @property
    def normals(self) -> NDArray[numpy.float32]:
        """Of the newest picture: (height, width, 3) float32, as Filtered has them. Raises UsageError before the first."""
        return self._of("normals")

    @property
    def error_degrees(self) -> NDArray[numpy.float32]:
        """Of the newest picture: (height, width) float32, as Filtered has them. Raises UsageError before the first, and without
        error_bars."""
        return self._of("error_degrees")

    def _begin(self, pictures: list[Any]) -> None:
        scene = scene_of(meaning_of(self._camera, pictures))
        self.scene = scene.with_filters(pictures) if scene.has_unstated_filters else scene
        self._surface = Surface(camera=self.scene, **self._settings)

    def _of(self, name: str) -> NDArray[numpy.float32]:
        if self.scene is None:
            raise _planes.refuse("no picture was filtered yet")
        shape = (self.scene.height, self.scene.width) + ((3,) if name == "normals" else ())
        floats = numpy.empty(shape, numpy.float32)
        struct = FilteredStruct(**{name + "_stride_bytes": floats.strides[0]})
        setattr(struct, name, floats.ctypes.data)
        call("surface_filtered", self._surface._handle.number, struct)
        return floats


def filtered(depth: ArrayLike | Frame, camera: Camera | Scene | None = None) -> Filtered:
    """One depth picture as the filters leave it that the program would choose for it: metres, (height, width) float32, and what
    Filtered has. `depth`, `camera`: as Surface takes them; filters of a Scene that it states stay. For
    pictures one after the other, a Filter or frame.filtered_metres does better: it averages. Raises UsageError as Surface does."""
    if camera is None and hasattr(depth, "scene"):
        camera = depth.scene
    one = Filter(camera, [depth], error_bars=True)
    return Filtered(one(depth), one.normals, one.error_degrees)


class ClipFilter:
    """Filters the frames of a clip, each as the program does that plays it from the first one that was asked for."""

    def __init__(self, clip: Clip) -> None:
        self._clip = weakref.ref(clip)
        self._filter: Filter | None = None
        self._last: int | None = None

    def of(self, frame: Frame) -> Filtered:
        clip = self._clip()
        if clip is None or clip.closed:
            raise _planes.refuse("the clip of this frame was closed; ask a frame for its filtered depth before that")
        if self._filter is None:
            scene = clip.touched_scene
            self._filter = Filter(scene, error_bars=True)
            self._remembers = json.loads(scene.text)["filter"]["temporal"] == "on"
        first = max(0, frame.number - _warm_up_frames) if self._remembers and not clip._is_stream else frame.number
        if self._last is not None and first - 1 <= self._last < frame.number:
            first = self._last + 1
        else:
            self._filter.restart()
        self._last = None  # unknown if a call fails
        for number in range(first, frame.number):
            self._filter(clip.read(number))
        one = Filtered(self._filter(frame), self._filter.normals, self._filter.error_degrees)
        self._last = frame.number
        return one
