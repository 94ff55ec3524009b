# SPDX-License-Identifier: Apache-2.0
"""Touch depth pictures and depth video, read and write them exactly: numpy arrays in, numpy arrays out.

    import touchable

    for frame in touchable.open("recording.bag"):      # any file that the program `touchable` opens
        frame.depth, frame.metres, frame.colour        # uint16 codes, float32 metres, uint8 RGB

    frame.filtered_metres, frame.normals               # smooth and steady; of arrays: touchable.Filter

    touchable.write("out.mkv", frames, camera=touchable.Camera(640, 480, fx_px=525))

    surface = touchable.Surface(depth, camera)
    surface.forces_at(points).force_n                         # points: (..., 3), each as of a finger alone; newtons
    touched = surface.touch(path)                             # path: (ticks, 3), a tick for each millisecond
    touched.force_n                                           # (ticks, fingers, 3), newtons
    touchable.plot(touched, "forces.png")

Units: lengths are metres or scene units, as each name says; forces newtons; times nanoseconds or seconds. Axes: X right,
Y up, the camera at the origin looks along -Z. What the library refuses is a touchable.Error, which says in one line what
is wrong and what would be right. Files need libtouchable-media and FFmpeg; surfaces and solvers only libtouchable.
"""

from ._clip import Clip, Frame, open
from ._filtering import Filter, Filtered, filtered
from ._library import version as _version
from ._plotting import plot
from ._scene import Camera, Scene
from ._surface import Surface
from ._touch import ForcesAt, Guard, Solver, SolverSettings, Touched, touch
from ._writing import write
from .errors import ClosedError, Error, ExistingFileError, MissingFileError, Status, UsageError

__version__: str = _version()
__all__ = [
    "Camera", "Clip", "ClosedError", "Error", "ExistingFileError", "Filter", "Filtered", "ForcesAt", "Frame", "Guard",
    "MissingFileError", "Scene", "Solver", "SolverSettings", "Status", "Surface", "Touched", "UsageError", "filtered", "open", "plot",
    "touch", "write",
]
