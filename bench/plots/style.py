"""What all pictures share: colours, how they are saved, and how input that cannot be used is refused."""

import json
import os
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Okabe and Ito's colours: told apart by every kind of eye, and over grey.
COLOURS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442"]

plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False,
                     "axes.edgecolor": "#666666", "axes.titlesize": 12, "legend.frameon": False})


class BadInput(Exception):
    """What is wrong, where, and what would be right."""


def colour(index):
    return COLOURS[index % len(COLOURS)]


def read_figures(file):
    """Per case of a report, in order: its metrics."""
    figures = {}
    try:
        for row in json.loads(Path(file).read_text(encoding="utf-8")):
            figures.setdefault(row["case"], {})[row["metric"]] = float(row["value"])
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise BadInput(f"{file}: must be what touchable-bench --json wrote: {fault}") from None
    return figures


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
