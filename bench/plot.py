#!/usr/bin/python3
"""Draws what `touchable touch`, `touchable export` and `touchable-bench` wrote.

plot.py forces FORCES.csv OUT.png              force over time, one strip per finger
plot.py paths EXPORT_DIR FORCES.csv OUT.png    the frame's depth, and where the proxies went over it
plot.py pareto RESULTS.json OUT.png            run time against error of every option of the touch solver
"""

import argparse
import csv
import json
import os
import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.image
import matplotlib.patheffects
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

# Okabe and Ito's colours: told apart by every kind of eye, and over grey.
COLOURS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442"]
NUMBERS = ["time_s", "force_x", "force_y", "force_z", "pixel_x", "pixel_y"]
FLAGS = ["finger", "contact", "guard"]
STRIPS_AT_MOST = 12

plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False,
                     "axes.edgecolor": "#666666", "axes.titlesize": 12, "legend.frameon": False})


class BadInput(Exception):
    """What is wrong, where, and what would be right."""


def read_forces(file):
    """Per finger, in order: a dict of arrays over the ticks."""
    fingers = {}
    try:
        with open(file, newline="", encoding="utf-8") as stream:
            rows = csv.DictReader(stream)
            missing = [name for name in NUMBERS + FLAGS if name not in (rows.fieldnames or [])]
            if missing:
                raise BadInput(f"{file}: there is no column {missing[0]}: must be written by touch --forces")
            for row in rows:
                try:
                    values = [float(row[name]) for name in NUMBERS] + [int(row[name]) for name in FLAGS]
                except (TypeError, ValueError):
                    raise BadInput(f"{file}: line {rows.line_num}: must be numbers in every column") from None
                fingers.setdefault(values[len(NUMBERS)], []).append(values)
    except (OSError, UnicodeDecodeError, csv.Error) as fault:
        raise BadInput(f"{file}: cannot be read: {fault}") from None
    if not fingers:
        raise BadInput(f"{file}: has no rows")
    return [dict(zip(NUMBERS + FLAGS, np.array(fingers[finger]).T)) for finger in sorted(fingers)]


def magnitude(finger):
    return np.sqrt(finger["force_x"] ** 2 + finger["force_y"] ** 2 + finger["force_z"] ** 2)


def name(finger):
    return f"finger {int(finger['finger'][0])}"


def colour(index):
    return COLOURS[index % len(COLOURS)]


def save(figure, out):
    """The picture appears whole or not at all."""
    part = f"{out}.part.png"
    try:
        figure.savefig(part, dpi=130)
        os.replace(part, out)
    except OSError as fault:
        raise BadInput(f"{out}: cannot be written: {fault}") from None
    finally:
        if os.path.exists(part):
            os.remove(part)


def contact_share(fingers):
    return 100 * np.mean(np.concatenate([finger["contact"] for finger in fingers]) != 0)


