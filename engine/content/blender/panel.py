"""Where a person finds it: Properties > Output, Properties > Material, File > Export."""

import bpy

from . import blender_versions, materials, operators


class OUTPUT_PT_touchable(bpy.types.Panel):
    bl_label = "Touch"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "output"

    def draw(self, context):
        layout = self.layout
        running = operators.Exporting.running
        if running:
            layout.label(text=f"{running.line} ({100 * running.share:.0f} %)", icon="TIME")
            layout.label(text="Esc cancels")
            return
        layout.operator(operators.TOUCHABLE_OT_touch_it.bl_idname, icon="VIEW_PAN")
        layout.operator(operators.EXPORT_SCENE_OT_touchable.bl_idname, text="Export Clip...", icon="EXPORT")
        if blender_versions.untested_version():
            layout.label(text="Not run with this Blender yet", icon="INFO")


class MATERIAL_PT_touchable(bpy.types.Panel):
    bl_label = "Touch"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    NAMES = ((materials.STIFFNESS, "Stiffness (N/mm)"), (materials.STATIC, "Static Friction"), (materials.DYNAMIC, "Dynamic Friction"))

    @classmethod
    def poll(cls, context):
        return context.material is not None

    def draw(self, context):
        layout, material = self.layout, context.material
        layout.use_property_split = True
        self._draw_numbers(layout, material, materials.feel_of(material, context.scene.unit_settings.scale_length))
        self._draw_texture(layout, material, materials.HAPTIC_NODE, "Haptic Texture")
        self._draw_texture(layout, material, materials.HEIGHT_NODE, "Height Texture")
        if materials.RELIEF in material:
            layout.prop(material, f'["{materials.RELIEF}"]', text="Relief (m)")

    def _draw_numbers(self, layout, material, feel):
        is_set = False
        for (key, name), value in zip(self.NAMES, feel.values()):
            if key in material:
                is_set = True
                layout.prop(material, f'["{key}"]', text=name)
            else:
                layout.label(text=f"{name}: {value:g}, guessed")
        if is_set:
            layout.operator(operators.MATERIAL_OT_touchable_guess.bl_idname)
        else:
            layout.operator(operators.MATERIAL_OT_touchable_set.bl_idname)

    def _draw_texture(self, layout, material, label, name):
        node = materials.labelled_node(material, label)
        if node is None:
            layout.operator(operators.MATERIAL_OT_touchable_texture.bl_idname, text=f"Add {name}", icon="TEXTURE").label = label
        elif node.type == "TEX_IMAGE":
            layout.label(text=f"{name}: node '{label}'")
            layout.template_ID(node, "image", new="image.new", open="image.open")
        else:
            layout.label(text=f"{name}: node '{label}' ({node.bl_label})")


def draw_export(menu, context):
    menu.layout.operator(operators.EXPORT_SCENE_OT_touchable.bl_idname, text="Touchable Clip (.mkv)")


CLASSES = (*operators.CLASSES, OUTPUT_PT_touchable, MATERIAL_PT_touchable)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.TOPBAR_MT_file_export.append(draw_export)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(draw_export)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
