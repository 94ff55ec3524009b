# SPDX-License-Identifier: Apache-2.0
"""Writes the three scenes: blender -b --factory-startup -P make_scenes.py -- FOLDER [NAME...]"""

import importlib
import os
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy

NAMES = ("table", "face", "bowl")


def main():
    folder, *names = sys.argv[sys.argv.index("--") + 1:]
    for name in names or NAMES:
        importlib.import_module(name).make()
        bpy.context.preferences.filepaths.save_version = 0  # no .blend1 beside it
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(os.path.abspath(folder), f"{name}.blend"), compress=True)


if __name__ == "__main__":
    main()
