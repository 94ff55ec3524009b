# SPDX-License-Identifier: Apache-2.0
"""scene.json of the folder of pictures that an export makes. Lengths are in metres."""

import json
import math
import os

DEPTH, COLOUR, HAPTIC, HEIGHT = "depth", "colour", "haptic", "height"
MOST_REMARKS, MOST_REMARK = 100, 2000  # number of a scene file's remarks, and bytes of each


def picture_name(plane, number):
    """Of a picture in the folder, from 0."""
    return f"{plane}_{number:06d}.{'exr' if plane == DEPTH else 'png'}"


def planes_between(nearest, farthest):
    """Near and far that hold both, outward to a ten-thousandth of what lies between them."""
    between = max(farthest - nearest, 2e-3 * farthest)  # at least so much for a wall seen from the front
    grain = 10.0 ** (math.floor(math.log10(between)) - 4)
    middle = (nearest + farthest) / 2
    near = math.floor(min(nearest, middle - between / 2) / grain) * grain
    far = math.ceil(max(farthest, middle + between / 2) / grain) * grain
    return float(f"{near if near > 0 else nearest:.9g}"), float(f"{far:.9g}")


def depth_unit(far):
    """Metres that 1 in a depth picture stands for: the power of ten by which `far` is from 6554 to 65535. A scene file's near and far have to
    be depths of whole numbers up to 65535, which they are then, of whatever size the scene is."""
    return 10.0 ** math.ceil(math.log10(far / 65535))


def write_scene(folder, *, name, size, rate, camera, near, far, unit, ranges, has_colour, remarks):
    """`near`, `far` and `unit`, that of the depth pictures, in metres."""
    scene = {
        "touchable_scene": 1,
        "name": _utf8(name).decode(),
        "remarks": [_cut(remark) for remark in remarks],
        "width": size[0],
        "height": size[1],
        "rate": rate,
        "metres_per_unit": 1,
        "camera": {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy},
        "depth": {"coding": "metric", "scale": unit, "near": near, "far": far},
        "filter": {"median": 0, "temporal": "off"},  # depth without noise: what varies from pixel to pixel is relief
        "haptic": {key: [limits.least, limits.most] for key, limits in (
            ("stiffness", ranges.stiffness), ("static_friction", ranges.static_friction),
            ("dynamic_friction", ranges.dynamic_friction))},
        "folder": {plane: f"{plane}_%06d.{'exr' if plane == DEPTH else 'png'}" for plane in (DEPTH, HAPTIC)},
    }
    if has_colour:
        scene["folder"][COLOUR] = f"{COLOUR}_%06d.png"
    if ranges.height > 0:
        scene["height_map"] = {"max": ranges.height, "units": "world", "bits": 16}
        scene["folder"][HEIGHT] = f"{HEIGHT}_%06d.png"
    with open(os.path.join(folder, "scene.json"), "w", encoding="utf-8") as file:
        json.dump(scene, file, indent=2)
        file.write("\n")


def _cut(text):
    return _utf8(text)[:MOST_REMARK].decode("utf-8", "ignore")


def _utf8(text):
    """A file's name may be of bytes that are no UTF-8, which Python has as halves of characters."""
    return text.encode("utf-8", "replace")
