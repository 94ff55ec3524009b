# SPDX-License-Identifier: Apache-2.0
# Renders the seeds tests/fuzz/seeds/exr_layers/*.exr, which were made by Blender 3.4.1:
#     blender -b --factory-startup -P render_seeds.py -- FOLDER
# A camera looks down at a floor 10 away, of material 2 on the right and 0 on the left; a box of material 5 stands
# on its upper left, with its face 8 away. Beyond the floor there is nothing. Materials shine by themselves, so that
# colours are known.
import sys

import bpy

folder = sys.argv[sys.argv.index("--") + 1]
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
scene = bpy.context.scene


def shining(name, index, colour):
    material = bpy.data.materials.new(name)
    material.pass_index = index
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*colour, 1)
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def box(left, bottom, right, top, face, material):
    bpy.ops.mesh.primitive_cube_add(size=1)
    made = bpy.context.object
    made.location = ((left + right) / 2, (bottom + top) / 2, face - 0.5)
    made.scale = (right - left, top - bottom, 1)
    made.data.materials.append(material)


box(-3.5, -2.5, 0, 2.5, 0, shining("left", 0, (0.5, 0.25, 0.125)))
box(0, -2.5, 3.5, 2.5, 0, shining("right", 2, (0, 0, 4)))
box(-2.4, 0.1, -0.2, 1.8, 2, shining("box", 5, (1, 0.0625, 0)))
bpy.ops.object.camera_add(location=(0, 0, 10))
scene.camera = bpy.context.object
scene.camera.data.sensor_width = 36
scene.camera.data.lens = 45  # 8 units are seen at 10
scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0

scene.render.engine = "CYCLES"
scene.cycles.samples = 1
scene.cycles.use_denoising = False
scene.cycles.pixel_filter_type = "BOX"
scene.cycles.filter_width = 0.01
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 16, 12, 100
for stamp in ("date", "time", "render_time", "frame", "camera", "scene", "filename", "memory", "hostname"):
    setattr(scene.render, "use_stamp_" + stamp, False)
image = scene.render.image_settings
image.exr_codec = "ZIP"
layer = bpy.context.view_layer
layer.use_pass_z = True


def render(name, multilayer, bits):
    image.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    image.color_depth = bits
    if not multilayer:
        image.use_zbuffer = True
    scene.render.filepath = folder + "/" + name
    bpy.ops.render.render(write_still=True)


render("z_half", False, "16")
layer.use_pass_material_index = True
layer.use_pass_normal = True
layer.use_pass_mist = True
render("layers_half", True, "16")
layer.use_pass_normal = layer.use_pass_mist = False
render("layers_float", True, "32")
layer.name = "b"
first = scene.view_layers.new("a")
first.use_pass_z = first.use_pass_combined = False
first.use_pass_normal = True
render("two_layers", True, "16")
