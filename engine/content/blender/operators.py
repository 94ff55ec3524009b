# SPDX-License-Identifier: Apache-2.0
"""What a person can do: export a clip, touch the current frame, and set what a material feels like."""

import os
import subprocess
import tempfile

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from . import materials, outputs
from .child import Child, unsaved_images
from .faults import Fault


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    touchable: StringProperty(name="touchable", subtype="FILE_PATH",
                              description="The program touchable; empty: where programs are")

    def draw(self, context):
        self.layout.prop(self, "touchable")


def find_touchable(context):
    """The path of the program, or None. A Fault: the one of the preferences is none."""
    addon = context.preferences.addons.get(__package__)
    return outputs.program(bpy.path.abspath(addon.preferences.touchable) if addon else None)


class Exporting:
    """An operator that waits for a `Child` without stopping Blender: Esc cancels."""

    running = None  # the current export, for the panel

    def start(self, context, output, options):
        if Exporting.running:
            self.report({"ERROR"}, "an export is running already; Esc cancels it")
            return {"CANCELLED"}
        for name in unsaved_images():
            self.report({"WARNING"}, f"'{name}' has changes that are not saved (Image > Save), and the export does not see them")
        try:
            touchable = find_touchable(context)
            outputs.check_output(output, touchable, overwrite=True)
            self.final = outputs.final_path(output, touchable)
            self.child = Child(context.scene, output, options + (["--touchable", touchable] if touchable else []))
        except (Fault, OSError, RuntimeError) as fault:
            self.report({"ERROR"}, str(fault))
            return {"CANCELLED"}
        if bpy.app.background:
            while self.child.poll():
                self.child.process.wait()
            return self.finish(context)
        Exporting.running = self.child
        context.window_manager.progress_begin(0, 100)
        self.timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        # Modal operators that began later get Esc first; playback is not modal.
        if event.type == "ESC" and event.value == "PRESS" and not context.screen.is_animation_playing:
            self.child.cancel()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self.child.poll():
            context.window_manager.progress_update(int(100 * self.child.share))
            context.workspace.status_text_set(f"Touchable clip: {self.child.line}   {100 * self.child.share:.0f} %   Esc: Cancel")
            return {"RUNNING_MODAL"} if event.type == "ESC" else {"PASS_THROUGH"}
        Exporting.running = None
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        for area in context.screen.areas:
            area.tag_redraw()
        return self.finish(context)

    def cancel(self, context):
        """Blender's own word: another file is loaded, or the window closes."""
        Exporting.running = None
        self.child.cancel()
        self.child.poll()

    def finish(self, context):
        if self.child.error == "cancelled":
            self.report({"WARNING"}, "the export was cancelled; nothing was written")
            return {"CANCELLED"}
        if self.child.error:
            self.report({"ERROR"}, self.child.error)
            return {"CANCELLED"}
        self.done(context)
        return {"FINISHED"}


class EXPORT_SCENE_OT_touchable(Exporting, bpy.types.Operator, ExportHelper):
    """What the camera sees, as a clip that can be touched"""

    bl_idname = "export_scene.touchable"
    bl_label = "Export Touchable Clip"

    filename_ext = ".mkv"
    filter_glob: StringProperty(default="*.mkv;*.mp4", options={"HIDDEN"})
    frames: EnumProperty(name="Frames", items=(
        ("SCENE", "Scene", "The scene's frame range; one frame where nothing moves"),
        ("CURRENT", "Current", "The current frame alone")))
    colour: BoolProperty(name="Colour", default=True, description="Render colour as the scene is set")
    colour_samples: IntProperty(name="Samples", min=0, default=0, description="Of colour; 0: as the scene has them")

    def check(self, context):
        """The name keeps .mp4 where somebody types that."""
        return False if self.filepath.endswith(outputs.CLIPS) else ExportHelper.check(self, context)

    def execute(self, context):
        options = [] if self.colour else ["--no-colour"]
        if self.colour and self.colour_samples:
            options += ["--colour-samples", str(self.colour_samples)]
        if self.frames == "CURRENT":
            options += ["--frames", str(context.scene.frame_current)]
        return self.start(context, bpy.path.abspath(self.filepath), options)

    def done(self, context):
        if self.final == bpy.path.abspath(self.filepath):
            self.report({"INFO"}, f"wrote {self.final}")
        else:
            self.report({"WARNING"}, f"touchable is not installed, so this is a folder of pictures: {self.final}; where it is: touchable convert")


