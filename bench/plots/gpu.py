# SPDX-License-Identifier: Apache-2.0
"""What a GPU, its builder and three ways to touch cost: from `touchable-bench gpu --json`."""

import html
import math
import re

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from style import colour

FILTERS = ["none", "m3", "m5", "terraces", "temporal"]
FILTER_NAMES = {"none": "no filter", "m3": "median 3x3", "m5": "median 5x5", "terraces": "terraces removed",
                "temporal": "temporal"}
WAYS = {"lazy": "lazy, where touched", "cpu": "whole frames, CPU", "vulkan": "whole frames, Vulkan"}
WAY_COLOURS = {"lazy": colour(2), "cpu": colour(0), "vulkan": colour(3)}
RATES = [30, 60, 120]
TURNS = re.compile(r"turns-(?P<size>\d+x\d+)-(?P<filter>[a-z]+\d?)")
FRAMES = re.compile(r"ways-(?P<size>\d+x\d+)-(?P<filter>none|m3|m5|terraces|temporal)")
CELL = re.compile(FRAMES.pattern + r"-(?P<fingers>\d+)f")
RUN = re.compile(r"ways-(?P<size>\d+x\d+)-run")
WINDOW = re.compile(r"window-(?P<size>\d+x\d+)-(?P<pair>\w+|\w+-\w+)")
RUN_METRIC = re.compile(r"(?P<filter>\w+?)_(?P<fingers>\d+)f_(?P<rate>\d+)hz_(?P<way>lazy|cpu|vulkan)_computed_ms_per_s")


def pixels(size):
    width, height = size.split("x")
    return int(width) * int(height)


def matching(figures, pattern):
    """Per case that has the pattern's name: what the name says, and the metrics."""
    found = ((pattern.fullmatch(case), metrics) for case, metrics in figures.items())
    return [(match.groupdict(), metrics) for match, metrics in found if match]


def sizes_of(cases):
    return sorted({parts["size"] for parts, _ in cases}, key=pixels)


def filters_of(cases):
    return [name for name in FILTERS if name in {parts["filter"] for parts, _ in cases}]


def rounded(value, digits=3):
    """No more digits than a comparison needs, and none with an exponent."""
    return f"{value:.{digits}g}" if value < 10**digits else f"{value:.0f}"


