# SPDX-License-Identifier: Apache-2.0
"""Run time against error of every option of the touch solver: from `touchable-bench touch --json`."""

import re

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from plots.hand import draw_noticed, noticed_legend
from style import COLOURS

GLOBE = re.compile(r"globe-(?P<size>\d+x\d+)-(?P<bits>\w+)-1f-(?P<mode>world|pixel|scaled)"
                   r"(?P<camera>-A|-Aprime)?(-m(?P<median>\d))?(?P<terraces>-t)?(?P<lazy>-lazy)?")
MOVING = re.compile(r"moving-(?P<size>\d+x\d+)-(?P<bits>\w+)-1f-world(?P<hold>-hold)?-follow-(?P<speed>[\d.]+)")
REAL = re.compile(r"real-(?P<camera>cube|redwood|icl-\w+)-(?P<filter>[\w.-]+)")
CAMERAS = {None: "B", "-A": "A", "-Aprime": "A'"}
MODES = {"world": (COLOURS[0], "world space"), "scaled": (COLOURS[2], "pixel space, levels scaled by kappa"),
         "pixel": (COLOURS[3], "pixel space, the paper's")}
BITS = {"exact": ("D", "not quantised"), "16": ("o", "16 bits"), "10": ("^", "10 bits"), "8": ("s", "8 bits")}
HOLD = {None: (COLOURS[0], "linear between frames"), "-hold": (COLOURS[4], "hold the earlier frame")}
SIZES = "oD^sv<>p"
PAPERS_OWN = {"bits": "8", "mode": "pixel", "median": "3"}
TIME, FRAME_TIME, ANGLE, DISTANCE = "tick_us_mean", "frame_cpu_ms", "force_angle_deg_rms", "distance_mm_rms"
POINT = {"linestyle": "", "markersize": 7, "markeredgewidth": 1.4}


def options_of(figures, pattern, time, error, panel):
    """The cases of a pattern that have a time and an error, by panel."""
    panels = {}
    for case, metrics in figures.items():
        match = pattern.fullmatch(case)
        if match and metrics.get(error, 0) > 0 and metrics.get(time, 0) > 0:
            option = {**match.groupdict(), "time": metrics[time], "error": metrics[error]}
            panels.setdefault(panel(option), []).append(option)
    return panels


def front(options):
    """Times and errors of the options that no other beats in both."""
    best, points = float("inf"), []
    for option in sorted(options, key=lambda option: (option["time"], option["error"])):
        if option["error"] < best:
            best = option["error"]
            points.append((option["time"], best))
    return np.array(points).T


def is_papers_own(option):
    return option["lazy"] and all(option[key] == value for key, value in PAPERS_OWN.items())


def draw_globe(axes, options, figures):
    draw_noticed(axes, figures)
    axes.plot(*front(options), color="#999999", linewidth=1, drawstyle="steps-post", zorder=1)
    for option in options:
        colour, shape = MODES[option["mode"]][0], BITS[option["bits"]][0]
        axes.plot(option["time"], option["error"], shape, markersize=7, markeredgewidth=1.4, alpha=0.9,
                  markeredgecolor=colour, color="white" if option["lazy"] else colour)
        # Frames filtered beforehand do not slow ticks, so their median is not labelled.
        if option["lazy"] and option["median"] and option["mode"] == "pixel":
            axes.annotate(f"{option['median']}x{option['median']}", (option["time"], option["error"]),
                          xytext=(0, -21), textcoords="offset points", ha="center", fontsize=8, color=colour)
        if option["terraces"]:
            axes.annotate("t", (option["time"], option["error"]), xytext=(7, -3), textcoords="offset points", fontsize=8)
        if is_papers_own(option):
            axes.plot(option["time"], option["error"], "o", markersize=16, color="none", markeredgecolor="black",
                      markeredgewidth=1.4)
            axes.annotate("the paper's own (253 µs on its PC)", (option["time"], option["error"]), xytext=(0, 13),
                          textcoords="offset points", ha="center", fontsize=8.5)


def sizes_of(options):
    return list(dict.fromkeys(option["size"] for option in options))


def draw_moving(axes, options):
    """The speeds of a size and an interpolation are joined, slow to fast."""
    sizes = sizes_of(options)
    for hold, (colour, _) in HOLD.items():
        for index, size in enumerate(sizes):
            same = sorted((float(option["speed"]), option["time"], option["error"]) for option in options
                          if option["size"] == size and option["hold"] == hold)
            if same:
                _, times, errors = zip(*same)
                axes.plot(times, errors, SIZES[index % len(SIZES)] + "-", color=colour, markersize=7, linewidth=0.8)


