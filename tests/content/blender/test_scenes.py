# SPDX-License-Identifier: Apache-2.0
"""Scenes whose surface the tests know in closed form: blender -P test_scenes.py -P export.py -- ..., $SCENE being one's name."""

import math
import os
import sys

import bpy
import numpy

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../engine/content/blender/scenes"))

import scene_tools as tools


def rectangle(name, corners, material=None):
    """Two triangles; UV 0 to 1 from the first corner to the third."""
    places = numpy.array([[corners[0], corners[1]], [corners[3], corners[2]]], float)
    thing = tools.grid_object(name, places, material or tools.material(name, (0.5, 0.5, 0.5), stiffness=0.7, friction=(0.5, 0.4)))
    thing.data.polygons.foreach_set("use_smooth", [False])
    return thing


def begin(size=(360, 240), lens=50):
    scene = tools.empty_scene("test", size, 1)
    tools.camera((0, 0, 0), (0, 0, -1), lens).rotation_euler = (0, 0, 0)
    return scene


def plane():
    """Depth = 4 / (1 + 0.3 u + 0.2 v) metres at the ray (u, v, -1). Blender's units are centimetres, pixels are not square, and the lens is
    shifted, fitted to the height, out of focus and behind glass."""
    scene = begin()
    scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", 0.01
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 721, 481, 50
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = 1.0, 1.25
    lens = scene.camera.data
    lens.sensor_fit, lens.sensor_height, lens.shift_x, lens.shift_y = "VERTICAL", 24, 0.11, -0.07
    lens.dof.use_dof, lens.dof.aperture_fstop, lens.clip_end = True, 0.1, 1e5
    scene.camera.location, scene.camera.rotation_euler, scene.camera.scale = (120, -30, 55), (0.7, 0.2, -1.1), (2, 2, 2)
    bpy.context.view_layer.update()
    world = scene.camera.matrix_world.normalized()
    corners = []
    for u, v in ((-1.2, -1.2), (1.2, -1.2), (1.2, 1.2), (-1.2, 1.2)):
        depth = 400 / (1 + 0.3 * u + 0.2 * v)
        corners.append(world @ tools.Vector((depth * u, depth * v, -depth)))
    rectangle("Plane", corners)
    glass = tools.material("Glass", (1, 1, 1), stiffness=3, friction=(0.1, 0.1))
    glass.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.4
    rectangle("Window", [world @ tools.Vector((100 * u, 100 * v, -100)) for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))], glass)


def sphere():
    """At 5 m, of radius 1, before a wall at 8 m. Of its facets only the front."""
    begin((720, 480), 60)
    angle = numpy.linspace(-math.pi / 2, math.pi / 2, 461)
    places = numpy.stack((numpy.cos(angle)[:, None] * numpy.sin(angle)[None, :], numpy.sin(angle)[:, None] + 0 * angle[None, :],
                          numpy.cos(angle)[:, None] * numpy.cos(angle)[None, :] - 5), axis=-1)
    tools.grid_object("Sphere", places, tools.material("Ball", (0.5, 0.5, 0.5), stiffness=1, friction=(0, 0)), uv=False)
    rectangle("Wall", [(x, y, -8) for x, y in ((-9, -9), (9, -9), (9, 9), (-9, 9))])


def textures():
    """A wall at 2 m, 1.28 m high and wide about the axis: heights of a ramp of 8 texels along u, factors of haptics of texels along v. Before
    its left half hangs a leaf that a mask cuts out of a rectangle: at 1.5 m, opaque below, with an inverted Bump node of half a centimetre."""
    begin((256, 256), 36)
    made = tools.material("Wall", (0.5, 0.5, 0.5), stiffness=2, friction=(0.8, 0.4))
    ramp = numpy.tile(numpy.array([0, 51, 102, 153, 204, 255, 51, 0]) / 255, (4, 1))
    tools.texture(made, tools.image("ramp", ramp), "Touch Height")
    made["touchable_relief"] = 0.01
    factors = numpy.zeros((4, 1, 3))
    factors[:, 0] = numpy.array([(255, 0, 255), (0, 255, 51), (102, 153, 204), (255, 255, 255)]) / 255
    tools.texture(made, tools.image("factors", factors), "Touch Haptic").interpolation = "Closest"
    half = 0.64
    rectangle("Wall", [(x, y, -2) for x, y in ((-half, -half), (half, -half), (half, half), (-half, half))], made)
    leaf = tools.material("Leaf", (0.1, 0.5, 0.1), stiffness=0.3, friction=(0.6, 0.6))
    grey = tools.texture(leaf, tools.image("grey", numpy.full((2, 2), 153 / 255)), "Grey")
    tools.bump(leaf, grey.outputs["Color"], 0.01)
    bump = leaf.node_tree.nodes["Bump"]
    bump.invert, bump.inputs["Strength"].default_value = True, 0.5
    mask = numpy.array([[1.0], [0.3]])  # the lower half is there
    node = tools.texture(leaf, tools.image("mask", mask), "Mask")
    node.interpolation = "Closest"
    leaf.node_tree.links.new(node.outputs["Color"], leaf.node_tree.nodes["Principled BSDF"].inputs["Alpha"])
    rectangle("Leaf", [(x, y, -1.5) for x, y in ((-0.4, -0.4), (0, -0.4), (0, 0.4), (-0.4, 0.4))], leaf)


def moving():
    """A camera that draws back from a wall by 0.25 m a frame, and a stiffness that grows with it: frames 3, 5 and 7 of 30 / 1.001 a second."""
    scene = begin((64, 48))
    scene.frame_start, scene.frame_end, scene.frame_step = 3, 7, 2
    scene.render.fps, scene.render.fps_base = 30, 1.001
    made = tools.material("Wall", (0.5, 0.5, 0.5), stiffness=1, friction=(0.5, 0.4))
    rectangle("Wall", [(x, y, -3) for x, y in ((-9, -9), (9, -9), (9, 9), (-9, 9))], made)
    for frame in range(1, 8):
        scene.camera.location = (0, 0, 0.25 * frame)
        scene.camera.keyframe_insert("location", frame=frame)
        made["touchable_stiffness"] = 0.1 * frame
        made.keyframe_insert('["touchable_stiffness"]', frame=frame)
    bpy.data.objects.new("Hidden empty", None)


def ordinary():
    """Blender's own scene as it is when Blender starts, with a metal ball and an object without a material."""
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.engine, scene.cycles.samples = 360, 240, "CYCLES", 1
    made = bpy.data.materials.new("Chrome")
    made.use_nodes = True
    made.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1
    made.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.1
    bpy.ops.mesh.primitive_uv_sphere_add(location=(0, 2.5, 0))
    bpy.context.object.data.materials.append(made)
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))


def table():
    import table as scene
    scene.make()


globals()[os.environ["SCENE"]]()
