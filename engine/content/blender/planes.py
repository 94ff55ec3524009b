# SPDX-License-Identifier: Apache-2.0
"""What a clip stores of a frame: depth in metres, haptic and height as codes; and the ranges of those, which the scene file has."""

from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from math import gcd

import numpy

HAPTIC_CODES, HEIGHT_CODES = 255, 65535


@dataclass(frozen=True)
class Range:
    """What code 0 and the largest code stand for."""

    least: float
    most: float

    def codes(self, values, largest):
        """The nearest ones."""
        share = (numpy.asarray(values, numpy.float64) - self.least) * (largest / (self.most - self.least))
        return numpy.rint(numpy.clip(share, 0, largest))


def range_of(values, is_varied):
    """Ends between which every one of `values` has a code of its own to the last digit where 255 steps allow it; otherwise the least and
    the greatest have. `is_varied`: what a texture makes of them goes down to 0."""
    values = set(values) | ({0.0} if is_varied else set())
    exact = [Fraction(str(round(value, 6))) for value in values]
    least, most = min(exact), max(exact)
    if least == most:
        return Range(float(least), float(least) + 1)  # one value: code 0
    parts = 10**6
    step = Fraction(reduce(gcd, (int((value - least) * parts) for value in exact)), parts)
    steps = int((most - least) / step)
    if steps <= HAPTIC_CODES:
        finer = step / (HAPTIC_CODES // steps)
        return Range(float(least), float(least + HAPTIC_CODES * finer))
    return Range(float(least), float(most))


@dataclass(frozen=True)
class Ranges:
    stiffness: Range
    static_friction: Range
    dynamic_friction: Range
    height: float  # metres; 0: no heights


def ranges_of(feels):
    """Of all materials at all frames."""
    varied = any(feel.haptic_socket for feel in feels)
    columns = zip(*(feel.values() for feel in feels))
    return Ranges(*(range_of(column, varied) for column in columns),
                  height=max(abs(feel.relief) for feel in feels))


def haptic_codes(sample, feels, ranges):
    """RGB of 8 bits: stiffness, static and dynamic friction. `feels`: of material 0, which is none, of 1 and so on."""
    table = numpy.array([feel.values() for feel in feels])
    values = table[sample.material] * numpy.clip(sample.haptic, 0, 1)
    channels = (ranges.stiffness, ranges.static_friction, ranges.dynamic_friction)
    codes = [channel.codes(values[..., k], HAPTIC_CODES) for k, channel in enumerate(channels)]
    return numpy.stack(codes, axis=-1).astype(numpy.uint8)


def height_codes(sample, feels, ranges):
    """Grey of 16 bits."""
    relief = numpy.array([feel.relief for feel in feels])[sample.material]
    heights = relief * numpy.clip(sample.height, 0, 1) - numpy.minimum(relief, 0)
    return Range(0.0, ranges.height).codes(heights, HEIGHT_CODES).astype(numpy.uint16)
