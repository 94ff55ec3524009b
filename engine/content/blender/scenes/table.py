# SPDX-License-Identifier: Apache-2.0
"""Materials on a table: rubber, steel, porcelain, sponge and linen on oak. Lengths are in metres."""

import math

import numpy

import scene_tools as tools

BALL = ((-0.075, 0.035, 0.045), 0.045)  # centre, radius
CAN = ((0.075, 0.055), 0.034, 0.085)  # axis, radius, height
SPONGE = ((0.068, -0.052, 0.0), (0.105, 0.066, 0.034), math.radians(-17))  # centre of its floor, size, turned about z
EGG = ((-0.035, -0.062, 0.0235), (0.032, 0.0235, 0.0235))  # centre, radii
COASTER = ((-0.14, -0.075), 0.042, 0.004)  # axis, radius, height
CAMERA, TARGET, LENS = (0.0, -0.44, 0.36), (-0.01, -0.008, 0.018), 48


def oak():
    made = tools.material("Oak", (0.45, 0.27, 0.13), roughness=0.45, stiffness=1.6, friction=(0.45, 0.35))
    rings = tools.smooth_noise((512, 512), (64, 4), 1) * 0.5 + tools.smooth_noise((512, 512), (150, 6), 2) * 0.3
    waves = tools.smooth_noise((512, 512), (6, 3), 3)
    y = numpy.arange(512)[:, None] / 512
    grain = 0.5 + 0.5 * numpy.sin(2 * math.pi * (14 * y + 2.2 * waves))
    height = numpy.clip(0.25 + 0.45 * grain ** 3 + 0.35 * rings, 0, 1)
    groove = numpy.abs((y * 4) % 1 - 0.5) > 0.485  # between boards
    height = numpy.where(groove, 0.0, height)
    light, dark = numpy.array([0.62, 0.42, 0.24]), numpy.array([0.36, 0.20, 0.09])
    board = numpy.array([0.95, 1.05, 0.88, 1.0])[(((y * 4) + 0.5) % 4).astype(int)]
    colour = (dark + (light - dark) * height[..., None]) * board[..., None]
    tools.texture(made, tools.image("oak", numpy.where(groove[..., None], 0.05, colour), is_colour=True), "Colour", "Base Color", (3, 2))
    node = tools.texture(made, tools.image("oak height", height), "Touch Height", repeat=(3, 2))
    made["touchable_relief"] = 0.0006
    tools.bump(made, node.outputs["Color"], 0.0006)
    return made


def linen():
    made = tools.material("Linen", (0.4, 0.5, 0.6), roughness=0.95, stiffness=0.35, friction=(0.7, 0.55))
    u, v = numpy.meshgrid(numpy.arange(256) / 256 * 16, numpy.arange(256) / 256 * 16)
    over = (numpy.floor(u) + numpy.floor(v)) % 2
    warp, weft = numpy.sin(math.pi * (u % 1)), numpy.sin(math.pi * (v % 1))
    height = numpy.where(over > 0, warp * (0.45 + 0.55 * weft), weft * (0.45 + 0.55 * warp))
    colour = numpy.array([0.42, 0.52, 0.66]) * (0.35 + 0.75 * height[..., None])
    tools.texture(made, tools.image("linen", colour, is_colour=True), "Colour", "Base Color", (2, 2))
    node = tools.texture(made, tools.image("linen height", height), "Touch Height", repeat=(2, 2))
    made["touchable_relief"] = 0.0005
    tools.bump(made, node.outputs["Color"], 0.0005)
    return made