def log_axis(axes, label):
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_ylabel(label)
    axes.grid(which="major", axis="y", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def points(axes, groups, series, label):
    """`series`: per name a colour and a value for each group, or None."""
    width = 0.8 / len(series)
    for index, (name, (fill, values)) in enumerate(series.items()):
        places = [group + (index - (len(series) - 1) / 2) * width for group in range(len(groups))]
        shown = [(place, value) for place, value in zip(places, values) if value]
        axes.plot([place for place, _ in shown], [value for _, value in shown], "o", color=fill, markersize=5, label=name)
        for place, value in shown:
            axes.annotate(rounded(value, 2), (place, value), xytext=(0, 5), textcoords="offset points", ha="center", fontsize=7)
    axes.set_xticks(range(len(groups)), groups)
    axes.set_xlim(-0.5, len(groups) - 0.5)
    log_axis(axes, label)
    axes.margins(y=0.12)


def legend_below(figure, handles):
    """Under all panels, in as many rows as they need."""
    rows = math.ceil(2.2 * len(handles) / figure.get_figwidth())
    share = 0.28 * rows / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, share, 1, 1 - share))
    figure.legend(handles=handles, loc="lower center", ncols=-(-len(handles) // rows), fontsize=9)


# --- the machine and its builder


def draw_memory(figures):
    rows = [("device memory, copied by a kernel (read and written)", "memory", "kernel_copy_gb_s"),
            ("device memory, vkCmdCopyBuffer (read and written)", "memory", "copy_gb_s"),
            ("host to device, from mapped memory", "bus-3840x2160", "upload_gb_s"),
            ("host to device, from a reader's imported planes", "bus-3840x2160", "imported_gb_s"),
            ("device to host, to mapped memory", "bus-3840x2160", "readback_gb_s"),
            ("memcpy by the CPU, host to host", "bus-3840x2160", "memcpy_gb_s"),
            ("memcpy by the CPU, to mapped memory", "bus-3840x2160", "memcpy_to_upload_gb_s"),
            ("memcpy by the CPU, from mapped memory", "bus-3840x2160", "memcpy_from_readback_gb_s")]
    rows = [(name, figures[case][metric]) for name, case, metric in rows if metric in figures.get(case, {})]
    if not rows:
        return None
    figure, axes = plt.subplots(figsize=(9, 0.45 * len(rows) + 1), layout="constrained")
    # Points: a bar's length says nothing on a logarithmic axis.
    axes.plot([value for _, value in rows], [name for name, _ in rows], "o", color=colour(0), markersize=7)
    for name, value in rows:
        axes.annotate(f"{rounded(value)} GB/s", (value, name), xytext=(8, -3), textcoords="offset points", fontsize=8.5)
    axes.invert_yaxis()
    axes.grid(which="major", axis="x", color="#dddddd", linewidth=0.6)
    axes.set(xscale="log", xlabel="GB/s (logarithmic)")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("{x:g}")
    axes.margins(x=0.15)
    return figure


def draw_turns(figures):
    cases = matching(figures, TURNS)
    if not cases:
        return None
    sizes, filters = sizes_of(cases), filters_of(cases)
    metrics = {(parts["size"], parts["filter"]): found for parts, found in cases}
    kinds = [("ms", "wall time a frame (ms)"), ("cpu_ms", "CPU time a frame (ms)"),
             ("latency_ms", "begin to finish (ms)")]
    names = {"cpu_builder": ("CPU builder", colour(0)), "vulkan": ("Vulkan, one in flight", colour(5)),
             "flight": ("Vulkan, several in flight", colour(3))}
    figure, panels = plt.subplots(len(kinds), len(sizes), squeeze=False, sharex="col", sharey="row", layout="constrained",
                                  figsize=(5.6 * len(sizes), 2.7 * len(kinds) + 0.6))
    for column, size in enumerate(sizes):
        for row, (kind, label) in enumerate(kinds):
            series = {}
            for prefix, (name, fill) in names.items():
                values = [metrics.get((size, chosen), {}).get(f"{prefix}_{kind}") for chosen in filters]
                if any(values):
                    series[name] = (fill, values)
            if row == 0:
                kernels = [metrics.get((size, chosen), {}).get("kernels_ms") for chosen in filters]
                series["kernels, by the device's clock"] = ("#888888", kernels)
            axes = panels[row][column]
            points(axes, [FILTER_NAMES[chosen].replace(" ", "\n") for chosen in filters], series, label if column == 0 else "")
            if row == 0:
                axes.set_title(size)
            if column == 0 and row == 0:
                handles, _ = axes.get_legend_handles_labels()
    legend_below(figure, handles)
    return figure


def draw_jitter(figures):
    cases = [(case, metrics) for case, metrics in figures.items() if case.startswith("jitter-")]
    if not cases:
        return None
    figure, panels = plt.subplots(1, len(cases), squeeze=False, layout="constrained", figsize=(7 * len(cases), 3.4))
    for axes, (case, metrics) in zip(panels.flat, cases):
        series = {name: (fill, [metrics.get(f"{prefix}_late_us_{part}") for part in ("p50", "p99", "p999")])
                  for prefix, name, fill in (("alone", "ticks alone", "#888888"),
                                             ("cpu", "beside frames by the CPU", WAY_COLOURS["cpu"]),
                                             ("vulkan", "beside frames by Vulkan", WAY_COLOURS["vulkan"]))}
        points(axes, ["median", "99 %", "99.9 %"], series, "tick begins late by (µs)")
        axes.axhline(1000, color="#999999", linewidth=0.8, linestyle=":")
        axes.annotate("a whole tick", (0.0, 1000), xycoords=("axes fraction", "data"), xytext=(3, 2),
                      textcoords="offset points", fontsize=8, color="#666666")
        axes.set_title(f"{case.removeprefix('jitter-')}, " +
                       ("SCHED_FIFO" if metrics.get("fifo") else "ordinary priority"))
        axes.legend(fontsize=8.5)
    return figure


def draw_pictures(figures):
    cases = [(case, metrics) for case, metrics in figures.items() if case.startswith("pictures-")]
    if not cases:
        return None
    figure, panels = plt.subplots(1, len(cases), squeeze=False, layout="constrained", figsize=(7.5 * len(cases), 3.4))
    for axes, (case, metrics) in zip(panels.flat, cases):
        pairs = [(painter, builder) for painter in ("raster", "mesh") for builder in ("cpu", "vulkan")]
        words = {"cpu": "CPU", "vulkan": "Vulkan"}
        series = {name: (fill, [metrics.get(f"{painter}_{builder}{suffix}") for painter, builder in pairs])
                  for name, suffix, fill in (("surface shown and drawn", "_ms", colour(5)),
                                             ("with the frame built before", "_frame_ms", colour(0)),
                                             ("CPU time of that", "_frame_cpu_ms", "#888888"))}
        points(axes, [f"{painter},\n{words[builder]} builder" for painter, builder in pairs], series,
             "time a picture (ms)")
        axes.set_title(case.removeprefix("pictures-"))
        axes.legend(fontsize=8.5)
    return figure


def draw_windows(figures):
    cases = matching(figures, WINDOW)
    if not cases:
        return None
    sizes = sizes_of(cases)
    widths = [max(2, sum(parts["size"] == size for parts, _ in cases)) for size in sizes]
    figure, panels = plt.subplots(1, len(sizes), squeeze=False, sharey=True, layout="constrained", width_ratios=widths,
                                  figsize=(1.7 * sum(widths) + 1, 4))
    for axes, size in zip(panels.flat, sizes):
        here = [(parts, metrics) for parts, metrics in cases if parts["size"] == size and metrics]
        groups = [("auto:\n" if parts["pair"] == "auto" else "") + f"{metrics['painter']}, {metrics['builder']}\n"
                  f"{metrics['frames_in_time_pct']:.0f} % in time\nfirst {rounded(metrics['first_picture_ms'])} ms"
                  for parts, metrics in here]
        points(axes, groups, {name: (fill, [metrics[metric] for _, metrics in here])
                            for name, metric, fill in (("a picture, median", "picture_ms_p50", colour(5)),
                                                       ("99 %", "picture_ms_p99", colour(0)),
                                                       ("CPU time", "cpu_ms_per_picture", "#888888"))}, "ms")
        axes.set_title(f"clip of {size}")
    legend_below(figure, panels[0][0].get_legend_handles_labels()[0])
    return figure


# --- three ways


def draw_seconds(figures):
    """What a second costs over the fingers: a line at 60 frames/s, from 30 to 120 the band around it."""
    cases = matching(figures, CELL)
    if not cases:
        return None
    sizes, filters = sizes_of(cases), filters_of(cases)
    figure, panels = plt.subplots(len(filters), len(sizes), squeeze=False, sharex=True, sharey=True, layout="constrained",
                                  figsize=(2.55 * len(sizes) + 1.2, 2.05 * len(filters) + 0.8))
    for row, chosen in enumerate(filters):
        for column, size in enumerate(sizes):
            axes = panels[row][column]
            here = sorted(((int(parts["fingers"]), metrics) for parts, metrics in cases
                           if parts["size"] == size and parts["filter"] == chosen), key=lambda point: point[0])
            for way, fill in WAY_COLOURS.items():
                points = [(fingers, [metrics[f"{way}_ms_per_s_{rate}hz"] for rate in RATES])
                          for fingers, metrics in here if f"{way}_ms_per_s_30hz" in metrics]
                if not points:
                    if here:
                        axes.annotate(f"{way}: not possible", (0.03, 0.03), xycoords="axes fraction", fontsize=8,
                                      color=fill)
                    continue
                fingers, costs = [point[0] for point in points], np.array([point[1] for point in points])
                axes.fill_between(fingers, costs[:, 0], costs[:, 2], color=fill, alpha=0.18, linewidth=0)
                axes.plot(fingers, costs[:, 1], "o-", color=fill, markersize=3, linewidth=1.3)
            axes.set(xscale="log", yscale="log")
            axes.set_xticks(sorted({int(parts["fingers"]) for parts, _ in cases}),
                            sorted({parts["fingers"] for parts, _ in cases}, key=int))
            axes.xaxis.set_minor_locator(plt.NullLocator())
            axes.yaxis.set_major_formatter("{x:g}")
            axes.axhline(1000, color="#999999", linewidth=0.8, linestyle=":")
            axes.grid(which="major", axis="y", color="#e4e4e4", linewidth=0.6)
            if row == 0:
                axes.set_title(size, fontsize=11)
            if column == 0:
                axes.set_ylabel(FILTER_NAMES[chosen])
    figure.supylabel("CPU time of a second (ms, logarithmic)", fontsize=10)
    for axes in panels[-1]:
        axes.set_xlabel("fingers")
    legend_below(figure, [Line2D([], [], color=fill, marker="o", markersize=4, label=WAYS[way])
                          for way, fill in WAY_COLOURS.items()] +
                 [Line2D([], [], color="#999999", linestyle=":", label="one core, whole")])
    return figure


def cheapest(frames, metrics, rate):
    """The way with the least CPU time of those that keep up with the rate, and how much more the next one takes."""
    costs = sorted((metrics[f"{way}_ms_per_s_{rate}hz"], way) for way in WAYS
                   if f"{way}_ms_per_s_{rate}hz" in metrics and rate * frames.get(f"{way}_frame_ms", 0) < 1000)
    if not costs:
        return None, None
    return costs[0][1], costs[1][0] / costs[0][0] if len(costs) > 1 else None


def draw_map(figures):
    cells = matching(figures, CELL)
    if not cells:
        return None
    frames = {(parts["size"], parts["filter"]): metrics for parts, metrics in matching(figures, FRAMES)}
    sizes, filters = sizes_of(cells), filters_of(cells)
    counts = sorted({int(parts["fingers"]) for parts, _ in cells})
    found = {(parts["size"], parts["filter"], int(parts["fingers"])): metrics for parts, metrics in cells}
    rows = [(size, chosen) for size in sizes for chosen in filters]
    columns = [(rate, count) for rate in RATES for count in counts]
    figure, axes = plt.subplots(figsize=(0.62 * len(columns) + 3, 0.3 * len(rows) + 1.3), layout="constrained")
    for y, (size, chosen) in enumerate(rows):
        for x, (rate, count) in enumerate(columns):
            metrics = found.get((size, chosen, count))
            if not metrics:
                continue
            way, ratio = cheapest(frames.get((size, chosen), {}), metrics, rate)
            axes.add_patch(plt.Rectangle((x - 0.47, y - 0.44), 0.94, 0.88, color=WAY_COLOURS.get(way, "#dddddd")))
            words = "none" if not way else rounded(ratio, 2) if ratio else "only"
            axes.text(x, y, words, ha="center", va="center", fontsize=8, color="white" if way else "#666666")
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5))
    axes.set_xticks(range(len(columns)), [str(count) for _, count in columns])
    axes.set_yticks(range(len(rows)), [f"{size}  {FILTER_NAMES[chosen]}" for size, chosen in rows], fontsize=8.5)
    axes.tick_params(length=0)
    axes.set_xlabel("fingers")
    for index, rate in enumerate(RATES):
        middle = (index + 0.5) * len(counts) - 0.5
        axes.annotate(f"{rate} frames/s", (middle, 1), xycoords=("data", "axes fraction"), xytext=(0, 5),
                      textcoords="offset points", ha="center", fontsize=10)
        if index:
            axes.axvline(index * len(counts) - 0.5, color="white", linewidth=4)
    for index in range(1, len(sizes)):
        axes.axhline(index * len(filters) - 0.5, color="#444444", linewidth=0.8)
    for spine in axes.spines.values():
        spine.set_visible(False)
    legend_below(figure, [Patch(color=fill, label=WAYS[way]) for way, fill in WAY_COLOURS.items()] +
                 [Patch(color="#dddddd", label="none keeps up")])
    return figure