class TOUCHABLE_OT_touch_it(Exporting, bpy.types.Operator):
    """Exports the current frame and opens it in a window, to be touched with the mouse or a device"""

    bl_idname = "touchable.touch_it"
    bl_label = "Touch It"

    def execute(self, context):
        try:
            self.touchable = find_touchable(context)
        except Fault as fault:
            self.report({"ERROR"}, str(fault))
            return {"CANCELLED"}
        if not self.touchable:
            self.report({"ERROR"}, "the program touchable is not found; install it, or name it in Preferences > Add-ons > Touchable clips")
            return {"CANCELLED"}
        # Blender removes the folder when it ends; touchable keeps the file open.
        self.clip = os.path.join(tempfile.mkdtemp(prefix="touch-it-", dir=bpy.app.tempdir), "touch it.mkv")
        return self.start(context, self.clip, ["--frames", str(context.scene.frame_current)])

    def done(self, context):
        subprocess.Popen([self.touchable, "play", self.clip], stdin=subprocess.DEVNULL, start_new_session=True)
        self.report({"INFO"}, "touchable opens the current frame")


def material_of(context):
    """The one that the material properties show, elsewhere that of the active object; None: there is none."""
    shown = getattr(context, "material", None)
    return shown or (context.object.active_material if context.object else None)


class OfMaterial:
    """An operator that changes the material at hand."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return material_of(context) is not None


class MATERIAL_OT_touchable_set(OfMaterial, bpy.types.Operator):
    """Sets stiffness and friction of this material by hand, beginning with the guess"""

    bl_idname = "material.touchable_set"
    bl_label = "Set by Hand"

    def execute(self, context):
        feel = materials.feel_of(material_of(context), 1.0)
        for key, value in zip((materials.STIFFNESS, materials.STATIC, materials.DYNAMIC), feel.values()):
            set_number(material_of(context), key, value)
        return {"FINISHED"}


class MATERIAL_OT_touchable_guess(OfMaterial, bpy.types.Operator):
    """Removes what was set by hand"""

    bl_idname = "material.touchable_guess"
    bl_label = "Guess Again"

    def execute(self, context):
        material = material_of(context)
        for key in (materials.STIFFNESS, materials.STATIC, materials.DYNAMIC):
            if key in material:
                del material[key]
        return {"FINISHED"}


class MATERIAL_OT_touchable_texture(OfMaterial, bpy.types.Operator):
    """Adds an Image Texture node, labelled so that the exporter finds it. Any other node with that label will do as well"""

    bl_idname = "material.touchable_texture"
    bl_label = "Add Texture"

    label: StringProperty(options={"HIDDEN"})

    def execute(self, context):
        material = material_of(context)
        material.use_nodes = True
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.label = node.name = self.label
        node.location = (-600, -300 if self.label == materials.HEIGHT_NODE else -600)
        if self.label == materials.HEIGHT_NODE and materials.RELIEF not in material:
            set_number(material, materials.RELIEF, 0.001)
        return {"FINISHED"}


def set_number(material, key, value):
    """A custom property with a range and words for a person."""
    words = {materials.STIFFNESS: "How hard it is, in N/mm: 0.2 is foam, 0.6 rubber, 2 and more are wood and metal",
             materials.STATIC: "Friction of a finger that rests: 0.1 is ice, 0.4 paper, 1 rubber",
             materials.DYNAMIC: "Friction of a finger that slides, at most the static one",
             materials.RELIEF: "Metres by which white of the height texture is above black"}
    material[key] = float(value)
    least, most = materials.LIMITS[key]
    soft = {materials.STIFFNESS: 10.0, materials.RELIEF: 0.1}.get(key, 1.0)
    material.id_properties_ui(key).update(min=least, max=most, soft_min=least, soft_max=soft, description=words[key],
                                          precision=4 if key == materials.RELIEF else 2)


CLASSES = (Preferences, EXPORT_SCENE_OT_touchable, TOUCHABLE_OT_touch_it, MATERIAL_OT_touchable_set, MATERIAL_OT_touchable_guess,
           MATERIAL_OT_touchable_texture)
