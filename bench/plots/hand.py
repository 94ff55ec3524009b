# SPDX-License-Identifier: Apache-2.0
"""What a hand just notices of a force's direction, as the records state it."""

from matplotlib.lines import Line2D

from plots.files import is_number

LINES = {"direction_seen_deg": ("seeing the scene", ":"), "direction_felt_deg": ("by touch alone", "-.")}


def noticed_degrees(figures):
    """By name; none in records of before 2026-12."""
    hand = figures.get("hand", {})
    return {name: hand[name] for name in LINES if is_number(hand.get(name))}


def draw_noticed(axes, figures):
    for name, degrees in noticed_degrees(figures).items():
        axes.axhline(degrees, color="#777777", linewidth=1, linestyle=LINES[name][1], zorder=1)


def noticed_legend(figures):
    return [Line2D([], [], color="#777777", linewidth=1, linestyle=LINES[name][1],
                   label=f"a hand notices, {LINES[name][0]}: {degrees:.3g}°")
            for name, degrees in noticed_degrees(figures).items()]
