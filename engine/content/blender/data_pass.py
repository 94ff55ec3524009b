# SPDX-License-Identifier: Apache-2.0
"""Depth, material and factors of each pixel, all of them from one and the same sample at the pixel's centre.

It is one render by Cycles on the CPU. A pixel's surface is the first one that is at least half opaque (opacity.py). Textures of haptics and
of heights are plugged into shader AOVs, so that Cycles reads them as it reads an artist's colours. It adds the AOVs of all surfaces
that a ray passes on its way; so those that are transparent there say nothing, and a mark counts who did.
"""

import math
import os
from dataclasses import dataclass

import bpy
import numpy

from . import blender_versions, opacity, pictures
from .faults import NoRenderer

HAPTIC, HEIGHT, HAPTIC_MARK, HEIGHT_MARK = "touchable haptic", "touchable height", "touchable haptics", "touchable heights"
BACKGROUND = 1e9  # Cycles writes 1e10 where there is no surface
MOST_MATERIALS = 32766


@dataclass
class Sample:
    """What a frame's pixels show, as arrays of rows from the top."""

    depth: numpy.ndarray  # Blender's units along the axis; infinity: no surface
    material: numpy.ndarray  # 1 is the first one; 0: none
    haptic: numpy.ndarray  # factors of stiffness, static and dynamic friction; 1 where no texture varies them
    height: numpy.ndarray  # factor of the relief; 0 where there is none
    doubtful: int  # pixels where several surfaces have haptic values or heights
    broken: int  # pixels where a texture is NaN or infinite


def prepare(scene, materials, feels):
    """Sets the scene up for the data, for good: it is not saved. `feels`: of each material, with the sockets that any frame needs."""
    if len(materials) > MOST_MATERIALS:
        raise NoRenderer(f"the file has {len(materials)} materials, and Blender numbers {MOST_MATERIALS} of them")
    _set_renderer(scene)
    for layer in scene.view_layers:
        if layer.use:
            _set_layer(layer)
    cutter = opacity.Cutter()
    for number, (material, feel) in enumerate(zip(materials, feels), 1):
        material.pass_index = number
        is_surface = cutter.cut(material)
        if feel.haptic_socket:
            _plug(material, feel.haptic_socket, is_surface, HAPTIC, HAPTIC_MARK)
        if feel.height_socket:
            _plug(material, feel.height_socket, is_surface, HEIGHT, HEIGHT_MARK)


def _set_renderer(scene):
    render = scene.render
    try:
        render.engine = "CYCLES"
    except TypeError:
        raise NoRenderer("this Blender has no Cycles, by which depth is rendered; enable it (Preferences > Add-ons > Cycles)") from None
    render.use_compositing = render.use_freestyle = False
    render.use_motion_blur = render.use_multiview = False
    for thing in bpy.data.cameras:
        thing.dof.use_dof = False
    # 3.4 sends a pixel's first ray through its middle. The narrow filter ensures this in every version.
    blender_versions.set_where_it_is(
        scene.cycles, device="CPU", samples=1, use_adaptive_sampling=False, use_denoising=False, time_limit=0.0,
        pixel_filter_type="BLACKMAN_HARRIS", filter_width=0.01, use_auto_tile=False, shading_system=False,
        max_bounces=0, diffuse_bounces=0, glossy_bounces=0, transmission_bounces=0, volume_bounces=0,
        transparent_max_bounces=max(scene.cycles.transparent_max_bounces, 128), use_sample_subset=False)
    blender_versions.write_multilayer_floats(render.image_settings)


def _set_layer(layer):
    for settings in (layer, getattr(layer, "cycles", None)):
        for name in dir(settings):
            if name.startswith("use_pass_"):
                setattr(settings, name, False)
    layer.use_pass_combined = layer.use_pass_z = layer.use_pass_material_index = True
    layer.pass_alpha_threshold = opacity.HALF
    layer.samples = 0
    layer.material_override = None
    blender_versions.set_where_it_is(layer.cycles, use_denoising=False, denoising_store_passes=False)
    for name, kind in ((HAPTIC, "COLOR"), (HEIGHT, "VALUE"), (HAPTIC_MARK, "VALUE"), (HEIGHT_MARK, "VALUE")):
        aov = layer.aovs.add()
        aov.name, aov.type = name, kind


