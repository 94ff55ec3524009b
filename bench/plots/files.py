"""Reports of touchable-bench, and how pictures of them are saved."""

import json
import os
from pathlib import Path

from style import BadInput


def read_figures(file):
    """Per case of a report, in order: its metrics, numbers and names."""
    figures = {}
    try:
        for row in json.loads(Path(file).read_text(encoding="utf-8")):
            value = row["value"]
            figures.setdefault(row["case"], {})[row["metric"]] = value if isinstance(value, str) else float(value)
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise BadInput(f"{file}: must be what touchable-bench --json wrote: {fault}") from None
    return figures


def save(figure, out):
    """The picture appears whole or not at all."""
    save_by(lambda part: figure.savefig(part, dpi=130), out, ".png")


def save_text(text, out):
    """The file appears whole or not at all."""
    save_by(lambda part: Path(part).write_text(text, encoding="utf-8"), out, "")


def save_by(write, out, suffix):
    part = f"{out}.part{suffix}"
    try:
        write(part)
        os.replace(part, out)
    except OSError as fault:
        raise BadInput(f"{out}: cannot be written: {fault}") from None
    finally:
        if os.path.exists(part):
            os.remove(part)
