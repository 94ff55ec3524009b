# SPDX-License-Identifier: Apache-2.0
"""Power spectral density of the force, filter by filter, as the paper's Fig. 19: from `touchable-bench paper --json`."""

import re

import matplotlib.pyplot as plt

from style import colour

CASE = "chest-320x240-8-1f-{metric}{filter}-scratch-n1"
METRICS = {"pixel": "metric pixel, the paper's", "world": "metric world, ours"}
FILTERS = {"": "no median", "-m3": "median 3x3", "-m5": "median 5x5", "-m5-t": "5x5, terraces removed (ours)"}
POINT = re.compile(r"force_psd_(?P<hz>[\d.]+)hz")
BAND = "force_band_mn"
SHOWN_FROM, BAND_FROM, BAND_TO = 2, 20, 500  # Hz


def curve_of(metrics):
    """Frequencies and densities, ascending."""
    points = [(float(match["hz"]), value) for name, value in metrics.items() if (match := POINT.fullmatch(name))]
    return sorted(point for point in points if point[0] >= SHOWN_FROM and point[1] > 0)


def curves_of(figures):
    """Per metric and filter that were measured: the curve, and the force between 20 and 500 Hz."""
    curves = {}
    for metric in METRICS:
        for number, (name, words) in enumerate(FILTERS.items()):
            case = figures.get(CASE.format(metric=metric, filter=name), {})
            if curve := curve_of(case):
                curves.setdefault(metric, []).append((number, f"{words}: {case.get(BAND, 0):.3g} mN", curve))
    return curves


def draw_panel(axes, curves):
    for number, words, curve in curves:
        hz, density = zip(*curve)
        axes.plot(hz, density, color=colour((3, 1, 2, 0)[number]), linewidth=1.5, label=words)
    axes.axvspan(BAND_FROM, BAND_TO, color="#f2f2f2", zorder=0)
    axes.set(xscale="log", yscale="log", xlim=(SHOWN_FROM, BAND_TO), xlabel="frequency (Hz)")
    ticks = [2, 5, 10, 20, 50, 100, 200, 500]
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.xaxis.set_minor_locator(plt.NullLocator())
    axes.grid(which="major", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.legend(loc="lower left", fontsize=9, title=f"between {BAND_FROM} and {BAND_TO} Hz, RMS", title_fontsize=9,
                alignment="left")


def draw_spectrum(figures):
    curves = curves_of(figures)
    if not curves:
        return None
    figure, panels = plt.subplots(1, len(curves), sharex=True, sharey=True, squeeze=False, layout="constrained",
                                  figsize=(5.4 * len(curves), 5))
    for axes, metric in zip(panels.flat, curves):
        draw_panel(axes, curves[metric])
        axes.set_title(METRICS[metric])
    panels.flat[0].set_ylabel("power spectral density of |F| (N²/Hz)")
    figure.suptitle("A scripted hand scratches a noisy chest (8 bits, noise of 1 level): the paper's Fig. 19 anew",
                    fontsize=12)
    return figure