def draw_errors(figures):
    cases = matching(figures, FRAMES)
    if not cases:
        return None
    sizes, filters = sizes_of(cases), filters_of(cases)
    found = {(parts["size"], parts["filter"]): metrics for parts, metrics in cases}
    figure, panels = plt.subplots(len(filters), len(sizes), squeeze=False, sharex=True, sharey=True, layout="constrained",
                                  figsize=(2.55 * len(sizes) + 1.2, 1.9 * len(filters) + 0.8))
    for row, chosen in enumerate(filters):
        for column, size in enumerate(sizes):
            axes, metrics = panels[row][column], found.get((size, chosen), {})
            for index, (way, fill) in enumerate(WAY_COLOURS.items()):
                values = [metrics.get(f"{way}_error_n_{rate}hz") for rate in RATES]
                if all(value is not None for value in values):
                    axes.plot(RATES, values, "osD"[index], linestyle=("-", "--", ":")[index], color=fill,
                              markersize=5 - index, linewidth=1.5, label=WAYS[way])
                elif metrics:
                    fault = "a frame takes over 1 s" if f"{way}_frame_ms" in metrics else "not possible"
                    axes.annotate(f"{way}: {fault}", (0.04, 0.4 - 0.1 * index), xycoords="axes fraction", fontsize=8, color=fill)
            if "filter_error_n" in metrics:
                axes.axhline(metrics["filter_error_n"], color="#666666", linewidth=0.9)
            axes.set(xscale="log", yscale="log")
            axes.set_xticks(RATES, [str(rate) for rate in RATES])
            axes.xaxis.set_minor_locator(plt.NullLocator())
            axes.yaxis.set_major_formatter("{x:g}")
            axes.grid(which="major", axis="y", color="#e4e4e4", linewidth=0.6)
            if row == 0:
                axes.set_title(size, fontsize=11)
            if column == 0:
                axes.set_ylabel(FILTER_NAMES[chosen])
    figure.supylabel("force error, RMS (N, logarithmic)", fontsize=10)
    for axes in panels[-1]:
        axes.set_xlabel("frames a second")
    legend_below(figure, [Line2D([], [], color=fill, marker="osD"[index], linestyle=("-", "--", ":")[index], label=WAYS[way])
                          for index, (way, fill) in enumerate(WAY_COLOURS.items())] +
                 [Line2D([], [], color="#666666", linewidth=0.9, label="without age: the filter's own")])
    return figure


