# SPDX-License-Identifier: Apache-2.0
"""Colour as the artist has set it: their engine, samples, lights, view transform and compositor."""

import ctypes
import os
import sys

import bpy

from . import blender_versions
from .faults import NoRenderer


def prepare(scene, samples):
    """Changes what a clip's pictures need and nothing else; returns remarks for a person. `samples`: None, or instead of theirs."""
    remarks = []
    render = scene.render
    if render.engine in blender_versions.GPU_ENGINES and not _has_opengl():
        remarks.append(f"colour is by Cycles: {render.engine} needs OpenGL, which Blender does not have here without a display")
        render.engine = "CYCLES"
        scene.cycles.device = "CPU"
        scene.cycles.use_denoising = blender_versions.can_denoise()
        samples = samples or 32
    if render.engine == "CYCLES" and scene.cycles.use_denoising and not blender_versions.can_denoise():
        remarks.append("colour is not denoised: this Blender is built without OpenImageDenoise; more samples make it smooth")
        scene.cycles.use_denoising = False
    if samples and render.engine == "CYCLES":
        scene.cycles.samples = samples
    elif samples and render.engine in blender_versions.GPU_ENGINES:
        scene.eevee.taa_render_samples = samples
    if render.use_motion_blur:
        remarks.append("colour has motion blur, and depth has none: it is of each frame's own moment")
    # Write no other files.
    for tree in blender_versions.compositor_trees(scene):
        _mute_files(tree, set())
    blender_versions.write_png(render.image_settings)
    render.use_file_extension = False
    return remarks


def _mute_files(tree, seen):
    """Also those within groups, each of which may be used several times."""
    if tree in seen:
        return
    seen.add(tree)
    for node in tree.nodes:
        if node.type == "OUTPUT_FILE":
            node.mute = True
        elif node.type == "GROUP" and node.node_tree:
            _mute_files(node.node_tree, seen)


def take(scene, path):
    """The scene's current frame as PNG."""
    scene.render.filepath = path
    done = bpy.ops.render.render(write_still=True, scene=scene.name)
    if "FINISHED" not in done or not os.path.exists(path):
        raise NoRenderer(f"{scene.render.engine} did not render the colour of frame {scene.frame_current}")


def _has_opengl():
    """Without it Blender does not fail but ends. In the background it asks EGL under Linux; elsewhere it is there."""
    if not sys.platform.startswith("linux") or not bpy.app.background:
        return True
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    egl.eglGetDisplay.restype = egl.eglGetPlatformDisplay.restype = ctypes.c_void_p
    egl.eglGetDisplay.argtypes = [ctypes.c_void_p]
    egl.eglGetPlatformDisplay.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p]
    egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    surfaceless = 0x31DD  # EGL_PLATFORM_SURFACELESS_MESA
    displays = (egl.eglGetDisplay(None), egl.eglGetPlatformDisplay(surfaceless, None, None))
    return any(display and egl.eglInitialize(display, None, None) for display in displays)
