# SPDX-License-Identifier: Apache-2.0
"""What all plots share: colours, and how input that cannot be used is refused."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Okabe and Ito's colours, distinguishable with any colour vision and over grey; three of Tol's follow, so that ten
# fingers differ. Pictures of a scene use the same (player/draw/finger_marks.cpp).
COLOURS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442", "#332288", "#882255", "#999933"]

plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False,
                     "axes.edgecolor": "#666666", "axes.titlesize": 12, "legend.frameon": False})


class BadInput(Exception):
    """What is wrong, where, and what would be right."""


def colour(index):
    return COLOURS[index % len(COLOURS)]
