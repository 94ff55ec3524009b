#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Touch in a robot simulator: arrays in, arrays out, once a step of the simulation.

A simulator knows places of fingertips, (hands, fingers, 3), 60 times a second. HapticFeedback gives it a vector for each
hand, (hands, fingers * 3) newtons. Between two steps the solver ticks a thousand times a second. A finger of which there
is no place (NaN, as a tracker that lost it) gets zero at once: a force that is old is never sent.
"""
import numpy
import touchable


class HapticFeedback:
    """Forces on the fingertips of several hands, over one surface."""

    def __init__(self, surface, hands, fingers, steps_per_second=60):
        self.shape, self.ticks_per_second, self.steps_per_second = (hands, fingers), 1000, steps_per_second
        self.solver = touchable.Solver(surface, hands * fingers, metres_per_scene_unit=1, max_force_n=8)
        self.before = None
        self.step_count = 0

    def step(self, fingertips_m):
        """One step of the simulation. fingertips_m: (hands, fingers, 3), metres, NaN where there is no place; None: no
        hand at all. Gives (hands, fingers * 3), newtons, zero where there is no place."""
        given = numpy.full((*self.shape, 3), numpy.nan) if fingertips_m is None else fingertips_m
        places = numpy.asarray(given, float).reshape(-1, 3)
        self.step_count += 1
        end = self.step_count * self.ticks_per_second // self.steps_per_second  # 16 or 17 ticks, 1000 in a second
        share = numpy.linspace(0, 1, end - self.solver.next_tick + 1)[1:, None, None]
        before = places if self.before is None else numpy.where(numpy.isfinite(self.before), self.before, places)
        touched = self.solver.run(before + share * (places - before))
        self.before = places
        force = numpy.where(numpy.isfinite(places), touched.force_n[-1], 0.0)
        return force.reshape(self.shape[0], -1)


def main():
    depth_mm = numpy.full((240, 320), 500, numpy.uint16)  # a table, half a metre below the camera
    surface = touchable.Surface(depth_mm, touchable.Camera(320, 240, fx_px=300))
    feedback = HapticFeedback(surface, hands=2, fingers=5)
    rest = numpy.stack([numpy.stack([numpy.linspace(-0.04, 0.04, 5) + side, numpy.zeros(5), numpy.full(5, -0.49)], -1)
                        for side in (-0.1, 0.1)])
    for step in range(90):
        fingertips = rest.copy()
        fingertips[..., 2] -= 0.015 * min(step / 30, 1)  # down to 5 mm under the table, in half a second
        if 60 <= step < 75:
            fingertips[1] = numpy.nan  # the right hand is lost for a quarter of a second
        payload = feedback.step(fingertips)
        if step % 15 == 14:
            print(f"step {step + 1:2d}: left {payload[0].reshape(5, 3)[:, 2].round(2)} N, "
                  f"right {payload[1].reshape(5, 3)[:, 2].round(2)} N")


if __name__ == "__main__":
    main()
