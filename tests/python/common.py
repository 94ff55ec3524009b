# SPDX-License-Identifier: Apache-2.0
"""What several tests need: the program, clips that it makes, pictures read without touchable, recordings."""
import functools
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy
import PIL.Image
import touchable

source = pathlib.Path(os.environ["TOUCHABLE_SOURCE"])
longest_s = 60  # of a wait for another process or thread
_folder = tempfile.TemporaryDirectory()


def run(*arguments):
    """What the program says; where it refuses, an exception."""
    if "TOUCHABLE_PROGRAM" not in os.environ:
        raise unittest.SkipTest("there is no program to compare with")
    done = subprocess.run([os.environ["TOUCHABLE_PROGRAM"], *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"touchable {arguments}: {done.stderr}")
    return done.stdout


@functools.lru_cache(maxsize=None)
def made(scene, *options):
    """The path of a clip of a generated scene, made once."""
    path = os.path.join(_folder.name, f"{scene}{len(os.listdir(_folder.name))}.mkv")
    run("make", scene, path, *options)
    return path


def globe():
    """12 frames of 160x120 pixels, with colour, haptic and height pictures, that turn."""
    return made("globe", "--frames", "12", "--size", "160x120")


def png(path):
    """Codes of a picture, as another program reads it."""
    with PIL.Image.open(path) as picture:
        return numpy.array(picture.convert("RGB") if picture.mode == "P" else picture)


def recording(name):
    """The path of a recording beside the checkout, or in the folder that the environment names. Where there is none the
    test is left out; it fails where TOUCHABLE_REQUIRE_DATA is set and no other folder is named. As tests/real_data.hpp."""
    elsewhere = os.environ.get("TOUCHABLE_TEST_DATA")
    path = pathlib.Path(elsewhere or source / "../shared/data") / name
    if path.exists():
        return path
    if "TOUCHABLE_REQUIRE_DATA" in os.environ and not elsewhere:
        raise AssertionError(f"no real data at {path}")
    raise unittest.SkipTest(f"no real data at {path}")


def hill(width=64, height=48):
    """Millimetres, uint16, of a hill half a metre away, and its camera."""
    x, y = numpy.meshgrid(numpy.arange(width) - width / 2, numpy.arange(height) - height / 2)
    depth = 500 - 30 * numpy.exp(-(x**2 + y**2) / (width / 4) ** 2)
    return depth.astype(numpy.uint16), touchable.Camera(width, height, fx_px=float(width))


def stroke(camera, ticks=300, depth_m=0.475):
    """A path over the middle, (ticks, 3), from the left to the right, at a depth in metres."""
    return camera.points(numpy.linspace(5, camera.width - 6, ticks), camera.height / 2, depth_m)