def runs_of(figures):
    """Per run: where, and what it cost beside what was computed."""
    runs = []
    for parts, metrics in sorted(matching(figures, RUN), key=lambda run: pixels(run[0]["size"])):
        for metric, computed in metrics.items():
            match = RUN_METRIC.fullmatch(metric)
            if match:
                start = metric.removesuffix("computed_ms_per_s")
                runs.append({"where": f"{parts['size']}, {FILTER_NAMES[match['filter']]}, {match['fingers']} fingers, "
                                      f"{match['rate']} frames/s", "way": match["way"], "computed": computed,
                             **{key: metrics[f"{start}run_{key}"] for key in
                                ("ms_per_s", "frames_per_s", "latency_ms", "late_us_p50", "late_us_p99", "late_us_p999")}})
    return runs


def draw_runs(figures):
    runs = runs_of(figures)
    if not runs:
        return None
    figure, axes = plt.subplots(figsize=(9, 0.36 * len(runs) + 1.3), layout="constrained")
    for y, run in enumerate(runs):
        axes.plot(run["computed"], y, "o", color="white", markeredgecolor=WAY_COLOURS[run["way"]], markersize=7)
        if run["ms_per_s"] <= 0:  # the empty ticks cost more, because other programs ran
            axes.annotate("run: lost in noise", (run["computed"], y), xytext=(8, -3), textcoords="offset points",
                          fontsize=8, color="#666666")
            continue
        axes.plot([run["computed"], run["ms_per_s"]], [y, y], color="#bbbbbb", linewidth=2, zorder=0)
        axes.plot(run["ms_per_s"], y, "o", color=WAY_COLOURS[run["way"]], markersize=7)
    axes.set_yticks(range(len(runs)), [f"{run['where']}: {run['way']}" for run in runs], fontsize=8.5)
    axes.invert_yaxis()
    axes.set(xscale="log", xlabel="CPU time of a second (ms, logarithmic)")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(which="major", axis="x", color="#e4e4e4", linewidth=0.6)
    legend_below(figure, [Line2D([], [], linestyle="", marker="o", color="white", markeredgecolor="#444444", label="computed"),
                          Line2D([], [], linestyle="", marker="o", color="#444444", label="run")])
    return figure


