# SPDX-License-Identifier: Apache-2.0
"""Where a person finds it: the viewport's sidebar, Properties > Output, Properties > Material, File > Export."""

import textwrap

import bpy

from . import blender_versions, materials, operators


NAMES = ((materials.STIFFNESS, "Stiffness (N/mm)"), (materials.STATIC, "Static Friction"), (materials.DYNAMIC, "Dynamic Friction"))


def draw_exporting(layout):
    running = operators.Exporting.running
    if running:
        layout.label(text=f"{running.line} ({100 * running.share:.0f} %)", icon="TIME")
        layout.label(text="Esc cancels")
        return
    layout.operator(operators.TOUCHABLE_OT_touch_it.bl_idname, icon="VIEW_PAN")
    layout.operator(operators.EXPORT_SCENE_OT_touchable.bl_idname, text="Export Clip...", icon="EXPORT")
    if blender_versions.untested_version():
        layout.label(text="Not run with this Blender yet", icon="INFO")


def draw_material(layout, material):
    is_set, feel = False, materials.feel_of(material, materials.metres_per_unit_of(bpy.context.scene))
    for (key, name), value in zip(NAMES, feel.values()):
        if key in material:
            is_set = True
            layout.prop(material, f'["{key}"]', text=name)
        else:
            layout.label(text=f"{name}: {value:g}, guessed")
    kind = operators.MATERIAL_OT_touchable_guess if is_set else operators.MATERIAL_OT_touchable_set
    layout.operator(kind.bl_idname)
    draw_texture(layout, material, materials.HAPTIC_NODE, "Haptic Texture")
    draw_texture(layout, material, materials.HEIGHT_NODE, "Height Texture")
    if materials.RELIEF in material:
        layout.prop(material, f'["{materials.RELIEF}"]', text="Relief (m)")
    elif "relief" in feel.guessed:
        layout.label(text=f"Relief (m): {feel.relief:.4g}, guessed")
    for remark in feel.remarks:
        for number, line in enumerate(textwrap.wrap(remark, 32)):
            layout.label(text=line, icon="BLANK1" if number else "ERROR")


def draw_texture(layout, material, label, name):
    node = materials.labelled_node(material, label)
    if node is None:
        layout.operator(operators.MATERIAL_OT_touchable_texture.bl_idname, text=f"Add {name}", icon="TEXTURE").label = label
    elif node.type == "TEX_IMAGE":
        layout.label(text=f"{name}:")
        layout.template_ID(node, "image", new="image.new", open="image.open")
    else:
        layout.label(text=f"{name}: {node.bl_label} '{label}'")


class OUTPUT_PT_touchable(bpy.types.Panel):
    bl_label = "Touch"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "output"

    def draw(self, context):
        draw_exporting(self.layout)


class MATERIAL_PT_touchable(bpy.types.Panel):
    bl_label = "Touch"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return context.material is not None

    def draw(self, context):
        draw_material(self.layout, context.material)


class VIEW3D_PT_touchable(bpy.types.Panel):
    """Both, at hand: the sidebar's tab (N)."""

    bl_label = "Touch"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Touch"

    def draw(self, context):
        draw_exporting(self.layout)
        material = operators.material_of(context)
        if material:
            box = self.layout.box()
            box.label(text=material.name, icon="MATERIAL")
            draw_material(box, material)


def draw_export(menu, context):
    menu.layout.operator(operators.EXPORT_SCENE_OT_touchable.bl_idname, text="Touchable Clip (.mkv)")


CLASSES = (*operators.CLASSES, OUTPUT_PT_touchable, MATERIAL_PT_touchable, VIEW3D_PT_touchable)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.TOPBAR_MT_file_export.append(draw_export)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(draw_export)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
