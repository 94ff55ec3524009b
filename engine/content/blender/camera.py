# SPDX-License-Identifier: Apache-2.0
"""Blender's camera as the scene file has it: focal lengths and principal point in pixels, whose centres are whole numbers."""

from dataclasses import dataclass

from .faults import Refused


@dataclass(frozen=True)
class Camera:
    """Row 0 is the upper one."""

    fx: float
    fy: float
    cx: float
    cy: float


def picture_size(scene):
    """Width and height of the rendered picture, in pixels."""
    render = scene.render
    share = render.resolution_percentage
    return render.resolution_x * share // 100, render.resolution_y * share // 100


def camera_of(scene):
    """As it is at the scene's current frame. Refused: none, or one whose rays do not meet in a point."""
    seen = scene.camera
    if seen is None or seen.type != "CAMERA":
        raise Refused("the scene has no camera; add one (Shift A > Camera) and make it the active one (Ctrl Numpad 0)")
    lens = seen.data
    if lens.type == "PANO":
        raise Refused(f"camera '{seen.name}' is a panorama, whose pixels are no flat grid; make it Perspective (Camera properties > Lens > Type)")
    if lens.type != "PERSP":
        raise Refused(f"camera '{seen.name}' is orthographic, and rays of a touchable clip meet in a point; "
                      "make it Perspective, far away with a long focal length")
    return _pinhole(scene.render, picture_size(scene), lens)


def _pinhole(render, size, lens):
    width, height = size
    tall = render.pixel_aspect_y / render.pixel_aspect_x  # height of a pixel, in pixel widths
    fit = lens.sensor_fit
    if fit == "AUTO":
        is_wide = render.pixel_aspect_x * width >= render.pixel_aspect_y * height
        sensor = lens.sensor_width
    else:
        is_wide = fit == "HORIZONTAL"
        sensor = lens.sensor_width if is_wide else lens.sensor_height
    fitted = width if is_wide else tall * height  # pixel widths across the sensor, and of a shift of 1
    fx = lens.lens * fitted / sensor
    return Camera(fx, fx / tall, (width - 1) / 2 - lens.shift_x * fitted, (height - 1) / 2 + lens.shift_y * fitted / tall)
