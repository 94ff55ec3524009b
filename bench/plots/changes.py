# SPDX-License-Identifier: Apache-2.0
"""What got worse and better from older records to newer ones, as far as the change is more than noise."""

import math
import re
import statistics
from typing import NamedTuple

from plots.files import is_number, measured_once

# What is better where no target says so: of a name first, then of a unit. More or less of anything else is only a change.
NEITHER = re.compile(r"tiles_pct|force_n_mean|true_force|(depth|level)_mm|papers_|_theory|colgate|gil_|abbott|in_flight|^median$|"
                     r"painter|builder$|presses|^points|psd|normal_n|free_|cone_|bar_deg")
MORE = re.compile(r"(frames|pictures|ticks|gb|mb)_(per_)?s(_|$)|boundary|bandwidth|in_time|cores_left|nearly_best|"
                  r"trust_is_right|contact_pct|pen_pct|least_detail|^whole$")
LESS = re.compile(r"(^|_)vs_|_over_|roots|bytes|times_(best|first|off)|worse_than|lost|torn|dropped|tunnelled|non_minima|mismatch|capped|"
                  r"off_surface|late_|ghost|over_20deg|changed_pct|untrusted|primitives|events|cells_per_tick|cpu_pct|cores_used")
LESS_UNITS = {"ns", "us", "ms", "deg", "JND", "mJ", "mN", "N", "mm", "px", "KB", "MB", "dB", "ticks"}

# How much a figure varies from run to run on the same machine (README.md, "How time is taken").
OF_THE_MOMENT = re.compile(r"preempted|gaps_pct|overhead|^load")  # says how busy the machine was
RARE = re.compile(r"_p9|_max|late_|longest")  # a time that few ticks decide
TIMED = re.compile(r"(^|_)vs_|_per_s|roots|_gb_s")
TIME_UNITS = {"ns", "us", "ms", "GB/s", "MB/s"}
REAL_TIME = {"live", "play", "stream", "gpu"}  # suites in which threads and the machine decide counts, too


class Change(NamedTuple):
    record: object
    old: float | str
    verdict: str  # "worse", "better" or "changed"

    @property
    def size(self):
        """How many times as much or as little."""
        if not all(is_number(value) and value for value in (self.old, self.record.value)):
            return math.inf
        less, more = sorted((abs(self.old), abs(self.record.value)))
        return more / less


def better_of(records):
    """Of a record: 1 where more is better, -1 where less is, 0 where that is not known. Targets know best."""
    targets = {}
    for record in records.values():
        if record.case.startswith("target: ") and record.metric == "limit":
            of = records.get((record.suite, record.case, "metric"))
            if of and record.value:
                targets[of.value] = 1 if str(record.value).startswith(">") else -1

    def better(record):
        if record.metric in targets:
            return targets[record.metric]
        if isinstance(record.value, str) or NEITHER.search(record.metric):
            return 0
        if MORE.search(record.metric):
            return 1
        return -1 if LESS.search(record.metric) or record.unit in LESS_UNITS else 0

    return better


def is_time(record):
    return record.unit in TIME_UNITS or "vs_ffv1" not in record.metric and bool(TIMED.search(record.metric))


def noise(record):
    """The share by which it may change unnoticed. None: it says nothing about the program."""
    if OF_THE_MOMENT.search(record.metric) or record.case in ("machine", "hand") or record.case.startswith("target: "):
        return None
    if is_time(record):
        if "roots" in record.metric and "p99" not in record.metric:
            return 0.10 if "3840x2160" in record.case else 0.05
        return 1.0 if RARE.search(record.metric) else 0.15
    # Others are the same bits on each run. Whether bits changed is for tests: a change counts that a reader can tell.
    return 0.15 if record.suite in REAL_TIME else 0.01


def is_noise(old, record, share):
    new = record.value
    if not (is_number(old) and is_number(new)):
        return str(old) == str(new)
    if record.unit == "%" and record.suite in REAL_TIME and abs(old - new) <= 1:
        return True  # of ticks that are late, say, where none were
    return abs(old - new) <= share * min(abs(old), abs(new))


def changes(new, old):
    """Those of errors and counts first, and largest first."""
    better, found = better_of(new), []
    for key, record in measured_once(new).items():
        share = noise(record)
        if share is None or key not in old or is_noise(old[key].value, record, share):
            continue
        was, sense = old[key].value, better(record)
        if sense == 0 or isinstance(was, str):
            verdict = "changed"
        elif not is_number(was) or not is_number(record.value):
            verdict = "better" if is_number(record.value) else "worse"
        else:
            more = abs(record.value) - abs(was) if record.unit == "mm" else record.value - was  # distances have a sign
            verdict = "better" if more * sense > 0 else "worse"
        found.append(Change(record, was, verdict))
    return sorted(found, key=lambda change: (is_time(change.record), -change.size))


def times_ratio(new, old):
    """Median of all times over the older ones: what another machine, or its load, does to all of them."""
    ratios = [record.value / old[key].value for key, record in new.items()
              if key in old and record.unit in ("ns", "us", "ms") and noise(record) == 0.15 and
              is_number(record.value) and is_number(old[key].value) and old[key].value > 0]
    return statistics.median(ratios) if ratios else None


def machines_differ(new, old):
    """What the records of both machines say otherwise, or only the newer ones say."""
    facts = ({record.metric: record.value for record in records.values() if record.case == "machine"} for records in (old, new))
    was, is_now = facts
    return [(metric, was.get(metric, "not recorded"), is_now[metric]) for metric in ("cpu", "cores", "gpu", "quick")
            if metric in is_now and was.get(metric) != is_now[metric]]
