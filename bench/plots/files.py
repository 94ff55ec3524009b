# SPDX-License-Identifier: Apache-2.0
"""Records of touchable-bench, and how what is drawn of them is saved."""

import io
import json
import math
import os
import re
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt

from style import BadInput


class Record(NamedTuple):
    suite: str
    case: str
    metric: str
    value: float | str  # NaN where the program wrote null
    unit: str


def record_of(row):
    record = Record(*(row[field] for field in Record._fields))
    if not all(isinstance(word, str) for word in (record.suite, record.case, record.metric, record.unit)):
        raise TypeError("suite, case, metric and unit must be words")
    value = math.nan if record.value is None else record.value
    return record._replace(value=value if isinstance(value, str) else float(value))


def is_number(value):
    return isinstance(value, float) and math.isfinite(value)


def read_records(path):
    """By suite, case and metric, of a file or of all .json files of a folder. A figure that is there twice has its last
    value."""
    files = sorted(Path(path).glob("*.json")) if os.path.isdir(path) else [path]
    records = {}
    for file in files:
        try:
            for row in json.loads(Path(file).read_text(encoding="utf-8")):
                record = record_of(row)
                records[record[:3]] = record
        except (OSError, ValueError, LookupError, TypeError, ArithmeticError, RecursionError) as fault:
            raise BadInput(f"{file}: must be what touchable-bench --json wrote: {fault}") from None
    if not records:
        raise BadInput(f"{path}: has no records; must be what touchable-bench --json wrote, or a folder of such files")
    return records


def figures_of(records, suites=()):
    """Per case, in order: its metrics, numbers and names. Of all suites, or of the first of these that is there."""
    chosen = next(([suite] for suite in suites if any(record.suite == suite for record in records.values())), suites)
    figures = {}
    for record in records.values():
        if not chosen or record.suite in chosen:
            figures.setdefault(record.case, {})[record.metric] = record.value
    return figures


def measured_once(records):
    """Without cases of the suite `targets` that the suites have that it takes them from."""
    cases = {record.case for record in records.values() if record.suite in ("touch", "surface")}
    return {key: record for key, record in records.items() if record.suite != "targets" or record.case not in cases}


def svg_of(figure, salt):
    """For a page: without what editors would read, whose addresses lead out of it."""
    plt.rcParams["svg.hashsalt"] = salt  # identifiers differ between plots, but not between runs
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    plt.close(figure)
    return re.sub(r"<metadata>.*?</metadata>", "", text.getvalue()[text.getvalue().index("<svg"):], flags=re.DOTALL)


def save(figure, out):
    """The picture appears whole or not at all."""
    save_by(lambda part: figure.savefig(part, dpi=130), out, ".png")


def save_text(text, out):
    """The file appears whole or not at all."""
    save_by(lambda part: Path(part).write_text(text, encoding="utf-8"), out, "")


def save_by(write, out, suffix):
    if os.path.exists(out) and not os.path.isfile(out):
        raise BadInput(f"{out}: is no file; must be a file, or a new name")  # a device would be replaced
    part = f"{out}.part{suffix}"
    try:
        write(part)
        os.replace(part, out)
    except OSError as fault:
        raise BadInput(f"{out}: cannot be written: {fault}") from None
    finally:
        if os.path.exists(part):
            os.remove(part)
