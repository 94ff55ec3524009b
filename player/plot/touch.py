# SPDX-License-Identifier: Apache-2.0
"""What fingers felt and where they went: from `touchable touch --forces` and `touchable export`. For `touchable plot`."""

import csv
import json
from pathlib import Path

import matplotlib.image
import matplotlib.patheffects
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from style import COLOURS, BadInput, colour

GOAL = ["goal_x", "goal_y", "goal_z"]
HOP = "hop"  # files of older versions have none
NUMBERS = ["time_s", *GOAL, "force_x", "force_y", "force_z", "pixel_x", "pixel_y"]
FLAGS = ["finger", "contact", "guard"]
SHADES = {"guard": ("#999999", "changed by the guard"), HOP: ("#8fb8de", "the hand hops")}
STRIPS_AT_MOST = len(COLOURS)


def read_forces(file):
    """Per finger that was led, in order: a dict of arrays over the ticks."""
    fingers = {}
    try:
        with open(file, newline="", encoding="utf-8") as stream:
            rows = csv.DictReader(stream)
            missing = [name for name in NUMBERS + FLAGS if name not in (rows.fieldnames or [])]
            if missing:
                raise BadInput(f"{file}: is not a forces file (touchable touch --forces): no column {missing[0]}")
            for row in rows:
                try:
                    values = [float(row[name]) for name in NUMBERS] + [int(row[name]) for name in FLAGS] + [
                        int(row.get(HOP, 0))]
                except (TypeError, ValueError):
                    raise BadInput(f"{file}: line {rows.line_num}: must be numbers in every column") from None
                fingers.setdefault(values[len(NUMBERS)], []).append(values)
    except UnicodeDecodeError:
        raise BadInput(f"{file}: holds bytes that are no text: must be a forces file (touchable touch --forces)") from None
    except (OSError, csv.Error) as fault:
        raise BadInput(f"{file}: cannot be read: {fault}") from None
    if not fingers:
        raise BadInput(f"{file}: has no rows")
    read = [dict(zip([*NUMBERS, *FLAGS, HOP], np.array(fingers[finger]).T)) for finger in sorted(fingers)]
    return [finger for finger in read if was_led(finger)] or read


def was_led(finger):
    """A window has room for more fingers than anybody leads: those neither move nor touch."""
    return np.any(finger["contact"] != 0) or any(np.any(finger[axis] != finger[axis][0]) for axis in GOAL)


def magnitude(finger):
    return np.sqrt(finger["force_x"] ** 2 + finger["force_y"] ** 2 + finger["force_z"] ** 2)


def name(finger):
    return f"finger {int(finger['finger'][0]) + 1}"


def colour_of(finger):
    return colour(int(finger["finger"][0]))


def contact_share(fingers):
    return 100 * np.mean(np.concatenate([finger["contact"] for finger in fingers]) != 0)


