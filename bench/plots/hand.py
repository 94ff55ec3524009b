"""What a hand just notices of a force's direction, as the records state it."""

from matplotlib.lines import Line2D

from plots.files import is_number

LINES = {"direction_seen_deg": ("seeing the scene", ":"), "direction_felt_deg": ("by touch alone", "-.")}


def noticed_degrees(figures):
    """By name. Records of before 2026-12 only have errors as a share of the first."""
    if "hand" in figures:
        return {name: figures["hand"][name] for name in LINES if is_number(figures["hand"].get(name))}
    for metrics in figures.values():
        for metric, share in metrics.items():
            degrees = metrics.get(metric.replace("_jnd", "_deg"))
            if "_jnd" in metric and is_number(share) and share > 0 and is_number(degrees):
                return {"direction_seen_deg": degrees / share}
    return {}


def draw_noticed(axes, figures):
    for name, degrees in noticed_degrees(figures).items():
        axes.axhline(degrees, color="#777777", linewidth=1, linestyle=LINES[name][1], zorder=1)


def noticed_legend(figures):
    return [Line2D([], [], color="#777777", linewidth=1, linestyle=LINES[name][1],
                   label=f"a hand notices, {LINES[name][0]}: {degrees:.3g}°")
            for name, degrees in noticed_degrees(figures).items()]
