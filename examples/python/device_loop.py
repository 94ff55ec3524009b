#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A loop at 1 kHz: a device is held, its place becomes the goal, and the force goes back to it.

    device_loop.py                 3 s of virtual time: as fast as it goes, the same forces each time
    device_loop.py --wall-clock    in real time, with a count of late ticks

The device is simulated: a handle of 0.1 kg, with friction, in a hand that pushes it down and to the right. Where yours
has other functions, replace SimulatedDevice.
"""
import argparse
import time

import numpy
import touchable

tick_ns = 1_000_000
max_force_n = 5.0


class SimulatedDevice:
    """A handle at a place, metres, that a hand leads by a soft spring (80 N/m, 4 N s/m)."""

    mass_kg, spring_n_per_m, damper_n_s_per_m = 0.1, 80.0, 4.0

    def __init__(self):
        self.place, self.speed = numpy.array((-0.06, 0.0, 0.03)), numpy.zeros(3)

    def hand(self, seconds):
        """Where the hand would be: it comes down in half a second, and goes to the right."""
        return numpy.array((-0.06 + 0.04 * seconds, 0.0, max(0.03 - 0.08 * seconds, -0.02)))

    def exert(self, force_n, seconds):
        """The force of this millisecond; never more than the device bears."""
        hand = self.spring_n_per_m * (self.hand(seconds) - self.place) - self.damper_n_s_per_m * self.speed
        self.speed += (hand + numpy.clip(force_n, -max_force_n, max_force_n)) / self.mass_kg * 1e-3
        self.place = self.place + self.speed * 1e-3


def wait_until(moment_ns):
    """To that moment of the wall clock; how late it is, nanoseconds. Sleeps are short, the last bit is waited out."""
    while (left := moment_ns - time.monotonic_ns()) > 0:
        if left > 200_000:
            time.sleep((left - 150_000) * 1e-9)
    return -left


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--wall-clock", action="store_true", help="in real time, rather than as fast as it goes")
    options.add_argument("--seconds", type=float, default=3.0)
    options = options.parse_args()

    x, y = numpy.meshgrid(numpy.arange(320), numpy.arange(240))
    depth_m = 0.50 - 0.03 * numpy.exp(-(((x - 160) / 50) ** 2 + ((y - 120) / 50) ** 2))
    surface = touchable.Surface(depth_m, touchable.Camera(320, 240, fx_px=300))
    device, late, slowest_ns, touching = SimulatedDevice(), 0, 0, 0
    to_scene = numpy.array((0.0, 0.0, -0.48))  # the device's origin in the scene, metres
    # A person holds it: no force in a finger that begins inside the surface.
    with touchable.Solver(surface, metres_per_scene_unit=1, max_force_n=max_force_n, waits_to_be_free=True) as solver:
        begin = time.monotonic_ns()
        for tick in range(round(options.seconds * 1000)):
            if options.wall_clock:
                late += wait_until(begin + tick * tick_ns) > tick_ns
            start = time.monotonic_ns()
            force_n = solver.tick(device.place + to_scene)[0]
            slowest_ns = max(slowest_ns, time.monotonic_ns() - start)
            device.exert(force_n, tick * 1e-3)
            touching += int(solver.contacts["touching"][0])
            if tick % 500 == 0:
                print(f"{tick:5d} ms: handle at {device.place * 1000} mm, force {force_n} N")
        print(f"in contact for {touching} ms, force hash {solver.force_hash}")
    if options.wall_clock:
        print(f"{late} ticks were more than 1 ms late; the slowest tick took {slowest_ns / 1000:.0f} us")


if __name__ == "__main__":
    numpy.set_printoptions(precision=2, suppress=True)
    main()