def draw_strip(axes, finger, index, top):
    time, force = finger["time_s"], magnitude(finger)
    axes.fill_between(time, force, color=colour(index), alpha=0.25, linewidth=0)
    axes.plot(time, force, color=colour(index), linewidth=0.9)
    axes.fill_between(time, top, where=finger["guard"] != 0, step="mid", color="#999999", alpha=0.35,
                      linewidth=0)
    axes.set_ylim(0, top)
    axes.margins(x=0)
    axes.locator_params(axis="y", nbins=4)
    axes.grid(axis="both", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    share, touching = 100 * np.mean(finger["contact"] != 0), force[finger["contact"] != 0]
    mean = f"mean {touching.mean():.2f} N" if touching.size else "no contact"
    axes.text(1.012, 0.5, f"{name(finger)}\n{share:.0f} % in contact\n{mean}\nmax {force.max():.2f} N",
              transform=axes.transAxes, va="center", fontsize=9, color="#333333", linespacing=1.35)


def draw_forces(arguments):
    fingers = read_forces(arguments.forces)
    shown = fingers[:STRIPS_AT_MOST]
    top = 1.08 * max(magnitude(finger).max() for finger in shown) or 1.0
    if not np.isfinite(top):
        raise BadInput(f"{arguments.forces}: a force is not finite")
    figure, strips = plt.subplots(len(shown), 1, sharex=True, squeeze=False, layout="constrained",
                                  figsize=(10, 1.5 + 1.2 * max(2, len(shown))))
    for index, (axes, finger) in enumerate(zip(strips[:, 0], shown)):
        draw_strip(axes, finger, index, top)
    strips[-1, 0].set_xlabel("time (s)")
    figure.supylabel("force |F| (N)", fontsize=10)
    seconds = fingers[0]["time_s"][-1] - fingers[0]["time_s"][0]
    some = "" if len(shown) == len(fingers) else f" (the first {len(shown)} shown)"
    what = "finger" if len(fingers) == 1 else "fingers"
    strips[0, 0].set_title(f"Force on {len(fingers)} {what}{some} over {seconds:.2f} s, "
                           f"{contact_share(fingers):.0f} % of ticks in contact", loc="left", pad=26)
    handles = [Patch(facecolor=colour(k), alpha=0.7, label=name(finger)) for k, finger in enumerate(shown)]
    if any(np.any(finger["guard"] != 0) for finger in shown):
        handles.append(Patch(facecolor="#999999", alpha=0.45, label="changed by the guard"))
    strips[0, 0].legend(handles=handles, loc="lower left", bbox_to_anchor=(-0.01, 0.98), ncol=7, fontsize=9,
                        handlelength=1.2, columnspacing=1.4)
    save(figure, arguments.out)


def read_plane(file):
    try:
        plane = matplotlib.image.imread(file)
    except (OSError, SyntaxError, ValueError) as fault:
        raise BadInput(f"{file}: cannot be read: {fault}") from None
    if plane.ndim != 2:
        raise BadInput(f"{file}: must be a grey picture")
    return plane


def read_scene(file):
    try:
        scene = json.loads(Path(file).read_text(encoding="utf-8"))
        depth = scene["depth"]
        near_is_high = depth["coding"] != "metric" and depth.get("near_is", "high") == "high"
        return scene.get("name", ""), near_is_high
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise BadInput(f"{file}: must be the scene.json of an export: {fault}") from None


def shades(codes, valid, near_is_high):
    """RGB: near is light; the farthest code, so often a background, is darkest and apart from the rest; what
    has no depth is a dull blue."""
    nearness = codes if near_is_high else -codes
    known = nearness[valid]
    farthest = known.min() if known.size else 0
    rest = known[known > farthest]
    low, high = np.percentile(rest, [1, 99]) if rest.size else (0, 1)
    grey = 0.25 + 0.7 * np.clip((nearness - low) / max(high - low, 1e-9), 0, 1)
    grey[nearness <= farthest] = 0.12
    picture = np.repeat(grey[:, :, None], 3, axis=2)
    picture[~valid] = (0.16, 0.19, 0.30)
    return picture


def stretches(finger):
    """The proxy's path in pixels, broken where it lifts off."""
    x, y = finger["pixel_x"].copy(), finger["pixel_y"].copy()
    off = finger["contact"] == 0
    x[off] = y[off] = np.nan
    return x, y


def draw_paths(arguments):
    folder = Path(arguments.export)
    title, near_is_high = read_scene(folder / "scene.json")
    codes, valid = read_plane(folder / "codes.png"), read_plane(folder / "valid.png") > 0
    if codes.shape != valid.shape:
        raise BadInput(f"{folder / 'valid.png'}: must have the size of codes.png")
    fingers = read_forces(arguments.forces)
    height, width = codes.shape
    figure, axes = plt.subplots(layout="constrained", figsize=(10, 8.3 * height / width + 0.9))
    axes.imshow(shades(codes, valid, near_is_high), interpolation="nearest")
    halo = [matplotlib.patheffects.Stroke(linewidth=3.2, foreground="white", alpha=0.75),
            matplotlib.patheffects.Normal()]
    handles = []
    for index, finger in enumerate(fingers):
        x, y = stretches(finger)
        axes.plot(x, y, color=colour(index), linewidth=1.6, path_effects=halo, solid_capstyle="round")
        touching = np.flatnonzero(finger["contact"])
        if touching.size:
            first, last = touching[0], touching[-1]
            axes.plot(x[first], y[first], "o", color="white", markeredgecolor=colour(index), markersize=7,
                      markeredgewidth=2)
            axes.plot(x[last], y[last], "o", color=colour(index), markeredgecolor="white", markersize=8)
        handles.append(Line2D([], [], color=colour(index), linewidth=3, label=name(finger)))
    handles += [Line2D([], [], linestyle="", marker="o", color="white", markeredgecolor="#555555",
                       markeredgewidth=2, markersize=7, label="first contact"),
                Line2D([], [], linestyle="", marker="o", color="#555555", markersize=7, label="last contact")]
    if not valid.all():
        handles.append(Patch(facecolor=(0.16, 0.19, 0.30), label="no depth"))
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xlabel="column (pixels)",
             ylabel="row (pixels)")
    seconds = fingers[0]["time_s"][-1] - fingers[0]["time_s"][0]
    what = "proxy" if len(fingers) == 1 else "proxies"
    axes.set_title(f"{title or folder.name}: {len(fingers)} {what} over the depth, near is light "
                   f"({seconds:.2f} s, {contact_share(fingers):.0f} % in contact)", loc="left")
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0)
    save(figure, arguments.out)


OPTION = re.compile(r"globe-(?P<size>\d+x\d+)-(?P<bits>\w+)-1f-(?P<mode>world|pixel)(?P<camera>-A|-Aprime)?"
                    r"(-m(?P<median>\d))?(?P<lazy>-lazy)?")
CAMERAS = {None: "B", "-A": "A", "-Aprime": "A'"}
MODES = {"world": (COLOURS[0], "world space"), "pixel": (COLOURS[3], "pixel space, the paper's")}
BITS = {"exact": ("D", "not quantised"), "16": ("o", "16 bits"), "10": ("^", "10 bits"), "8": ("s", "8 bits")}
PAPERS_OWN = {"bits": "8", "mode": "pixel", "median": "3"}
ERROR, TIME = "force_angle_deg_rms", "tick_us_mean"


