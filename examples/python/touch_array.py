#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Your own depth array, touched: a finger strokes over a hill, and its forces are drawn. touch_array.py [PICTURE.png]"""
import sys
import numpy, touchable

def depth_m(x, y):  # a hill with ripples, half a metre away
    return 0.50 - 0.04 * numpy.exp(-(((x - 160) / 60) ** 2 + ((y - 120) / 60) ** 2)) + 0.0005 * numpy.sin(x / 4)

picture = depth_m(*numpy.meshgrid(numpy.arange(320), numpy.arange(240)))  # (240, 320) floats
camera = touchable.Camera(320, 240, fx_px=300)
x = numpy.linspace(30, 290, 3000)  # a tick for each millisecond: from left to right in 3 s,
y = 120 + 30 * numpy.sin(x / 40)
goals = camera.points(x, y, depth_m(x, y) - 0.005 * numpy.cos((x - 30) / 20))  # up to 5 mm over it, and 5 mm in
touched = touchable.Surface(picture, camera).touch(goals, metres_per_scene_unit=1)
print(f"strongest force {numpy.linalg.norm(touched.force_n, axis=-1).max():.3f} N, force hash {touched.force_hash}")
touchable.plot(touched, *sys.argv[1:2], title="a finger strokes over a hill")
