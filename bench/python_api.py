#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What Python costs over the C library, as ratios within one run: python3 bench/python_api.py [--rounds N] [--program PATH]

A batch of 1000 ticks by Solver.run against touch_solver_run with memory that is there already; ticks one by one against the
same; frames of a turning globe read into numpy (depth, colour, haptic, height), and as metres, against reading alone
(touch_clip_next and touch_frameset_release). Times are the shortest of several rounds, which alternate. Ratios are those of
processor time, which other programs disturb least. Wants the package installed, and the program `touchable`, which makes
the clips that are read.
"""
import argparse
import ctypes
import pathlib
import subprocess
import tempfile
import time

import numpy
import touchable
from touchable import _library
from touchable._touch import _contact

ticks = 1000


def seconds_of(work):
    """By the clock, and of the processor."""
    start, used = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - start, time.process_time() - used


def compared(rounds, reference, *works):
    """The shortest time of `reference`; of each other one its shortest time, and the ratio of their processor times."""
    clock, used = numpy.array([[seconds_of(work) for work in (reference, *works)] for _ in range(rounds)]).min(axis=0).T
    return clock[0], list(zip(clock[1:], used[1:] / used[0]))


class Stroke:
    """Fingers that stroke over a hill, ready for the next thousand ticks, and as often as they are asked."""

    def __init__(self, fingers):
        x, y = numpy.meshgrid(numpy.arange(320), numpy.arange(240))
        depth_m = 0.50 - 0.04 * numpy.exp(-(((x - 160) / 60) ** 2 + ((y - 120) / 60) ** 2))
        camera = touchable.Camera(320, 240, fx_px=300)
        way = numpy.linspace(0, 2 * numpy.pi, ticks)[:, None] + numpy.arange(fingers)
        self.path = camera.points(160 + 60 * numpy.cos(way), 120 + 60 * numpy.sin(way), 0.49)  # 5 mm in
        self.solver = touchable.Solver(touchable.Surface(depth_m, camera), fingers)
        self.contacts = numpy.zeros((ticks, fingers), _contact)
        self.tick = _library.Tick()

    def in_c(self):
        self.tick.tick = self.solver.next_tick
        self.tick.time_ns = self.tick.tick * 1_000_000
        _library.function("solver_run")(self.solver._handle.number, self.tick, ticks, self.path.ctypes.data,
                                        self.contacts.ctypes.data, _contact.itemsize)
        self.solver.next_tick += ticks

    def in_one_call(self):
        self.solver.run(self.path)

    def tick_by_tick(self):
        for goals in self.path:
            self.solver.tick(goals)


def touching(rounds):
    for fingers in 1, 5:
        stroke = Stroke(fingers)
        assert stroke.solver.run(stroke.path).touching.all()
        in_c, others = compared(rounds, stroke.in_c, stroke.in_one_call, stroke.tick_by_tick)
        for way, (seconds, ratio) in zip(("in one call", "one by one"), others):
            print(f"| {ticks} ticks {way}, {fingers} finger{'s' * (fingers > 1)} | {1e6 * seconds / ticks:.2f} us a tick | "
                  f"{1e6 * in_c / ticks:.2f} us a tick | {ratio:.2f} |")


def read_alone(clip):
    """By the C API alone, as a program in C reads."""
    following, release = _library.function("clip_next"), _library.function("frameset_release")
    _library.call("clip_seek", clip._handle.number, 0)
    frameset, error = ctypes.c_uint64(), _library.ErrorLine()
    while following(clip._handle.number, frameset, error) == touchable.Status.OK:
        release(frameset.value)
    clip._position = None


def into_numpy(clip):  # all four pictures
    for frame in clip:
        frame.depth, frame.colour, frame.haptic, frame.height


def into_metres(clip):
    for frame in clip:
        frame.metres


def reading(rounds, program, folder):
    for size in "640x480", "1920x1080":
        path = f"{folder}/{size}.mkv"
        subprocess.run([program, "make", "globe", path, "--size", size, "--frames", "30"], check=True, capture_output=True)
        with touchable.open(path) as clip:
            assert clip.has_colour and clip.has_haptic and clip.has_height
            works = [lambda work=work: work(clip) for work in (read_alone, into_numpy, into_metres)]
            alone, others = compared(rounds, *works)
            for way, (seconds, ratio) in zip(("into numpy", "as metres"), others):
                print(f"| {size} read {way} | {len(clip) / seconds:.0f} frames/s | "
                      f"{len(clip) / alone:.0f} frames/s | {ratio:.2f} |")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--rounds", type=int, default=7)
    options.add_argument("--program", type=pathlib.Path, default="touchable")
    options = options.parse_args()
    print("| what | from Python | the same by C calls | ratio |\n|---|---|---|---|")
    touching(options.rounds * 5)
    with tempfile.TemporaryDirectory() as folder:
        reading(options.rounds, options.program, folder)


if __name__ == "__main__":
    main()
