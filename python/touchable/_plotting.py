# SPDX-License-Identifier: Apache-2.0
"""What was touched as a picture: forces over time, and the ways of the fingers over the depth."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy

from ._library import encoded, of_kind
from ._touch import Touched

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_most_in_legend = 10


def plot(touched: Touched, path: str | os.PathLike | None = None, *, title: str | None = None) -> Figure:
    """Draws forces over time (newtons, seconds) beside the ways of the fingers over the touched depth (metres).

    path: a file to write, whose ending says its kind: .png, .svg, .pdf. None: nothing is written, and the figure is one
        of matplotlib.pyplot, which pyplot.show() shows. title: above it.
    Gives the matplotlib Figure. Raises ImportError where matplotlib is missing, OSError where the file cannot be written.
    """
    of_kind("touched", touched, Touched, "a touchable.Touched, as touch() and Solver.run() give it")
    if path is not None and not hasattr(path, "write"):  # matplotlib writes to an open file, too
        encoded(f"the path {path!r}", path)
    figure = _figure(path is None)
    over_depth, over_time = figure.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.15)})
    _draw_depth(figure, over_depth, touched)
    _draw_ways(over_depth, touched)
    _draw_forces(over_time, touched)
    if title:
        figure.suptitle(title)
    if path is not None:
        figure.savefig(path, dpi=120)
    return figure


def _figure(shown: bool) -> Figure:
    try:
        from matplotlib import pyplot
        from matplotlib.figure import Figure
    except ImportError as problem:
        raise ImportError(f"touchable.plot needs matplotlib ({problem}); on Debian: apt install "
                          "python3-matplotlib") from None
    options: dict[str, Any] = {"figsize": (11.5, 4.8), "constrained_layout": True}
    return pyplot.figure(**options) if shown else Figure(**options)


def _draw_depth(figure: Figure, axes: Any, touched: Touched) -> None:
    depth = touched.surface_metres
    known = depth[numpy.isfinite(depth)]
    # Otherwise a few far pixels would leave no greys for the touched surface.
    near, far = numpy.percentile(known, (1, 99)) if known.size else (0, 1)
    picture = axes.imshow(depth, cmap="Greys", vmin=near, vmax=far if far > near else near + 1e-3)
    axes.set_facecolor("#f4e3d7")  # pixels without a surface
    figure.colorbar(picture, ax=axes, label="depth [m]", shrink=0.8)
    axes.set(xlabel="column [pixels]", ylabel="row [pixels]", title="ways over the depth")


def _colours(fingers: int) -> Any:
    from matplotlib import colormaps

    return [f"C{k}" for k in range(fingers)] if fingers <= _most_in_legend else colormaps["viridis"](
        numpy.linspace(0, 0.95, fingers))


def _draw_ways(axes: Any, touched: Touched) -> None:
    pixel, touching = touched.pixel, touched.touching
    height, width = touched.surface_metres.shape
    for finger, colour in enumerate(_colours(pixel.shape[1])):
        way = pixel[:, finger]
        held = numpy.where(touching[:, finger, None], way, numpy.nan)
        axes.plot(*way.T, color=colour, linewidth=1, linestyle=":")
        axes.plot(*held.T, color=colour, linewidth=2.4)
        seen = numpy.flatnonzero(numpy.isfinite(way).all(axis=1))
        if seen.size:
            axes.plot(*way[seen[0]], marker="o", markersize=7, color=colour, markeredgecolor="white")
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
    for label, look in {"begins here": {"marker": "o", "markersize": 6, "linestyle": ""}, "in contact": {"linewidth": 2.4},
                        "free": {"linewidth": 1, "linestyle": ":"}}.items():
        axes.plot([], [], color="C0", label=label, **look)
    _legend(axes, 3)


def _legend(axes: Any, columns: int) -> None:
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncol=columns, fontsize="small", frameon=False,
                handlelength=1.3, columnspacing=1.1)


def _draw_forces(axes: Any, touched: Touched) -> None:
    force, time, fingers = touched.force_n, touched.time_s, touched.force_n.shape[1]
    if fingers == 1:
        for axis, name in enumerate(("X (right)", "Y (up)", "Z (to the camera)")):
            axes.plot(time, force[:, 0, axis], linewidth=1.1, color=f"C{axis + 1}", label=name)
        axes.plot(time, numpy.linalg.norm(force[:, 0], axis=-1), color="black", linewidth=1.4, label="magnitude")
        axes.fill_between(time, 0, 1, where=touched.touching[:, 0], transform=axes.get_xaxis_transform(),
                          color="C0", alpha=0.1, linewidth=0, label="in contact")
    else:
        for finger, colour in enumerate(_colours(fingers)):
            axes.plot(time, numpy.linalg.norm(force[:, finger], axis=-1), color=colour, linewidth=1.1,
                      label=f"finger {finger + 1}")
    axes.set(xlabel="time [s]", ylabel="force [N]",
             title="force on the finger" if fingers == 1 else "magnitude of the force on each finger")
    if len(time) > 1:
        axes.set_xlim(time[0], time[-1])
    axes.grid(alpha=0.3)
    if fingers <= _most_in_legend:
        _legend(axes, 5)