# --- the page

SECTIONS = [
    ("Memory and bus", draw_memory,
     "How fast bytes move. On the device the bytes of both directions count; between host and device those of one. Frames of "
     "3840x2160 have 16.6 MB each; 16 different ones are copied in turn, so that no cache has them."),
    ("Frames in turn", draw_turns,
     "What a frame costs each builder when frames follow each other without a pause and every pixel of each is new. Wall and "
     "CPU time are those of the best round, latency is the median. CPU time is that of all threads; a software Vulkan spends "
     "its kernels there."),
    ("Jitter of the haptic thread", draw_jitter,
     "How late ticks of one millisecond begin while a builder makes frames without a pause."),
    ("Pictures", draw_pictures,
     "A picture by each GPU painter, of frames by each builder. Frames of the Vulkan builder stay on the device; those of the "
     "CPU builder are sent there."),
    ("A whole window", draw_windows,
     "A window of 1920x1080 over a clip that plays at 30 frames a second, turned by 30 degrees, while five fingers press: what a "
     "person gets, by painter and builder. CPU time is that of all threads for each picture, decoding and touch included."),
    ("Which way costs least", draw_map,
     "The way with the least CPU time of those that keep up with the frames. The number is what the next cheapest way costs, "
     "as a multiple: near 1 is a crossover; only: no other way keeps up."),
    ("What a second costs", draw_seconds,
     "Frames a second x CPU time of a frame + 1000 x CPU time of a tick. The line is 60 frames/s, the band reaches from 30 to "
     "120. Lazy filters the touched pixels in the ticks; whole frames leave ticks short."),
    ("Computed and run", draw_runs,
     "The cells nearest to a crossover, run in real time: CPU time of the process less that of empty ticks. Ticks in real time "
     "find cold caches, so they cost more than ticks in a loop, which the computation uses."),
    ("Force error on a moving surface", draw_errors,
     "A surface rises and falls by 20 mm in half a second, followed by a hand. The felt frame is as old as its latency, plus up "
     "to the time between two frames. All ways give the same bits, so the error is the age's and the filter's. The grey line is "
     "the filter's alone."),
]