def draw_real(axes, options, figures):
    draw_noticed(axes, figures)
    times, errors = front(options)
    axes.plot(times, errors, color="#999999", linewidth=1, drawstyle="steps-post", zorder=1)
    labelled = float("inf")
    for option in sorted(options, key=lambda option: option["time"]):
        chosen = option["filter"] == "chosen"
        axes.plot(option["time"], option["error"], "o", color=COLOURS[0] if chosen else "white", markeredgecolor=COLOURS[0])
        if chosen or option["time"] in times and option["error"] < 0.75 * labelled:
            labelled = option["error"]
            axes.annotate(option["filter"], (option["time"], option["error"]), xytext=(-6, -3), ha="right",
                          textcoords="offset points", fontsize=7.5)


def log_axes(axes, title):
    axes.set(xscale="log", yscale="log", title=title)
    axes.xaxis.set_major_formatter("{x:g}")
    # Every second small step has a number: 0.8 and 0.9 would overlap.
    axes.xaxis.set_minor_formatter(lambda x, _: f"{x:.2g}" if f"{x:e}"[0] in "2346" else "")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.tick_params(axis="x", which="both", labelsize=8.5, length=3.5, pad=3)
    axes.grid(which="both", color="#e8e8e8", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.margins(x=0.08, y=0.2)


def draw_band(band, panels, draw, title, across, up):
    """Panels two by two, with the axes in common."""
    columns = min(2, len(panels))
    grid = band.subplots(-(-len(panels) // columns), columns, sharex=True, sharey=True, squeeze=False)
    for axes in grid.flat[len(panels):]:
        axes.remove()
    for index, (axes, (name, options)) in enumerate(zip(grid.flat, panels.items())):
        log_axes(axes, name)
        axes.tick_params(axis="x", which="both", labelbottom=index + columns >= len(panels))
        draw(axes, options)
    band.suptitle(title, fontsize=12)
    band.supxlabel(across, fontsize=10)
    band.supylabel(up, fontsize=10)


def globe_legend():
    handles = [Patch(facecolor=colour, label=label) for colour, label in MODES.values()]
    handles += [Line2D([], [], marker=marker, color="#666666", label=label, **POINT)
                for marker, label in BITS.values()]
    handles.append(Line2D([], [], marker="s", color="white", markeredgecolor="#666666",
                          label="filtered where touched", **POINT))
    handles.append(Line2D([], [], marker="$t$", color="black", label="terraces removed", linestyle=""))
    handles.append(Line2D([], [], color="#999999", linewidth=1, label="nothing is better in both"))
    return handles


def real_legend():
    return [Line2D([], [], marker="o", color=COLOURS[0], label="chosen by the program", **POINT),
            Line2D([], [], marker="o", color="white", markeredgecolor=COLOURS[0], label="m: median, t: terraces removed", **POINT),
            Line2D([], [], color="#999999", linewidth=1, label="nothing is better in both")]


def moving_legend(options):
    handles = [Patch(facecolor=colour, label=label) for colour, label in HOLD.values()]
    return handles + [Line2D([], [], marker=SIZES[index % len(SIZES)], color="#666666", label=size, **POINT)
                      for index, size in enumerate(sizes_of(options))]


def draw_pareto(figures):
    globe = options_of(figures, GLOBE, TIME, ANGLE, lambda o: f"camera {CAMERAS[o['camera']]}, {o['size']}")
    moving = options_of(figures, MOVING, TIME, DISTANCE, lambda o: "stroked at 0.05, 0.1 and 0.3 m/s")
    real = options_of(figures, REAL, FRAME_TIME, ANGLE, lambda o: o["camera"])
    tick = "CPU time of a tick (µs)"
    bands = []
    if globe:
        bands.append((globe, lambda axes, options: draw_globe(axes, options, figures), "The globe, one finger",
                      tick, "error of the force's direction (degrees RMS)", globe_legend() + noticed_legend(figures)))
    if moving:
        bands.append((moving, draw_moving, "A surface that rises and falls by 20 mm at 30 frames/s", tick,
                      "from the true nearest\npoint (mm RMS)", moving_legend(next(iter(moving.values())))))
    if real:
        bands.append((real, lambda axes, options: draw_real(axes, options, figures), "Real depth of 640x480, by filters",
                      "CPU time of a frame (ms)", "error of the force's direction (degrees RMS)",
                      real_legend() + noticed_legend(figures)))
    if not bands:
        return None
    heights = [3.1 * -(-len(band[0]) // 2) + 0.7 for band in bands]
    figure = plt.figure(layout="constrained", figsize=(11, sum(heights) + 0.8 * len(bands)))
    parts = figure.subfigures(2 * len(bands), 1, height_ratios=[x for height in heights for x in (height, 0.8)])
    for (panels, draw, title, across, up, legend), band, below in zip(bands, parts[::2], parts[1::2]):
        draw_band(band, panels, draw, title, across, up)
        below.legend(handles=legend, loc="center", ncol=4, fontsize=9)
    return figure