def read_options(file):
    """Per camera and size, in order: the options with their time and error."""
    figures = {}
    try:
        for row in json.loads(Path(file).read_text(encoding="utf-8")):
            figures.setdefault(row["case"], {})[row["metric"]] = float(row["value"])
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise BadInput(f"{file}: must be what touchable-bench --json wrote: {fault}") from None
    groups = {}
    for case, metrics in figures.items():
        match = OPTION.fullmatch(case)
        if match and match["bits"] in BITS and metrics.get(ERROR, 0) > 0 and metrics.get(TIME, 0) > 0:
            option = {**match.groupdict(), "time": metrics[TIME], "error": metrics[ERROR]}
            groups.setdefault((CAMERAS[match["camera"]], match["size"]), []).append(option)
    if not groups:
        raise BadInput(f"{file}: there is no case of the globe with {TIME} and {ERROR}")
    return groups


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


def draw_options(axes, options):
    axes.plot(*front(options), color="#999999", linewidth=1, drawstyle="steps-post", zorder=1)
    for option in options:
        colour_of_mode, shape = MODES[option["mode"]][0], BITS[option["bits"]][0]
        axes.plot(option["time"], option["error"], shape, markersize=7, markeredgewidth=1.5, alpha=0.9,
                  markeredgecolor=colour_of_mode, color="white" if option["lazy"] else colour_of_mode)
        if not option["median"] or not option["lazy"]:
            continue  # a frame filtered beforehand costs its ticks nothing
        words, height = f"{option['median']}x{option['median']}", 7 if option["mode"] == "pixel" else -14
        if is_papers_own(option):
            words, height = f"the paper's own,\n{words}", 12
            axes.plot(option["time"], option["error"], "o", markersize=16, color="none",
                      markeredgecolor="black", markeredgewidth=1.5)
        axes.annotate(words, (option["time"], option["error"]), xytext=(0, height),
                      textcoords="offset points", ha="center", fontsize=7.5, color=colour_of_mode)


def option_legend():
    shape = {"linestyle": "", "markersize": 7, "markeredgewidth": 1.5}
    handles = [Patch(facecolor=colour_of_mode, label=label) for colour_of_mode, label in MODES.values()]
    handles += [Line2D([], [], marker=marker, color="#666666", label=label, **shape)
                for marker, label in BITS.values()]
    handles.append(Line2D([], [], marker="s", color="white", markeredgecolor="#666666",
                          label="filtered where touched: none, 3x3, 5x5", **shape))
    handles.append(Line2D([], [], color="#999999", linewidth=1, label="nothing is better in both"))
    return handles


def draw_pareto(arguments):
    groups = read_options(arguments.results)
    columns = min(2, len(groups))
    rows = -(-len(groups) // columns)
    figure = plt.figure(layout="constrained", figsize=(5.5 * columns + 0.5, 3.9 * rows + 1.4))
    plots, below = figure.subfigures(2, 1, height_ratios=[3.9 * rows + 0.5, 0.9])
    panels = plots.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in panels.flat[len(groups):]:
        axes.remove()
    for axes, ((camera, size), options) in zip(panels.flat, groups.items()):
        axes.set(xscale="log", yscale="log", title=f"camera {camera}, {size}")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("{x:.1g}")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.grid(which="both", color="#e4e4e4", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.margins(y=0.14)
        draw_options(axes, options)
    plots.supxlabel("CPU time of a tick (us)", fontsize=10)
    plots.supylabel("error of the force's direction (degrees RMS)", fontsize=10)
    plots.suptitle("Touching the globe, one finger: run time against error", fontsize=12)
    below.legend(handles=option_legend(), loc="center", ncol=4, fontsize=9)
    save(figure, arguments.out)


def main():
    parser = argparse.ArgumentParser(description="Draws what touchable and touchable-bench wrote.")
    commands = parser.add_subparsers(required=True, metavar="forces|paths|pareto")
    forces = commands.add_parser("forces", help="force over time, one strip per finger")
    forces.add_argument("forces", metavar="FORCES.csv")
    forces.set_defaults(draw=draw_forces)
    paths = commands.add_parser("paths", help="the proxies' paths over a frame's depth")
    paths.add_argument("export", metavar="EXPORT_DIR")
    paths.add_argument("forces", metavar="FORCES.csv")
    paths.set_defaults(draw=draw_paths)
    pareto = commands.add_parser("pareto", help="run time against error of the touch solver's options")
    pareto.add_argument("results", metavar="RESULTS.json")
    pareto.set_defaults(draw=draw_pareto)
    for command in (forces, paths, pareto):
        command.add_argument("out", metavar="OUT.png")
    arguments = parser.parse_args()
    try:
        arguments.draw(arguments)
    except BadInput as fault:
        print(f"plot.py: {fault}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
