# SPDX-License-Identifier: Apache-2.0
"""Touchable clips from Blender: an add-on with a panel, and a script for Blender without a window (export.py)."""

bl_info = {
    "name": "Touchable clips",
    "description": "Exports what the camera sees as a clip that can be touched, and says what materials feel like",
    "author": "touchable",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > Touch, Properties > Output and Material > Touch, File > Export",
    "category": "Import-Export",
}


def register():
    from . import panel
    panel.register()


def unregister():
    from . import panel
    panel.unregister()
