"""Run time against error of every option of the touch solver: from `touchable-bench touch --json`."""

import re

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from plots.files import read_figures, save
from style import COLOURS, BadInput

GLOBE = re.compile(r"globe-(?P<size>\d+x\d+)-(?P<bits>\w+)-1f-(?P<mode>world|pixel|scaled)"
                   r"(?P<camera>-A|-Aprime)?(-m(?P<median>\d))?(?P<lazy>-lazy)?")
MOVING = re.compile(r"moving-(?P<size>\d+x\d+)-(?P<bits>\w+)-1f-world(?P<hold>-hold)?-follow-(?P<speed>[\d.]+)")
CAMERAS = {None: "B", "-A": "A", "-Aprime": "A'"}
MODES = {"world": (COLOURS[0], "world space"), "scaled": (COLOURS[2], "pixel space, levels scaled by kappa"),
         "pixel": (COLOURS[3], "pixel space, the paper's")}
BITS = {"exact": ("D", "not quantised"), "16": ("o", "16 bits"), "10": ("^", "10 bits"), "8": ("s", "8 bits")}
HOLD = {None: (COLOURS[0], "linear between frames"), "-hold": (COLOURS[4], "hold the earlier frame")}
SIZES = "oD^sv<>p"
PAPERS_OWN = {"bits": "8", "mode": "pixel", "median": "3"}
TIME, ANGLE, DISTANCE = "tick_us_mean", "force_angle_deg_rms", "distance_mm_rms"
NOTICED = "force_angle_jnd_rms"
POINT = {"linestyle": "", "markersize": 7, "markeredgewidth": 1.4}


def options_of(figures, pattern, error, panel):
    """The cases of a pattern that have a time and an error, by panel."""
    panels = {}
    for case, metrics in figures.items():
        match = pattern.fullmatch(case)
        if match and metrics.get(error, 0) > 0 and metrics.get(TIME, 0) > 0:
            option = {**match.groupdict(), "time": metrics[TIME], "error": metrics[error]}
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


def just_noticed(figures):
    """Degrees of one JND: the report has the same error in both; None of an older one."""
    return next((metrics[ANGLE] / metrics[NOTICED] for metrics in figures.values() if metrics.get(NOTICED)), None)


def is_papers_own(option):
    return option["lazy"] and all(option[key] == value for key, value in PAPERS_OWN.items())


def draw_globe(axes, options, noticed):
    if noticed:
        axes.axhline(noticed, color="#999999", linewidth=1, linestyle=":", zorder=1)
    axes.plot(*front(options), color="#999999", linewidth=1, drawstyle="steps-post", zorder=1)
    for option in options:
        colour, shape = MODES[option["mode"]][0], BITS[option["bits"]][0]
        axes.plot(option["time"], option["error"], shape, markersize=7, markeredgewidth=1.4, alpha=0.9,
                  markeredgecolor=colour, color="white" if option["lazy"] else colour)
        # Frames filtered beforehand do not slow ticks, so their median is not labelled.
        if option["lazy"] and option["median"] and option["mode"] == "pixel":
            axes.annotate(f"{option['median']}x{option['median']}", (option["time"], option["error"]),
                          xytext=(0, -21), textcoords="offset points", ha="center", fontsize=8, color=colour)
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
    for axes, (name, options) in zip(grid.flat, panels.items()):
        log_axes(axes, name)
        draw(axes, options)
    band.suptitle(title, fontsize=12)
    band.supxlabel(across, fontsize=10)
    band.supylabel(up, fontsize=10)


def globe_legend(noticed):
    handles = [Patch(facecolor=colour, label=label) for colour, label in MODES.values()]
    handles += [Line2D([], [], marker=marker, color="#666666", label=label, **POINT)
                for marker, label in BITS.values()]
    handles.append(Line2D([], [], marker="s", color="white", markeredgecolor="#666666",
                          label="filtered where touched", **POINT))
    handles.append(Line2D([], [], color="#999999", linewidth=1, label="nothing is better in both"))
    if noticed:
        handles.append(Line2D([], [], color="#999999", linewidth=1, linestyle=":",
                              label=f"a hand just notices ({noticed:.3g} degrees)"))
    return handles


def moving_legend(options):
    handles = [Patch(facecolor=colour, label=label) for colour, label in HOLD.values()]
    return handles + [Line2D([], [], marker=SIZES[index % len(SIZES)], color="#666666", label=size, **POINT)
                      for index, size in enumerate(sizes_of(options))]


def draw_pareto(arguments):
    figures = read_figures(arguments.results)
    globe = options_of(figures, GLOBE, ANGLE, lambda o: f"camera {CAMERAS[o['camera']]}, {o['size']}")
    moving = options_of(figures, MOVING, DISTANCE, lambda o: "stroked at 0.05, 0.1 and 0.3 m/s")
    bands = []
    if globe:
        noticed = just_noticed(figures)
        bands.append((globe, lambda axes, options: draw_globe(axes, options, noticed), "The globe, one finger", "error of the force's direction (degrees RMS)",
                      globe_legend(noticed)))
    if moving:
        bands.append((moving, draw_moving, "A surface that rises and falls by 20 mm at 30 frames/s",
                      "from the true nearest\npoint (mm RMS)", moving_legend(next(iter(moving.values())))))
    if not bands:
        raise BadInput(f"{arguments.results}: there is no case of the globe with {TIME} and {ANGLE}")
    heights = [3.1 * -(-len(band[0]) // 2) + 0.7 for band in bands]
    figure = plt.figure(layout="constrained", figsize=(11, sum(heights) + 0.8 * len(bands)))
    parts = figure.subfigures(2 * len(bands), 1, height_ratios=[x for height in heights for x in (height, 0.8)])
    for (panels, draw, title, up, legend), band, below in zip(bands, parts[::2], parts[1::2]):
        draw_band(band, panels, draw, title, "CPU time of a tick (µs)", up)
        below.legend(handles=legend, loc="center", ncol=5, fontsize=9)
    save(figure, arguments.out)