def _plug(material, socket, is_surface, name, mark):
    """A socket of the material's nodes to an AOV, and 1 to the mark: both times 0 where it is no surface."""
    tree = blender_versions.node_tree_of(material)
    if is_surface is not None:
        product = tree.nodes.new("ShaderNodeVectorMath")
        product.operation = "MULTIPLY"
        tree.links.new(socket, product.inputs[0])
        tree.links.new(is_surface, product.inputs[1])
        socket = product.outputs[0]
    value, count = (tree.nodes.new("ShaderNodeOutputAOV") for _ in range(2))
    blender_versions.name_aov_node(value, name)
    blender_versions.name_aov_node(count, mark)
    tree.links.new(socket, value.inputs[0 if name == HAPTIC else 1])
    if is_surface is None:
        count.inputs[1].default_value = 1
    else:
        tree.links.new(is_surface, count.inputs[1])


def take(scene, folder):
    """The scene's current frame, rendered by way of a file in `folder`."""
    path = os.path.join(folder, "data.exr")
    scene.render.filepath = path
    scene.render.use_file_extension = False
    if "FINISHED" not in bpy.ops.render.render(write_still=True, scene=scene.name):
        raise NoRenderer(f"Cycles did not finish frame {scene.frame_current}")
    planes = pictures.read_exr(path)
    os.remove(path)
    layers = [layer.name for layer in scene.view_layers if layer.use]
    return _nearest([_sample_of(planes, layer) for layer in layers])


def _plane(planes, layer, names):
    for name in names:
        if f"{layer}.{name}" in planes:
            return planes[f"{layer}.{name}"]
    raise NoRenderer(f"Cycles wrote no pass {names[0]} of the view layer '{layer}'; it wrote {', '.join(sorted(planes))}")


def _value(planes, layer, name):
    return _plane(planes, layer, [f"{name}.{channel}" for channel in blender_versions.VALUE_NAMES])


def _sample_of(planes, layer):
    depth = _plane(planes, layer, blender_versions.DEPTH_NAMES)
    is_surface = (depth > 0) & (depth < BACKGROUND)
    material = numpy.rint(_plane(planes, layer, blender_versions.INDEX_NAMES)).astype(numpy.int32)
    haptic = numpy.stack([_plane(planes, layer, [f"{HAPTIC}.{channel}"]) for channel in "RGB"], axis=-1)
    haptics, heights = (numpy.rint(_value(planes, layer, mark)) for mark in (HAPTIC_MARK, HEIGHT_MARK))
    haptic = numpy.where((haptics == 1)[..., None], haptic, numpy.float32(1))
    height = numpy.where(heights == 1, _value(planes, layer, HEIGHT), numpy.float32(0))
    is_broken = ~(numpy.isfinite(haptic).all(axis=-1) & numpy.isfinite(height))
    # NaN counts as if there were no texture.
    return Sample(numpy.where(is_surface, depth, math.inf).astype(numpy.float32), numpy.where(is_surface, material, 0),
                  numpy.nan_to_num(haptic, nan=1, posinf=1, neginf=0), numpy.nan_to_num(height, nan=0, posinf=1, neginf=0),
                  int(numpy.count_nonzero(is_surface & ((haptics > 1) | (heights > 1)))),
                  int(numpy.count_nonzero(is_surface & is_broken)))


def _nearest(samples):
    """Of several view layers, in each pixel the surface that is nearest."""
    nearest = samples[0]
    for other in samples[1:]:
        is_nearer = other.depth < nearest.depth
        nearest = Sample(numpy.where(is_nearer, other.depth, nearest.depth),
                         numpy.where(is_nearer, other.material, nearest.material),
                         numpy.where(is_nearer[..., None], other.haptic, nearest.haptic),
                         numpy.where(is_nearer, other.height, nearest.height),
                         nearest.doubtful + other.doubtful, nearest.broken + other.broken)
    return nearest
