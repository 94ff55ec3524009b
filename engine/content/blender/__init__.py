"""Touchable clips from Blender: an add-on, and a script for Blender without a window (export.py)."""