def draw_strip(axes, finger, top):
    time, force = finger["time_s"], magnitude(finger)
    axes.fill_between(time, force, color=colour_of(finger), alpha=0.25, linewidth=0)
    axes.plot(time, force, color=colour_of(finger), linewidth=0.9)
    for column, (shade, _) in SHADES.items():
        axes.fill_between(time, top, where=finger[column] != 0, step="mid", color=shade, alpha=0.35, linewidth=0)
    axes.set_ylim(0, top)
    axes.margins(x=0)
    axes.locator_params(axis="y", nbins=4)
    axes.grid(axis="both", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    share, touching = 100 * np.mean(finger["contact"] != 0), force[finger["contact"] != 0]
    mean = f"mean {touching.mean():.2f} N" if touching.size else "no contact"
    axes.text(1.012, 0.5, f"{name(finger)}\n{share:.0f} % in contact\n{mean}\nmax {force.max():.2f} N",
              transform=axes.transAxes, va="center", fontsize=9, color="#333333", linespacing=1.35)


def draw_forces(file):
    """Force over time, one strip per finger."""
    fingers = read_forces(file)
    shown = fingers[:STRIPS_AT_MOST]
    top = 1.08 * max(magnitude(finger).max() for finger in shown) or 1.0
    if not np.isfinite(top):
        raise BadInput(f"{file}: a force is not finite")
    figure, strips = plt.subplots(len(shown), 1, sharex=True, squeeze=False, layout="constrained",
                                  figsize=(10, 1.5 + 1.2 * max(2, len(shown))))
    for axes, finger in zip(strips[:, 0], shown):
        draw_strip(axes, finger, top)
    strips[-1, 0].set_xlabel("time (s)")
    figure.supylabel("force |F| (N)", fontsize=10)
    seconds = fingers[0]["time_s"][-1] - fingers[0]["time_s"][0]
    some = "" if len(shown) == len(fingers) else f" (the first {len(shown)} shown)"
    what = "finger" if len(fingers) == 1 else "fingers"
    strips[0, 0].set_title(f"Force on {len(fingers)} {what}{some} over {seconds:.2f} s, "
                           f"{contact_share(fingers):.0f} % of ticks in contact", loc="left")
    handles = [Patch(facecolor=shade, alpha=0.35, label=words) for column, (shade, words) in SHADES.items()
               if any(np.any(finger[column] != 0) for finger in shown)]
    if handles:
        strips[0, 0].legend(handles=handles, loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False,
                            fontsize=9, borderaxespad=0.2)
    return figure


def read_plane(file):
    try:
        plane = matplotlib.image.imread(file)
    except (OSError, SyntaxError, ValueError):
        raise BadInput(f"{file}: cannot be read: must be of a folder that `touchable export` wrote") from None
    if plane.ndim != 2:
        raise BadInput(f"{file}: must be a grey picture")
    return plane


def read_scene(file):
    try:
        scene = json.loads(Path(file).read_text(encoding="utf-8"))
        depth = scene["depth"]
        near_is_high = depth["coding"] != "metric" and depth.get("near_is", "high") == "high"
        return scene.get("name", ""), near_is_high
    except (OSError, ValueError, KeyError, TypeError):
        raise BadInput(f"{file}: must be the scene.json of a folder that `touchable export` wrote") from None


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


def draw_paths(file, export):
    """The paths of the proxies over the depth of the frame in the folder `export`."""
    folder = Path(export)
    title, near_is_high = read_scene(folder / "scene.json")
    codes, valid = read_plane(folder / "codes.png"), read_plane(folder / "valid.png") > 0
    if codes.shape != valid.shape:
        raise BadInput(f"{folder / 'valid.png'}: must have the size of codes.png")
    fingers = read_forces(file)
    height, width = codes.shape
    for finger in fingers:
        x, y = stretches(finger)
        if np.nanmax(np.append(x, 0)) > width + 1 or np.nanmax(np.append(y, 0)) > height + 1:
            raise BadInput(f"{file}: fingers were beyond this frame of {width}x{height} pixels: must be a run over the "
                           f"clip that {folder} is a frame of")
    figure, axes = plt.subplots(layout="constrained", figsize=(10, 8.3 * height / width + 0.9))
    axes.imshow(shades(codes, valid, near_is_high), interpolation="nearest")
    halo = [matplotlib.patheffects.Stroke(linewidth=3.2, foreground="white", alpha=0.75),
            matplotlib.patheffects.Normal()]
    handles = []
    for finger in fingers:
        x, y = stretches(finger)
        axes.plot(x, y, color=colour_of(finger), linewidth=1.6, path_effects=halo, solid_capstyle="round")
        touching = np.flatnonzero(finger["contact"])
        if touching.size:
            first, last = touching[0], touching[-1]
            axes.plot(x[first], y[first], "o", color="white", markeredgecolor=colour_of(finger), markersize=7,
                      markeredgewidth=2)
            axes.plot(x[last], y[last], "o", color=colour_of(finger), markeredgecolor="white", markersize=8)
        handles.append(Line2D([], [], color=colour_of(finger), linewidth=3, label=name(finger)))
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
    return figure
