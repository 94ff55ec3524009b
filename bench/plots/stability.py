# SPDX-License-Identifier: Apache-2.0
"""Up to which stiffness a closed loop is stable, beside theory: from `touchable-bench loop --json`."""

import re

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from style import colour

LOOP = re.compile(r"(?P<scene>[a-z]+)-\d+x\d+-\w+-1f-(?P<metric>world|pixel)-b(?P<damping>[\d.]+)"
                  r"(-d(?P<delay>\d+))?(-f(?P<friction>[\d.]+))?(-q(?P<quantum>[\d.]+))?")
METRICS = {"world": "world metric", "pixel": "pixel metric, the paper's"}
MARKERS = "oD^sv<>pXP"
BOUNDARY = "boundary_n_per_mm"
LEAST_SHOWN = 0.02  # N/mm: below this, nothing is stable


def theory(loop):
    """N/mm: Gil's for a delay, Abbott and Okamura's where readings are quantised; both are Colgate and Schenkel's
    where there is neither."""
    bound = loop["damping"] / (0.5 + loop["delay"])
    return min(bound, 2000 * loop["friction"] / loop["quantum"]) if loop["quantum"] > 0 else bound


def loops_of(figures):
    loops = []
    for case, metrics in figures.items():
        match = LOOP.fullmatch(case)
        if match and BOUNDARY in metrics:
            numbers = {key: float(match[key] or 0) for key in ("damping", "delay", "friction", "quantum")}
            loops.append({"scene": match["scene"], "metric": match["metric"], **numbers,
                          "boundary": max(metrics[BOUNDARY], LEAST_SHOWN)})
    return loops


def draw_against(axes, loops, scenes, by, across):
    """Boundaries over the number `across`, a colour for each value of `by`; theory as lines. Scenes stand a little
    apart, so that equal boundaries are seen."""
    for index, value in enumerate(sorted({loop[by] for loop in loops})):
        same = [loop for loop in loops if loop[by] == value]
        numbers = [loop[across] for loop in same]
        line = np.geomspace(min(numbers), max(numbers), 200)
        axes.plot(line, [theory({**same[0], across: number}) for number in line], color=colour(index), linewidth=1.4,
                  zorder=1)
        for loop in same:
            shift = 1.025 ** (scenes.index(loop["scene"]) - (len(scenes) - 1) / 2)
            axes.plot(loop[across] * shift, loop["boundary"], MARKERS[scenes.index(loop["scene"]) % len(MARKERS)],
                      markersize=4.5, color=colour(index), markeredgecolor="white", markeredgewidth=0.4)


def number_axes(axes, values):
    axes.set(xscale="log", yscale="log")
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.xaxis.set_minor_locator(plt.NullLocator())
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(which="major", color="#e0e0e0", linewidth=0.6)
    axes.set_axisbelow(True)


def handles_of(loops, by, words):
    return [Line2D([], [], color=colour(index), linewidth=3, label=words(value))
            for index, value in enumerate(sorted({loop[by] for loop in loops}))]


def draw_stability(figures):
    loops = loops_of(figures)
    if not loops:
        return None
    scenes = list(dict.fromkeys(loop["scene"] for loop in loops))
    smooth = [loop for loop in loops if loop["quantum"] == 0]
    rough = [loop for loop in loops if loop["quantum"] > 0]
    rows = [(smooth, "delay", "damping", "damping b (N s/m)"),
            (rough, "damping", "friction", "Coulomb friction f (N), read in quanta of 60 um")]
    rows = [row for row in rows if row[0]]
    figure = plt.figure(layout="constrained", figsize=(10.5, 4.1 * len(rows) + 0.9))
    *bands, below = figure.subfigures(len(rows) + 1, 1, height_ratios=[4.1] * len(rows) + [0.7])
    for band, (shown, by, across, words) in zip(bands, rows):
        panels = band.subplots(1, len(METRICS), sharex=True, sharey=True)
        for axes, (metric, title) in zip(panels, METRICS.items()):
            number_axes(axes, sorted({loop[across] for loop in shown}))
            draw_against(axes, [loop for loop in shown if loop["metric"] == metric], scenes, by, across)
            axes.set_title(title)
            if by != "delay":
                top = max(loop["boundary"] for loop in shown)
                axes.axhline(top, color="#999999", linewidth=0.8, linestyle=":", zorder=0)
                axes.annotate("not looked farther", (0.99, top), xycoords=("axes fraction", "data"), xytext=(0, 3),
                              textcoords="offset points", ha="right", fontsize=8, color="#666666")
            axes.set_xlabel(words)
        panels[0].set_ylabel("stable up to (N/mm)")
        legend = handles_of(shown, by, lambda value: f"t = {value:g} ms" if by == "delay" else f"b = {value:g} N s/m")
        title = ("forces late by t: K < b / (T/2 + t)" if by == "delay" else "K < min(2 b / T, 2 f / quantum)")
        place = {"loc": "upper left"} if by == "delay" else {"loc": "lower right", "bbox_to_anchor": (1.0, 0.12)}
        panels[0].legend(handles=legend, **place, fontsize=8.5, title=title, title_fontsize=8.5,
                         alignment="left")
    figure.suptitle("Where a held finger begins to shake (points), and theory (lines)", fontsize=12)
    below.legend(handles=[Line2D([], [], linestyle="", marker=MARKERS[index % len(MARKERS)], color="#555555",
                                 markersize=5.5, label=scene) for index, scene in enumerate(scenes)],
                 loc="center", ncol=min(10, len(scenes)), fontsize=9, columnspacing=1.2, handletextpad=0.2)
    return figure