def facts_of(figures):
    machine, memory = figures.get("machine", {}), figures.get("memory", {})
    facts = [("cores", machine.get("cores"), ""), ("load before", machine.get("load_1m_begin"), ""),
             ("load after", machine.get("load_1m_end"), ""),
             ("empty submission", memory.get("empty_submission_us"), "µs")]
    words = [f"{name} {rounded(value)} {unit}".strip() for name, value, unit in facts if value is not None]
    if "gpu_driver" in machine:
        words.insert(0, f"driver {machine['gpu_driver']}, Vulkan {machine['vulkan']}")
    if "on_gpu" in memory:
        words.insert(0, "a GPU" if memory["on_gpu"] else "a software Vulkan: the GPU is the CPU")
        words.append("imports host memory" if memory.get("imports_memory") else "imports no host memory")
    return "; ".join(words)


def run_table(figures):
    runs = runs_of(figures)
    if not runs:
        return ""
    heads = ["cell", "way", "computed, ms/s", "run, ms/s", "frames/s", "latency, ms", "late p50, µs", "p99", "p99.9"]
    keys = ["computed", "ms_per_s", "frames_per_s", "latency_ms", "late_us_p50", "late_us_p99", "late_us_p999"]
    rows = ["".join(f"<td>{html.escape(run[key])}</td>" for key in ("where", "way")) +
            "".join(f'<td class="n">{rounded(run[key])}</td>' for key in keys) for run in runs]
    return ('<div class="table"><table><tr>' + "".join(f"<th>{head}</th>" for head in heads) + "</tr>" +
            "".join(f"<tr>{row}</tr>" for row in rows) + "</table></div>")
