# SPDX-License-Identifier: Apache-2.0
"""Which frames a clip has: the scene's range, or one frame where nothing moves; and their rate."""

from fractions import Fraction

import bpy

MOVING_MODIFIERS = {"BUILD", "CLOTH", "DYNAMIC_PAINT", "EXPLODE", "FLUID", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "OCEAN",
                    "PARTICLE_INSTANCE", "PARTICLE_SYSTEM", "SOFT_BODY", "WAVE"}
MOVING_NODES = ("GeometryNodeInputSceneTime", "GeometryNodeSimulation", "ShaderNodeScript")
FRAME_HANDLERS = ("frame_change_pre", "frame_change_post", "render_pre", "render_init", "depsgraph_update_pre", "depsgraph_update_post")


def rate_of(scene):
    """[frames, seconds], whole numbers: of every `frame_step`th frame, at the speed that the scene has."""
    render = scene.render
    base = Fraction(str(round(render.fps_base, 6))) * scene.frame_step
    rate = Fraction(render.fps) / base
    return [rate.numerator, rate.denominator]


def frames_of(scene, asked):
    """(numbers of the frames, why there is only one or None). `asked`: first and last one, or None for the scene's."""
    if asked:
        return range(asked[0], asked[1] + 1, scene.frame_step), None
    if not what_may_move():
        return range(scene.frame_current, scene.frame_current + 1), f"nothing moves: one frame, {scene.frame_current}"
    return range(scene.frame_start, scene.frame_end + 1, scene.frame_step), None


def what_may_move():
    """What in this file may change from frame to frame, in a few words; None: surely nothing. It errs towards moving."""
    for block in _data_blocks():
        reason = _animation_of(block)
        if reason:
            return f"{reason} '{block.name}'"
    for thing in bpy.data.objects:
        if thing.particle_systems or thing.rigid_body or thing.soft_body:
            return f"the physics of '{thing.name}'"
        for modifier in thing.modifiers:
            if modifier.type in MOVING_MODIFIERS:
                return f"a modifier of '{thing.name}'"
    for image in bpy.data.images:
        if image.source in {"MOVIE", "SEQUENCE"}:
            return f"the film '{image.name}'"
    for tree in _node_trees():
        if any(node.bl_idname.startswith(MOVING_NODES) for node in tree.nodes):
            return f"a node of '{tree.name}'"
    if bpy.data.cache_files or any(scene.rigidbody_world for scene in bpy.data.scenes):
        return "physics or a cache"
    if any(getattr(bpy.app.handlers, name, ()) for name in FRAME_HANDLERS):
        return "a script that follows the frames"
    if any(marker.camera for scene in bpy.data.scenes for marker in scene.timeline_markers):
        return "a marker that changes the camera"
    return None


def _data_blocks():
    """Everything in the file that may be animated and that something uses."""
    for name in dir(bpy.data):
        blocks = getattr(bpy.data, name)
        if isinstance(blocks, bpy.types.bpy_prop_collection):
            for block in blocks:
                if isinstance(block, bpy.types.ID) and block.users and not isinstance(block, bpy.types.WindowManager):
                    yield block
    yield from _node_trees()


def _node_trees():
    """Those of materials, lights, worlds and scenes lie within them, and groups by themselves."""
    yield from bpy.data.node_groups
    for blocks in (bpy.data.materials, bpy.data.lights, bpy.data.worlds, bpy.data.textures, bpy.data.scenes):
        for block in blocks:
            tree = getattr(block, "node_tree", None)
            if tree:
                yield tree


def _animation_of(block):
    animation = getattr(block, "animation_data", None)
    if not animation:
        return None
    if animation.action:
        return "the action of"
    if animation.drivers:
        return "a driver of"
    return "strips of" if animation.nla_tracks else None