def sponge():
    """Its pores are a texture that Blender computes: colour, light and touch see the same."""
    made = tools.material("Sponge", (0.95, 0.66, 0.16), roughness=0.9, stiffness=0.2, friction=(0.8, 0.7))
    tree = made.node_tree
    cells, ramp, mix = (tree.nodes.new(kind) for kind in ("ShaderNodeTexVoronoi", "ShaderNodeValToRGB", "ShaderNodeMixRGB"))
    place = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(place.outputs["Object"], cells.inputs["Vector"])
    cells.inputs["Scale"].default_value = 130
    ramp.label = "Touch Height"
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.18, 0.42
    ramp.color_ramp.interpolation = "EASE"
    tree.links.new(cells.outputs["Distance"], ramp.inputs["Fac"])
    mix.inputs["Color1"].default_value, mix.inputs["Color2"].default_value = (0.52, 0.25, 0.03, 1), (0.95, 0.62, 0.12, 1)
    tree.links.new(ramp.outputs["Color"], mix.inputs["Fac"])
    tree.links.new(mix.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    made["touchable_relief"] = 0.0012
    tools.bump(made, ramp.outputs["Color"], 0.0012)
    return made


def box_places(size, bevel, steps=5):
    """A box on z = 0 whose upper edges are round: rings from its foot to its top."""
    quarter = numpy.linspace(0, math.pi / 2, steps)
    profile = [(0.0, 0.0)] + [(bevel * (1 - math.cos(a)), size[2] - bevel + bevel * math.sin(a)) for a in quarter]
    rings = []
    for inset, height in profile:
        half = numpy.array([size[0] / 2, size[1] / 2]) - bevel
        corner = []
        for sx, sy, first in ((1, 1, 0.0), (-1, 1, 0.5), (-1, -1, 1.0), (1, -1, 1.5)):
            angle = math.pi * first + numpy.linspace(0, math.pi / 2, 9)
            corner.append(numpy.stack((sx * half[0] + (bevel - inset) * numpy.cos(angle), sy * half[1] + (bevel - inset) * numpy.sin(angle),
                                       height + 0 * angle), axis=-1))
        rings.append(numpy.concatenate(corner))
    rings.append(numpy.broadcast_to((0.0, 0.0, size[2]), rings[0].shape))
    return numpy.stack(rings)


def make():
    tools.empty_scene("materials on a table", (720, 480), 64)
    top = tools.grid_object("Table", numpy.stack(numpy.meshgrid([-0.9, 0.9], [-0.6, 0.9], [0.0]), axis=-1)[:, :, 0], oak())
    top.data.polygons.foreach_set("use_smooth", [False])
    centre, radius = BALL
    tools.grid_object("Ball", tools.sphere_places(centre, (radius,) * 3),
                      tools.material("Rubber", (0.55, 0.03, 0.02), roughness=0.42, stiffness=0.5, friction=(0.95, 0.85)), closed=(False, True))
    (x, y), radius, height = CAN
    profile = numpy.array([(radius, 0.0), (radius, height), (radius, height), (radius - 0.0012, height), (radius - 0.0012, height - 0.003),
                           (0.0, height - 0.003)])
    can = tools.grid_object("Can", tools.turned(profile, 512) + numpy.array([x, y, 0]),
                            tools.material("Steel", (0.78, 0.79, 0.81), roughness=0.22, metallic=1, stiffness=2.0, friction=(0.15, 0.1)),
                            closed=(False, True))
    tools.keep_edges(can, 40)
    place, size, turn = SPONGE
    block = tools.grid_object("Sponge", box_places(size, 0.004), sponge(), closed=(False, True))
    block.location, block.rotation_euler = place, (0, 0, turn)
    tools.keep_edges(block, 50)
    tools.grid_object("Egg", tools.sphere_places(*EGG),
                      tools.material("Porcelain", (0.9, 0.88, 0.84), roughness=0.12, stiffness=1.8, friction=(0.25, 0.18)), closed=(False, True))
    (x, y), radius, height = COASTER
    steps = numpy.stack(numpy.meshgrid(numpy.linspace(-1, 1, 65), numpy.linspace(-1, 1, 65)), axis=-1)
    # A square grid mapped to a disc, so that the weave stays straight.
    disc = steps * numpy.sqrt(1 - steps[..., ::-1] ** 2 / 2) * radius
    rim = numpy.concatenate((disc[0, :-1], disc[:-1, -1], disc[-1, :0:-1], disc[:0:-1, 0]))
    cloth = linen()
    tools.grid_object("Coaster", numpy.concatenate((disc + (x, y), numpy.full((65, 65, 1), height)), axis=-1), cloth)
    tools.grid_object("Coaster's rim", numpy.stack([numpy.column_stack((rim + (x, y), numpy.full(len(rim), z))) for z in (0.0, height)]), cloth,
                      closed=(False, True))
    tools.camera(CAMERA, TARGET, LENS)
    tools.area_light((-0.55, 0.25, 0.75), (0, 0, 0), 0.35, 11, (1.0, 0.9, 0.78))
    tools.area_light((0.7, -0.35, 0.7), (0, 0, 0), 0.9, 4, (0.75, 0.86, 1.0))
    tools.daylight((0.72, 0.8, 1.0), 0.16)
