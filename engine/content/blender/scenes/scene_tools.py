# SPDX-License-Identifier: Apache-2.0
"""What the three scenes have in common: meshes from functions, materials that say what they feel like, a camera, lights."""

import math

import bpy
import numpy
from mathutils import Vector


def empty_scene(name, size, samples):
    """Blender's scene without its cube, rendered by Cycles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.name = name
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 4
    scene.cycles.sample_clamp_indirect = 2
    scene.view_settings.view_transform = "Filmic"
    scene.view_settings.look = "Medium High Contrast"
    return scene


def mesh_object(name, vertices, faces, material, smooth=True):
    """`vertices`: n x 3; `faces`: m x 4 or m x 3 indices."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(numpy.asarray(vertices).tolist(), [], numpy.asarray(faces).tolist())
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def grid_object(name, places, material, closed=(False, False), uv=True):
    """Of a grid of places, rows x columns x 3: `closed` where the last row, or column, joins the first. UV goes from 0 to 1 along both."""
    rows, columns = places.shape[:2]
    index = numpy.arange(rows * columns).reshape(rows, columns)
    down = numpy.vstack((index, index[:1])) if closed[0] else index
    whole = numpy.hstack((down, down[:, :1])) if closed[1] else down
    faces = numpy.stack((whole[:-1, :-1], whole[:-1, 1:], whole[1:, 1:], whole[1:, :-1]), axis=-1).reshape(-1, 4)
    thing = mesh_object(name, places.reshape(-1, 3), faces, material)
    if uv:
        v, u = numpy.meshgrid(numpy.linspace(0, 1, whole.shape[0]), numpy.linspace(0, 1, whole.shape[1]), indexing="ij")
        corners = [numpy.stack((u[a], v[a]), axis=-1) for a in (
            (slice(None, -1), slice(None, -1)), (slice(None, -1), slice(1, None)), (slice(1, None), slice(1, None)), (slice(1, None), slice(None, -1)))]
        thing.data.uv_layers.new(name="UVMap").data.foreach_set("uv", numpy.stack(corners, axis=2).reshape(-1).tolist())
    return thing


def keep_edges(thing, degrees):
    """Light shows edges sharper than that, and rounds the others. 4.1 keeps it in the edges."""
    mesh = thing.data
    if hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth, mesh.auto_smooth_angle = True, math.radians(degrees)
    else:
        mesh.set_sharp_from_angle(angle=math.radians(degrees))


def turned(profile, segments):
    """The places of a body of revolution about z: `profile` is n x 2, radius and height."""
    angle = numpy.linspace(0, 2 * math.pi, segments, endpoint=False)
    radius, height = profile[:, :1], profile[:, 1:]
    return numpy.stack((radius * numpy.cos(angle), radius * numpy.sin(angle), height + 0 * angle), axis=-1)


def sphere_places(centre, radii, rows=256, columns=512):
    latitude = numpy.linspace(-math.pi / 2, math.pi / 2, rows)
    places = turned(numpy.stack((numpy.cos(latitude), numpy.sin(latitude)), axis=-1), columns)
    return places * numpy.asarray(radii) + numpy.asarray(centre)


def material(name, colour, *, roughness=0.5, metallic=0.0, stiffness, friction, subsurface=0.0):
    """`friction`: static and dynamic."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    made["touchable_stiffness"] = stiffness
    made["touchable_static_friction"], made["touchable_dynamic_friction"] = friction
    return made


def image(name, samples, is_colour=False):
    """Packed into the file: rows from the bottom, grey or RGB, 0 to 1. What is no colour is exact in floats."""
    height, width = samples.shape[:2]
    made = bpy.data.images.new(name, width, height, alpha=False, float_buffer=False, is_data=not is_colour)
    pixels = numpy.ones((height, width, 4), numpy.float32)
    pixels[..., :3] = samples if samples.ndim == 3 else samples[..., None]
    made.pixels.foreach_set(pixels.ravel())
    made.update()
    made.pack()
    return made


def texture(made, picture, label, socket=None, repeat=None):
    """An Image Texture node; `repeat`: how often along u and v; `socket`: an input of the shader."""
    tree = made.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.label = picture, label
    if repeat:
        place, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
        mapping.inputs["Scale"].default_value = (*repeat, 1)
        tree.links.new(place.outputs["UV"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])
    if socket:
        tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs[socket])
    return node


def bump(made, socket, distance):
    """Light sees heights too: metres between black and white."""
    tree = made.node_tree
    node = tree.nodes.new("ShaderNodeBump")
    node.inputs["Distance"].default_value = distance
    tree.links.new(socket, node.inputs["Height"])
    tree.links.new(node.outputs["Normal"], tree.nodes["Principled BSDF"].inputs["Normal"])


def camera(place, target, lens):
    seen = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    seen.data.lens = lens
    seen.data.clip_start = 0.01
    seen.location = place
    seen.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(seen)
    bpy.context.scene.camera = seen
    return seen


def area_light(place, target, size, watts, colour=(1, 1, 1)):
    light = bpy.data.objects.new("Area", bpy.data.lights.new("Area", "AREA"))
    light.data.size, light.data.energy, light.data.color = size, watts, colour
    light.location = place
    light.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(light)


def daylight(colour, strength):
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*colour, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = strength
    bpy.context.scene.world = world


def smooth_noise(shape, cells, seed):
    """0 to 1, periodic: a lattice of random values, `cells` rows and columns, between which it is a smooth curve."""
    lattice = numpy.random.default_rng(seed).random(cells)

    def weights(count, length):
        at = numpy.arange(length) * count / length
        whole = at.astype(int)
        part = at - whole
        return whole % count, (whole + 1) % count, part * part * (3 - 2 * part)

    top, bottom, down = weights(cells[0], shape[0])
    left, right, across = weights(cells[1], shape[1])
    rows = lattice[top] * (1 - down)[:, None] + lattice[bottom] * down[:, None]
    return rows[:, left] * (1 - across) + rows[:, right] * across
