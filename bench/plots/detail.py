# SPDX-License-Identifier: Apache-2.0
"""What filters leave of noise against the least relief they keep: from `touchable-bench touch --json`."""

import re

import matplotlib.pyplot as plt

from plots.hand import draw_noticed, noticed_legend
from style import colour

CASE = re.compile(r"real-detail-(?P<name>[\w.-]+)")
NAMES = {"cube": "RealSense, 0.4 m", "castel": "SR300, 0.25 m", "redwood": "PrimeSense, 1.8 m",
         "azure": "time of flight, 1.4 m (a model)"}


def points_of(figures):
    """Per recording: pens (mm) and leans (degrees) of its points, and which of these is chosen."""
    recordings = {}
    for case, metrics in figures.items():
        match = CASE.fullmatch(case)
        if not match or "points" not in metrics:
            continue
        numbers = range(int(metrics["points"]))
        recordings[match["name"]] = ([metrics[f"detail_{k}_pen_mm"] for k in numbers],
                                     [metrics[f"detail_{k}_leans_deg"] for k in numbers],
                                     int(metrics["chosen_detail"]))
    return recordings


def draw_detail(figures):
    recordings = points_of(figures)
    if not recordings:
        return None
    figure, axes = plt.subplots(layout="constrained", figsize=(8.5, 5))
    least = min(pen for pens, _, _ in recordings.values() for pen in pens if pen > 0) / 2
    draw_noticed(axes, figures)
    for number, (name, (pens, leans, chosen)) in enumerate(recordings.items()):
        # A logarithmic axis has no 0, which is everything.
        shown = [max(pen, least) for pen in pens]
        axes.plot(shown, leans, "o-", color=colour(number), markersize=5, linewidth=1.2,
                  label=NAMES.get(name, name))
        axes.plot(shown[chosen], leans[chosen], "o", markersize=13, color="none", markeredgecolor=colour(number),
                  markeredgewidth=1.5)
    axes.plot([], [], "o", markersize=13, color="none", markeredgecolor="#666666", label="chosen without a detail")
    axes.set(xscale="log", yscale="log", xlabel="least pen of which 80 % are kept (mm); leftmost: every one",
             ylabel="smooth places lean to and fro (degrees RMS)")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(lambda x, _: f"{x:.2g}" if f"{x:e}"[0] in "25" else "")
    axes.grid(which="both", color="#e8e8e8", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.legend(handles=axes.get_legend_handles_labels()[0] + noticed_legend(figures), fontsize=9)
    axes.set_title("Detail of four recordings, from as recorded (upper left) to smooth")
    return figure
