# SPDX-License-Identifier: Apache-2.0
# The one file for calls that changed since Blender 3.4. Those of 5.0 follow Blender's documentation and have not been run.
"""Calls that differ between Blender 3.4 and today's."""

import bpy

RUN_WITH = ((3, 4, 1), (4, 3, 2))

# Passes of a multilayer OpenEXR, by all names that they have had.
DEPTH_NAMES = ("Depth.Z", "Depth.V")
INDEX_NAMES = ("IndexMA.X", "Material Index.X", "Material Index.V", "IndexMA.V")
VALUE_NAMES = ("X", "V")

GPU_ENGINES = {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT", "BLENDER_WORKBENCH"}


def untested_version():
    """Words for a Blender that this was not run with; otherwise None."""
    if bpy.app.version[:2] in {version[:2] for version in RUN_WITH}:
        return None
    return f"this is Blender {bpy.app.version_string}; the exporter was run with {', '.join('.'.join(map(str, version)) for version in RUN_WITH)} only"


def principled_input(node, name):
    """An input of a Principled BSDF by its name in 3.4: 4.0 gave some of them others. None: it has no such input."""
    newer = {"Subsurface": "Subsurface Weight", "Transmission": "Transmission Weight"}
    return node.inputs.get(name) or node.inputs.get(newer.get(name, ""))


def name_aov_node(node, name):
    """4.1 calls `aov_name` what was the node's name."""
    if hasattr(node, "aov_name"):
        node.aov_name = name
    else:
        node.name = name


def is_displaced(material):
    """Whether a displacement moves the geometry itself: the setting was one of Cycles', and is the material's since 4.1."""
    if hasattr(material, "displacement_method"):
        return material.displacement_method != "BUMP"
    return material.cycles.displacement_method != "BUMP"


def node_tree_of(material):
    """5.0 has no materials without nodes any more, and says so where `use_nodes` is asked for."""
    if bpy.app.version < (5, 0, 0) and not material.use_nodes:
        return None
    return material.node_tree


def add_group_output(group, name, kind="NodeSocketFloat"):
    """What a group of nodes gives, a number; its name. 4.0 keeps sockets in the group's interface."""
    if hasattr(group, "interface"):
        return group.interface.new_socket(name=name, in_out="OUTPUT", socket_type=kind).name
    return group.outputs.new(kind, name).name


def compositor_trees(scene):
    """`node_tree` was the scene's own until 5.0, which has groups instead."""
    tree = getattr(scene, "compositing_node_group", None) or getattr(scene, "node_tree", None)
    return [tree] if tree else []


def has_strips(scene):
    """Of the video sequencer: 5.0 calls `strips_all` what were sequences."""
    editor = scene.sequence_editor
    return bool(editor and getattr(editor, "strips_all", None) or getattr(editor, "sequences_all", None))


def write_multilayer_floats(image_settings):
    """Every pass into one OpenEXR of 32-bit floats without compression. 5.0 first asks which kind of file it is."""
    if hasattr(image_settings, "media_type"):
        image_settings.media_type = "MULTI_LAYER_IMAGE"
    image_settings.file_format = "OPEN_EXR_MULTILAYER"
    image_settings.color_depth = "32"
    image_settings.exr_codec = "NONE"
    if hasattr(image_settings, "use_exr_interleave"):
        image_settings.use_exr_interleave = True


def write_png(image_settings):
    """RGB of 8 bits, by the scene's own view transform."""
    if hasattr(image_settings, "media_type"):
        image_settings.media_type = "IMAGE"
    image_settings.file_format = "PNG"
    image_settings.color_mode = "RGB"
    image_settings.color_depth = "8"
    image_settings.compression = 15
    if hasattr(image_settings, "color_management"):
        image_settings.color_management = "FOLLOW_SCENE"


def can_denoise():
    """Whether Cycles was built with OpenImageDenoise: without it, as Debian's, a scene that asks for it is not rendered at all."""
    try:
        import _cycles
    except ImportError:
        return True
    return bool(getattr(_cycles, "with_openimagedenoise", True))


def set_where_it_is(owner, **values):
    """Sets those properties that this version has."""
    for name, value in values.items():
        if hasattr(owner, name):
            setattr(owner, name, value)
