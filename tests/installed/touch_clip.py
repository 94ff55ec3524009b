# SPDX-License-Identifier: Apache-2.0
"""As examples/c/touch_clip.c: touches a clip with the goals that `touchable touch --forces` wrote, and prints the force hash."""
import sys

import numpy
import touchable

clip, forces = sys.argv[1:]
goals = numpy.loadtxt(forces, delimiter=",", skiprows=1, usecols=(3, 4, 5))
print(touchable.touch(clip, goals).force_hash)
