"""What delay and loss cost the hand, by transport, beside forces that are computed far away and sent: from
`touchable-bench stream --filter far --json`."""

import re

import matplotlib.pyplot as plt

from plots.files import read_figures, save
from style import BadInput, colour

CASE = re.compile(r"far-(?P<transport>[a-z]+)-loss-(?P<loss>\d+)-delay-(?P<delay>\d+)")
NAMES = {"tcp": "TCP", "http": "HTTP", "srt": "SRT", "ts": "MPEG-TS by SRT"}
NEEDED = ("undelayed_n", "off_n", "far_off_n")


def read_cases(file):
    """Per loss and transport: what was measured at each delay, ascending."""
    panels = {}
    for case, metrics in read_figures(file).items():
        match = CASE.fullmatch(case)
        if match and all(metric in metrics for metric in NEEDED):
            lines = panels.setdefault(int(match["loss"]), {})
            lines.setdefault(match["transport"], []).append((int(match["delay"]), metrics))
    if not panels:
        raise BadInput(f"{file}: there is no case of the suite stream with {', '.join(NEEDED)}")
    return {loss: {name: sorted(points, key=lambda point: point[0]) for name, points in lines.items()}
            for loss, lines in sorted(panels.items())}


def share(metrics, metric):
    """Of the force itself, per cent."""
    return 100 * metrics[metric] / metrics["undelayed_n"] if metrics["undelayed_n"] > 0 else 0


def draw_panel(axes, lines):
    far = {}
    for transport, points in lines.items():
        axes.plot([delay for delay, _ in points], [share(metrics, "off_n") for _, metrics in points], "o-",
                  color=colour(list(NAMES).index(transport)), linewidth=1.5, markersize=4.5, label=NAMES[transport])
        for delay, metrics in points:
            far.setdefault(delay, []).append(share(metrics, "far_off_n"))
    axes.plot(sorted(far), [sum(far[delay]) / len(far[delay]) for delay in sorted(far)], "s--", color="#555555",
              linewidth=1.5, markersize=4.5, label="force computed far away and sent")
    axes.set_xticks(sorted(far))
    axes.grid(which="major", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_xlabel("delay each way (ms)")


def draw_delay(arguments):
    panels = read_cases(arguments.results)
    figure, all_axes = plt.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False, layout="constrained",
                                    figsize=(4.2 * len(panels), 4.4))
    measured = {transport for lines in panels.values() for transport in lines}
    for axes, (loss, lines) in zip(all_axes.flat, panels.items()):
        draw_panel(axes, lines)
        missing = [NAMES[transport] for transport in NAMES if transport in measured and transport not in lines]
        if missing:
            axes.annotate(f"not measured: {', '.join(missing)}", (0.03, 0.95), xycoords="axes fraction", fontsize=8.5)
        axes.set_title(f"{loss} % lost" if loss else "nothing lost")
    all_axes.flat[0].set_ylim(bottom=0)
    all_axes.flat[0].set_ylabel("force error, RMS (% of the force)")
    figure.get_layout_engine().set(rect=(0, 0.07, 1, 0.93))  # leaves room for the legend below
    figure.legend(*all_axes.flat[0].get_legend_handles_labels(), loc="lower center", ncols=6, fontsize=9, frameon=False)
    figure.suptitle("Force beside the hand on a surface that comes late, and force that comes late itself", fontsize=12)
    save(figure, arguments.out)
