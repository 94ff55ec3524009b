# SPDX-License-Identifier: Apache-2.0
"""A glass marble that rolls round in a wooden bowl, twice in two seconds. Lengths are in metres."""

import math

import bpy
import numpy
from mathutils import Quaternion, Vector

import scene_tools as tools

FRAMES, RATE, TURNS = 24, 12, 2
INNER = 0.095  # radius of the sphere of the bowl's inside
MARBLE = 0.021
TILT = math.asin(3.5 * MARBLE / INNER)  # from the bowl's axis to the marble, so that it rolls seven times in two rounds
SEGMENTS = 384


def bowl_profile():
    """Radius and height, from the middle of the inside over the rim to the foot."""
    inside = numpy.linspace(0.0, math.radians(78), 90)
    inner = numpy.stack((INNER * numpy.sin(inside), INNER * (1 - numpy.cos(inside))), axis=-1)
    edge, wall = inner[-1], 0.0075
    around = numpy.linspace(math.pi, 0, 14)[1:]
    rim = numpy.stack((edge[0] + wall / 2 + wall / 2 * numpy.cos(around), edge[1] + wall / 2 * numpy.sin(around)), axis=-1)
    outside = numpy.linspace(0, 1, 60)[1:, None]
    belly = rim[-1] + (numpy.array([0.036, -0.012]) - rim[-1]) * numpy.hstack((outside ** 1.9, outside))
    return numpy.concatenate((inner, rim, belly))


def cherry():
    made = tools.material("Cherry wood", (0.4, 0.16, 0.06), roughness=0.32, stiffness=1.4, friction=(0.4, 0.3))
    y = numpy.arange(512)[:, None] / 512
    waves = tools.smooth_noise((512, 512), (5, 5), 21)
    fine = tools.smooth_noise((512, 512), (128, 24), 22)
    grain = 0.5 + 0.5 * numpy.sin(2 * math.pi * (9 * y + 1.6 * waves))
    height = numpy.clip(0.55 * grain ** 2 + 0.4 * fine, 0, 1)
    colour = numpy.array([0.20, 0.085, 0.035]) + numpy.array([0.34, 0.18, 0.085]) * height[..., None]
    tools.texture(made, tools.image("cherry", colour, is_colour=True), "Colour", "Base Color")
    node = tools.texture(made, tools.image("cherry height", height), "Touch Height")
    made["touchable_relief"] = 0.0003
    tools.bump(made, node.outputs["Color"], 0.0003)
    return made


def swirl():
    """The marble: two colours round a helix, so that one sees it roll."""
    made = tools.material("Glass", (0.05, 0.2, 0.6), roughness=0.06, stiffness=2.0, friction=(0.2, 0.15))
    v, u = numpy.meshgrid(numpy.arange(256) / 256, numpy.arange(512) / 512, indexing="ij")
    bands = 0.5 + 0.5 * numpy.sin(2 * math.pi * (3 * u + 1.5 * v + 0.15 * tools.smooth_noise((256, 512), (6, 8), 31)))
    share = numpy.clip((bands - 0.45) * 6, 0, 1)[..., None]
    colour = numpy.array([0.01, 0.06, 0.28]) * (1 - share) + numpy.array([0.75, 0.82, 0.9]) * share
    tools.texture(made, tools.image("swirl", colour, is_colour=True), "Colour", "Base Color")
    return made


def marble_place(frame):
    """Its centre, and how it has turned, at a frame: it rolls without sliding."""
    angle = 2 * math.pi * TURNS * (frame - 1) / FRAMES
    reach = INNER - MARBLE
    centre = Vector((reach * math.sin(TILT) * math.cos(angle), reach * math.sin(TILT) * math.sin(angle), INNER - reach * math.cos(TILT)))
    # The point of contact is at rest: the marble turns with its path, and round an axis along the slope.
    rolled = Quaternion((math.cos(TILT), 0, math.sin(TILT)), -angle * math.sin(TILT) * INNER / MARBLE)
    return centre, Quaternion((0, 0, 1), angle) @ rolled


def make():
    scene = tools.empty_scene("a marble in a bowl", (720, 480), 12)
    scene.cycles.max_bounces = 2
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.fps, scene.render.fps_base = RATE, 1.0
    tools.grid_object("Bowl", tools.turned(bowl_profile(), SEGMENTS), cherry(), closed=(False, True)).location = (0, 0, 0.012)
    marble = tools.grid_object("Marble", tools.sphere_places((0, 0, 0), (MARBLE,) * 3, 128, 256), swirl(), closed=(False, True))
    marble.rotation_mode = "QUATERNION"
    for frame in range(1, FRAMES + 2):
        centre, turn = marble_place(frame)
        marble.location, marble.rotation_quaternion = centre + Vector((0, 0, 0.012)), turn
        marble.keyframe_insert("location", frame=frame)
        marble.keyframe_insert("rotation_quaternion", frame=frame)
    cloth = tools.material("Cloth", (0.62, 0.58, 0.5), roughness=0.95, stiffness=0.4, friction=(0.7, 0.6))
    ground = tools.grid_object("Table", numpy.stack(numpy.meshgrid([-0.6, 0.6], [-0.6, 0.6], [0.0]), axis=-1)[:, :, 0], cloth)
    ground.data.polygons.foreach_set("use_smooth", [False])
    tools.camera((0, -0.24, 0.40), (0, 0.004, 0.038), 47)
    tools.area_light((-0.4, 0.25, 0.5), (0, 0, 0.03), 0.3, 8, (1.0, 0.92, 0.8))
    tools.area_light((0.45, -0.3, 0.5), (0, 0, 0.03), 0.6, 2.5, (0.75, 0.86, 1.0))
    tools.daylight((0.75, 0.83, 1.0), 0.2)
