# SPDX-License-Identifier: Apache-2.0
"""A face on a bronze medal, modelled as one function of the place. Lengths are in metres."""

import math

import numpy

import scene_tools as tools

RADIUS = 0.1
ROWS = 640


def bell(x, y, cx, cy, wx, wy, turn=0.0):
    """1 at its centre."""
    c, s = math.cos(turn), math.sin(turn)
    u, v = (x - cx) * c + (y - cy) * s, -(x - cx) * s + (y - cy) * c
    return numpy.exp(-(u / wx) ** 2 - (v / wy) ** 2)


def smooth(edge0, edge1, value):
    t = numpy.clip((value - edge0) / (edge1 - edge0), 0, 1)
    return t * t * t * (t * (6 * t - 15) + 10)


def melt(a, b, width):
    """The greater of two, round where they meet."""
    return 0.5 * (a + b + numpy.sqrt((a - b) ** 2 + width ** 2))


def face_height(x, y):
    """x to the right, y up, the medal's radius being 1; the height in the same unit."""
    side = numpy.abs(x)
    # The head: an egg, narrower at the chin.
    width = 0.50 - 0.13 * smooth(0.0, -0.75, y) - 0.03 * smooth(0.25, 0.7, y)
    egg = 1 - (x / width) ** 2 * 0.92 - ((y - 0.02) / 0.74) ** 2
    head = 0.34 * numpy.sqrt(numpy.maximum(egg, 0)) ** 0.9
    h = head
    h -= 0.075 * bell(side, y, 0.185, 0.135, 0.115, 0.075)  # sockets
    h += 0.032 * bell(side, y, 0.19, 0.245, 0.16, 0.040, -0.12)  # brows
    h += 0.020 * bell(side, y, 0.235, -0.10, 0.11, 0.12)  # cheeks
    h += 0.030 * bell(x, y, 0, 0.42, 0.30, 0.18)  # forehead
    # The nose: a ridge that rises to its tip, and its wings.
    along = numpy.clip((0.20 - y) / 0.36, 0, 1)
    ridge = (0.025 + 0.115 * along ** 1.4) * smooth(-0.235, -0.165, y) * smooth(0.30, 0.14, y)
    h += ridge * numpy.exp(-(x / (0.034 + 0.034 * along)) ** 2)
    h += 0.045 * bell(side, y, 0.062, -0.165, 0.036, 0.036)
    h -= 0.030 * bell(side, y, 0.036, -0.208, 0.020, 0.013)  # nostrils
    h -= 0.012 * bell(x, y, 0, -0.26, 0.020, 0.035)  # philtrum
    # Lips, a little apart in the line between them.
    bow = -0.338 + 0.012 * numpy.cos(side * 26) * numpy.exp(-(side / 0.10) ** 2)
    inside = smooth(0.185, 0.10, side)
    h += 0.044 * inside * numpy.exp(-((y - bow - 0.026) / 0.026) ** 2)
    h += 0.056 * smooth(0.165, 0.06, side) * numpy.exp(-((y - bow + 0.036) / 0.032) ** 2)
    h -= 0.038 * inside * numpy.exp(-((y - bow + 0.002) / 0.0085) ** 2)
    h -= 0.014 * bell(side, y, 0.185, -0.345, 0.022, 0.026)
    h -= 0.022 * bell(x, y, 0, -0.445, 0.12, 0.028)
    h += 0.050 * bell(x, y, 0, -0.555, 0.105, 0.075)  # chin
    # Eyes as statues have them: balls, with an edge below and a crease above.
    ex, ey = (side - 0.185) / 0.105, (y - 0.120) / 0.062
    lid = numpy.sqrt(numpy.maximum(1 - ex ** 2 - ey ** 2, 0))
    h += 0.058 * lid ** 0.8
    lash = 0.092 + 0.035 * ((side - 0.185) / 0.1) ** 2
    open_eye = smooth(0.108, 0.085, numpy.abs(side - 0.187))
    h -= 0.016 * open_eye * numpy.exp(-((y - lash) / 0.0075) ** 2)
    h += 0.010 * open_eye * numpy.exp(-((y - lash - 0.017) / 0.010) ** 2)
    crease = 0.168 - 0.045 * ((side - 0.185) / 0.1) ** 2
    h -= 0.010 * smooth(0.12, 0.08, numpy.abs(side - 0.187)) * numpy.exp(-((y - crease) / 0.009) ** 2)
    # Brow hairs: short strokes.
    brow = bell(side, y, 0.195, 0.248, 0.12, 0.020, -0.12)
    h += 0.002 * brow * numpy.sin(120 * (side + 0.6 * y))
    return h, head


