# SPDX-License-Identifier: Apache-2.0
"""An export from its first look at the scene to the finished clip. It changes the file in memory, and that is not saved."""

import math
import os
from dataclasses import dataclass, replace

import bpy
import numpy

from . import blender_versions, colour_pass, data_pass, motion, pictures, scene_file
from .camera import camera_of, picture_size
from .faults import BadUsage, Refused
from .materials import feel_of, guessed_line, materials_in_use, metres_per_unit_of
from .planes import haptic_codes, height_codes, ranges_of

LEAST_SIDE, MOST_SIDE = 4, 16384  # pixels of a clip; Blender renders none smaller
MOST_RATE = 1000  # frames a second of a clip
MOST_FRAMES = 1_000_000  # the names of pictures have six digits


@dataclass
class Wish:
    """What was asked for."""

    frames: tuple = None  # first, last
    size: tuple = None
    near: float = None  # metres
    far: float = None
    colour: bool = True
    colour_samples: int = None


class Export:
    """`say` takes lines for a person; `work` is an empty folder, in which everything is made."""

    def __init__(self, wish, work, say):
        self.wish, self.work, self.say = wish, work, say
        self.scene = bpy.context.scene
        self.remarks = []
        self.metres_per_unit = metres_per_unit_of(self.scene)

    def run(self):
        """Makes the pictures in `work`; what is missing then is the clip."""
        if blender_versions.untested_version():
            self.say(blender_versions.untested_version())
        if not any(layer.use for layer in self.scene.view_layers):
            raise Refused("no view layer is rendered, and Blender would crash; turn Use for Rendering on (View Layer properties)")
        self._choose_pixels()
        self.rate = motion.rate_of(self.scene)
        self.frames, why_one = motion.frames_of(self.scene, self.wish.frames)
        if not self.frames:
            raise BadUsage(f"there are no frames from {self.scene.frame_start} to {self.scene.frame_end}; the last frame must not be before the first")
        if len(self.frames) > MOST_FRAMES:
            raise BadUsage(f"these are {len(self.frames)} frames, and a clip has at most {MOST_FRAMES}; use fewer of them (--frames A-B)")
        if len(self.frames) > 1 and self.rate[0] > MOST_RATE * self.rate[1]:
            raise Refused(f"the scene has {self.rate[0] / self.rate[1]:g} frames a second, and a clip at most {MOST_RATE}; "
                          "lower its frame rate (Output properties)")
        if why_one:
            self.say(why_one)
        self.materials = materials_in_use()
        self._look_at_frames()
        if self.wish.colour:
            self._render_colour()
        self._render_data()
        self._write_scene()

    def _choose_pixels(self):
        """The same ones for colour and data: all that the camera sees."""
        render = self.scene.render
        if self.wish.size:
            render.resolution_x, render.resolution_y = self.wish.size
            render.resolution_percentage = 100
        if render.use_multiview:
            raise Refused("the scene is rendered in stereo, and a clip is of one camera; turn Stereoscopy off (Output properties)")
        width, height = picture_size(self.scene)
        if not all(LEAST_SIDE <= side <= MOST_SIDE for side in (width, height)):
            raise Refused(f"the scene's pictures are of {width}x{height} pixels, and a clip's have {LEAST_SIDE} to {MOST_SIDE} a side; "
                          "change the resolution (Output properties), or use --size")
        if render.use_sequencer and blender_versions.has_strips(self.scene):
            self.remarks.append("the strips of the video sequencer are left out: they are not what the camera sees")
        render.use_sequencer = render.use_border = False

    def _look_at_frames(self):
        """Camera, and what materials feel like, at each frame: before anything is rendered."""
        self.camera, self.feels = None, {}
        for frame in self.frames:
            self.scene.frame_set(frame)
            camera = camera_of(self.scene)
            if self.camera and not _is_nearly(camera, self.camera):
                raise Refused(f"the camera's lens changes at frame {frame} (focal length, shift or sensor), and a clip has one lens; "
                              "move the camera instead of zooming")
            self.camera = self.camera or camera
            # Material 0 is for objects without a material.
            self.feels[frame] = [feel_of(material, self.metres_per_unit) for material in (None, *self.materials)]
        self.ranges = ranges_of([feel for feels in self.feels.values() for feel in feels])

    def _render_colour(self):
        self.remarks += colour_pass.prepare(self.scene, self.wish.colour_samples)
        for number, frame in enumerate(self.frames):
            self._progress("colour", number)
            self.scene.frame_set(frame)
            colour_pass.take(self.scene, self._picture(scene_file.COLOUR, number))

    def _render_data(self):
        # An animated relief may be absent at the first frame.
        feels = [max(self._over_time(number), key=lambda feel: feel.height_socket is not None) for number in range(1, len(self.materials) + 1)]
        data_pass.prepare(self.scene, self.materials, feels)
        self.nearest, self.farthest, self.seen, doubtful = math.inf, 0.0, set(), 0
        self.is_cut, broken = False, 0
        for number, frame in enumerate(self.frames):
            self._progress("depth", number)
            self.scene.frame_set(frame)
            sample = data_pass.take(self.scene, self.work)
            self._write_planes(number, sample, self.feels[frame])
            doubtful += sample.doubtful
            broken += sample.broken
        if doubtful:
            self.remarks.append(f"{doubtful} pixels show a haptic texture through others that are transparent; they have the material's values without it")
        if broken:
            self.remarks.append(f"{broken} pixels have a Touch Haptic or Touch Height that is no number or infinite; where it is no number, the material's "
                                "values count without it")

    def _write_planes(self, number, sample, feels):
        metres = sample.depth.astype(numpy.float64) * self.metres_per_unit
        near, far = self.wish.near or 0.0, self.wish.far or math.inf
        is_beyond = numpy.isfinite(metres) & ((metres < near) | (metres > far))
        self.is_cut = self.is_cut or bool(is_beyond.any())
        metres[is_beyond] = math.inf
        is_surface = numpy.isfinite(metres)
        if is_surface.any():
            self.nearest = min(self.nearest, float(metres[is_surface].min()))
            self.farthest = max(self.farthest, float(metres[is_surface].max()))
            self.seen.update(int(material) for material in numpy.unique(sample.material[is_surface]))
        numpy.save(self._metres(number), metres.astype(numpy.float32))
        pictures.write_png(self._picture(scene_file.HAPTIC, number), haptic_codes(sample, feels, self.ranges))
        if self.ranges.height > 0:
            pictures.write_png(self._picture(scene_file.HEIGHT, number), height_codes(sample, feels, self.ranges))

    def _write_scene(self):
        if not self.seen and self.is_cut:
            raise Refused("all surfaces that the camera sees are nearer than --near or farther than --far, so there is nothing to touch; "
                          "give distances in metres that hold some of them")
        if not self.seen:
            raise Refused("the camera sees no surface in any frame, so there is nothing to touch; look through it (Numpad 0) and move it")
        near, far = scene_file.planes_between(self.nearest, self.farthest)
        near, far = self.wish.near or near, self.wish.far or far
        if self.ranges.height > near / 2:
            deepest = max((feel for feels in self.feels.values() for feel in feels), key=lambda feel: abs(feel.relief))
            told = (f"the relief of '{deepest.name}' is {self.ranges.height:g} m deep, and the nearest surface is {near:g} m away; "
                    "make its touchable_relief less than half of that")
            if "relief" not in deepest.guessed:
                raise Refused(told)
            self.ranges = replace(self.ranges, height=near / 2)
            self.remarks.append(f"{told}: the guess, and all relief with it, is felt at {near / 2 / abs(deepest.relief):.2g} of its depth")
        self._write_depths(scene_file.depth_unit(far))
        of_materials = [self._over_time(material) for material in sorted(self.seen)]
        # A remark that recurs with other numbers is given once.
        for feels in of_materials:
            self.remarks += next((feel.remarks for feel in feels if feel.remarks), [])
        self.remarks = _at_most(self.remarks, scene_file.MOST_REMARKS - 1)
        guessed = guessed_line([max(feels, key=lambda feel: len(feel.guessed)) for feels in of_materials])
        if guessed:
            self.remarks.append(guessed)
        for remark in self.remarks:
            self.say(remark)
        scene_file.write_scene(
            self.work, name=os.path.splitext(bpy.path.basename(bpy.data.filepath))[0] or self.scene.name,
            size=picture_size(self.scene), rate=self.rate, camera=self.camera, near=near, far=far,
            unit=scene_file.depth_unit(far), ranges=self.ranges, has_colour=self.wish.colour, remarks=self.remarks)

    def _over_time(self, material):
        """What it feels like, frame by frame."""
        return [self.feels[frame][material] for frame in self.frames]

    def _write_depths(self, unit):
        """Once it is known in which unit they are."""
        for number in range(len(self.frames)):
            metres = numpy.load(self._metres(number)).astype(numpy.float64)
            pictures.write_float_exr(self._picture(scene_file.DEPTH, number), (metres / unit).astype(numpy.float32))
            os.remove(self._metres(number))

    def _metres(self, number):
        return os.path.join(self.work, f"metres_{number:06d}.npy")

    def _picture(self, plane, number):
        return os.path.join(self.work, scene_file.picture_name(plane, number))

    def _progress(self, what, number):
        self.say(f"{what} {number + 1} of {len(self.frames)}")


def _at_most(remarks, most):
    """The first ones; the rest are one line."""
    return remarks if len(remarks) <= most else [*remarks[:most - 1], f"and {len(remarks) - most + 1} more"]


def _is_nearly(camera, other):
    return all(abs(a - b) <= 1e-4 for a, b in zip((camera.fx, camera.fy, camera.cx, camera.cy),
                                                  (other.fx, other.fy, other.cx, other.cy)))