def hair_height(x, y):
    """Waves of hair around the face."""
    side = numpy.abs(x)
    radius = numpy.sqrt((x / 0.66) ** 2 + ((y - 0.10) / 0.80) ** 2)
    body = 0.235 * numpy.sqrt(numpy.maximum(1 - radius ** 4, 0))
    parting = numpy.sqrt(side ** 2 + (0.78 - y) ** 2)
    strand = numpy.sin(46 * numpy.arctan2(side + 0.02, 0.95 - y) + 5.5 * numpy.sin(7.5 * parting + 0.8))
    fine = numpy.sin(150 * numpy.arctan2(side + 0.02, 0.95 - y) + 16 * numpy.sin(7.5 * parting + 0.8))
    ridges = 0.020 * (1 - numpy.abs(strand) ** 1.5) + 0.004 * fine
    return body + ridges * smooth(1.0, 0.86, radius), radius


def height(x, y):
    """Of the whole medal."""
    r = numpy.sqrt(x * x + y * y)
    face, head = face_height(x, y)
    hair, hair_radius = hair_height(x, y)
    # The hairline: hair lies over the forehead and before the ears.
    line = 0.47 - 0.55 * numpy.abs(x) ** 1.6
    covered = smooth(-0.02, 0.03, y - line)
    hair = hair * smooth(-0.42, -0.05, y)  # it ends behind the cheeks
    behind = hair - 0.12 * (1 - covered) * smooth(0.0, 0.12, head)
    bust = melt(face * smooth(0.0, 0.02, head), behind + 0.02 * covered * smooth(0.0, 0.12, head), 0.010)
    ground = 0.012 * smooth(0.2, 0.9, r)  # slightly hollow
    body = melt(ground, numpy.where(hair_radius < 1, bust, face) * smooth(1.0, 0.97, numpy.where(head > 0, 0.0, hair_radius)), 0.008)
    across_neck = x / (0.235 + 0.10 * smooth(-0.62, -0.86, y))
    neck = 0.13 * numpy.sqrt(numpy.maximum(1 - across_neck ** 2, 0)) * smooth(-0.45, -0.55, y) * smooth(0.85, 0.74, r)
    body = melt(body, ground + neck, 0.015)
    # A ring of beads, and the rim.
    angle = numpy.arctan2(y, x)
    across = (r - 0.875) / 0.024
    around = ((angle * 84 / (2 * math.pi)) % 1 - 0.5) * 2 * math.pi * 0.875 / 84 / 0.026
    beads = 0.030 * numpy.sqrt(numpy.maximum(1 - across ** 2 - around ** 2, 0))
    rim = 0.055 * smooth(0.915, 0.935, r) * smooth(1.0, 0.985, r)
    return numpy.where(r > 1, 0, numpy.maximum(body, ground + beads) + rim)


def bronze():
    return tools.material("Bronze", (0.43, 0.24, 0.10), roughness=0.36, metallic=1, stiffness=1.5, friction=(0.25, 0.18))


def slate():
    made = tools.material("Slate", (0.035, 0.04, 0.046), roughness=0.75, stiffness=1.8, friction=(0.6, 0.5))
    noise = sum(tools.smooth_noise((512, 512), (4 * 2 ** k, 4 * 2 ** k), 10 + k) / 2 ** k for k in range(6)) / 2
    node = tools.texture(made, tools.image("slate height", numpy.clip(noise, 0, 1)), "Touch Height", repeat=(2, 2))
    made["touchable_relief"] = 0.0008
    tools.bump(made, node.outputs["Color"], 0.0015)
    return made


def make():
    tools.empty_scene("a face in bronze", (720, 720), 48)
    at = numpy.linspace(-1.0, 1.0, ROWS)
    square = numpy.stack(numpy.meshgrid(at, at), axis=-1)
    disc = square * numpy.sqrt(1 - square[..., ::-1] ** 2 / 2)
    x, y = disc[..., 0], disc[..., 1]
    z = height(x, y) * RADIUS + 0.004
    places = numpy.stack((x * RADIUS, y * RADIUS, z), axis=-1)
    metal = bronze()
    tools.grid_object("Medal", places, metal, uv=False)
    rim = numpy.concatenate((places[0, :-1], places[:-1, -1], places[-1, :0:-1], places[:0:-1, 0]))
    foot = rim * (1, 1, 0)
    tools.grid_object("Medal's edge", numpy.stack((foot, rim)), metal, closed=(False, True), uv=False)
    tools.grid_object("Ground", numpy.stack(numpy.meshgrid([-0.5, 0.5], [-0.5, 0.5], [0.0]), axis=-1)[:, :, 0], slate())
    tools.camera((0, -0.045, 0.42), (0, 0.0, 0.012), 68)
    tools.area_light((-0.34, 0.30, 0.30), (0, 0, 0.01), 0.12, 6.5, (1.0, 0.88, 0.72))
    tools.area_light((0.45, -0.12, 0.32), (0, 0, 0), 0.5, 1.8, (0.62, 0.76, 1.0))
    tools.area_light((0.0, 0.1, 0.9), (0, 0, 0), 0.8, 1.6)
    tools.daylight((0.6, 0.7, 1.0), 0.10)
