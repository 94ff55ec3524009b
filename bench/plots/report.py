# SPDX-License-Identifier: Apache-2.0
"""One page of all records, without a network or a script: what is best, what got worse, and each figure with its command."""

import html
import math
import re

from plots.best import answers
from plots.changes import changes, machines_differ, times_ratio
from plots.detail import draw_detail
from plots.files import figures_of, is_number, svg_of
from plots.gpu import SECTIONS as GPU_SECTIONS
from plots.gpu import facts_of, run_table
from plots.pareto import draw_pareto
from plots.spectrum import draw_spectrum
from plots.stability import draw_stability

UNITS = {"us": "µs", "deg": "°"}
SHOWN = 8  # rows of a long table; the others fold
TABLE_1 = re.compile(r"globe-(?P<size>\d+x\d+)-8-(?P<fingers>\d+)f-(?P<way>world-t|pixel-m3-lazy)-circle")
TABLE_1_WAYS = {"pixel-m3-lazy": "The paper's method (pixels and levels, median where touched)",
                "world-t": "Ours (world space, terraces removed before)"}
MACHINE = {"cpu": "processor", "cores": "number of cores", "gpu": "GPU", "quick": "--quick (1: yes)"}
PLOTS = [
    ("Run time against error", draw_pareto, ("touch", "targets"), ".",
     "Left is faster, down is more exact. Below the dotted lines a hand does not notice that a force points elsewhere than it "
     "should: 1 JND (just noticeable difference)."),
    ("Detail against noise", draw_detail, ("touch",), "real-detail",
     "What filters leave of noise, and the least relief they keep."),
    ("Spectrum of the force", draw_spectrum, ("paper",), "scratch",
     "The paper's Fig. 19 anew: what a median does to noise that a hand feels."),
    ("Stability", draw_stability, ("loop",), ".", "The stiffness up to which a held finger does not shake, beside theory."),
]
STYLE = """
:root { color-scheme: light }
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 76rem; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.7rem; margin: 0 0 .3rem } h3 { font-size: 1rem; margin: 1.6rem 0 .3rem }
h2 { font-size: 1.3rem; margin: 2.6rem 0 .4rem; padding-top: .5rem; border-top: 2px solid #222 }
p { max-width: 54rem; margin: .3rem 0 .8rem } svg { max-width: 100%; height: auto }
nav a { margin-right: 1.1rem } a { color: #0072B2 } code { font-size: .78rem; color: #555 }
table { border-collapse: collapse; font-size: .85rem; font-variant-numeric: tabular-nums }
.table { overflow-x: auto; margin: .4rem 0 .8rem } th { text-align: left; font-weight: 600; vertical-align: bottom }
td, th { padding: .15rem 1.1rem .15rem 0; border-bottom: 1px solid #e4e4e4; white-space: nowrap } p code { white-space: nowrap }
td code { display: block; min-width: 20rem; white-space: normal; overflow-wrap: anywhere } td.n, th.n { text-align: right }
.worse, .missed { color: #a83c00 } .better { color: #00694d } .note { color: #666; font-size: .9rem }
details { margin: .3rem 0 } summary { cursor: pointer; font-size: .9rem } details details { margin-left: 1.2rem }
"""


class Raw(str):
    """Markup, not words."""


def escaped(words):
    return words if isinstance(words, Raw) else html.escape(str(words))


def number(value, unit=""):
    """With as many digits as a comparison needs."""
    if isinstance(value, str):
        return value
    if not is_number(value):
        return "none"
    words = f"{value:,.0f}" if value == round(value) or abs(value) >= 1000 else f"{value:#.3g}".strip(".")
    words = re.sub(r"\.?e([+-])0*(\d+)", lambda power: "e" + power[1].strip("+") + power[2], words)
    return f"{words}{'' if unit == 'deg' else ' '}{UNITS.get(unit, unit)}".strip()


def table(heads, rows, numbers=()):
    """`numbers`: columns to align right."""
    def cells(row, tag):
        return "".join(f"<{tag}{' class=n' if column in numbers else ''}>{escaped(word)}</{tag}>"
                       for column, word in enumerate(row))

    return Raw(f"<div class=table><table><tr>{cells(heads, 'th')}</tr>" +
               "".join(f"<tr>{cells(row, 'td')}</tr>\n" for row in rows) + "</table></div>")


def folded(words, inner, is_open=False):
    return Raw(f"<details{' open' if is_open else ''}><summary>{escaped(words)}</summary>{inner}</details>")


def long_table(heads, rows, numbers=()):
    shown = table(heads, rows[:SHOWN], numbers)
    return shown + folded(f"{len(rows) - SHOWN} more", table(heads, rows[SHOWN:], numbers)) if len(rows) > SHOWN else shown


def count(number, noun):
    return f"{number} {noun}{'' if number == 1 else 's'}"


class Page:
    def __init__(self, records):
        self.records = records
        self.machines = {}
        for record in records.values():
            suite = self.machines.setdefault(record.suite, {})
            if record.case == "machine":
                suite[record.metric] = record.value
        self.parts, self.titles = [], []

    def command(self, suite, case=""):
        words = f"touchable-bench {suite}" + (" --quick" if self.machines[suite].get("quick") == 1 else "")
        return Raw(f"<code>{html.escape(words + (f' --filter {case}' if case else ''))}</code>")

    def command_of(self, record):
        return self.command(record.suite, record.case)

    def section(self, title, *parts):
        name = re.sub(r"\W+", "-", title.lower())
        self.titles.append((name, title))
        self.parts.append(f"<h2 id={name}>{html.escape(title)}</h2>" + "".join(parts))

    # --- sections

    def add_summary(self):
        rows = [(suite, sum(record.suite == suite for record in self.records.values()), facts.get("commit", "not recorded"),
                 facts.get("date", "not recorded"), number(facts.get("load_1m_begin", math.nan)),
                 number(facts.get("load_1m_end", math.nan)), self.command(suite)) for suite, facts in self.machines.items()]
        heads = ("suite", "figures", "commit", "day", "load before", "after", "command")
        self.section("Suites and targets", table(heads, rows, (1, 4, 5)), *self.targets())

    def targets(self):
        rows = {}
        for record in self.records.values():
            if record.case.startswith("target: "):
                rows.setdefault((record.suite, record.case), {})[record.metric] = record
        if not rows:
            yield "<p class=note>These records state no targets.</p>"
            return
        lines = {"MISSED": [], "met": [], "not asked here": [], "": []}
        for (suite, case), target in rows.items():
            words = {metric: number(record.value, record.unit) for metric, record in target.items()}
            limit = words.get("limit", "").replace(" us", " µs").replace(" deg", "°")
            lines.setdefault(words.get("verdict"), []).append((
                case.removeprefix("target: "), limit, words.get("worst", "nothing"),
                self.command(suite, words.get("worst_case", ""))))
        heads = ("target", "wanted", "measured, worst case", "command")
        yield (f"<p><b>{count(len(lines['met']), 'target')} met, {len(lines['MISSED'])} missed</b>, "
               f"{len(lines['not asked here'])} not asked on this machine.</p>")
        if lines["MISSED"]:
            yield "<h3 class=missed>Missed</h3>" + table(heads, lines["MISSED"], (1, 2))
        yield folded("All that are met", table(heads, lines["met"], (1, 2)))

    def add_changes(self, old, name):
        found = changes(self.records, old)
        here, before = set(self.records), set(old)
        parts = [f"<p>Against <code>{html.escape(name)}</code>: {count(len(here & before), 'figure')} in both, "
                 f"{len(here - before)} only here, {len(before - here)} only there. A time counts as changed from 15 % on, one "
                 "in square roots from 5 % (at 3840x2160 from 10 %), a largest one or a percentile from twice as long on: that is "
                 "how much runs on one machine differ. Errors and counts have the same bits on each run, so they count from 1 % "
                 "on (those of threads in real time from 15 %, and shares from a point on).</p>"]
        if ratio := times_ratio(self.records, old):
            parts.append(f"<p>All times together: {ratio:.3g} times the older ones (median).</p>")
        for metric, was, is_now in machines_differ(self.records, old):
            what = "Errors and counts may differ" if metric == "quick" else "Times differ"
            parts.append(f"<p class=note><b>Not the same {MACHINE[metric]}</b>: {escaped(number(was))} there, "
                         f"{escaped(number(is_now))} here. {what} for that alone.</p>")
        heads = ("case", "figure", "before", "now", "times", "command")
        for verdict, title in (("worse", "Worse"), ("better", "Better"), ("changed", "Changed, neither better nor worse")):
            rows = [(change.record.case, change.record.metric, number(change.old, change.record.unit),
                     number(change.record.value, change.record.unit), self.ratio(change), self.command_of(change.record))
                    for change in found if change.verdict == verdict]
            parts.append(f"<h3 class={verdict}>{title}: {count(len(rows), 'figure')}</h3>" +
                         (long_table(heads, rows, (2, 3, 4)) if rows else "<p class=note>Nothing.</p>"))
        self.section("What got worse and better", *parts)

    @staticmethod
    def ratio(change):
        old, new = change.old, change.record.value
        return "" if not math.isfinite(change.size) else number(new / old)

    def add_best(self):
        parts = ["<p>Ways to do the same thing, compared within these records. Times: how far the next best way is behind. "
                 "In names m3 and m5 are medians, t is the removal of terraces, lazy filters where it is touched.</p>"]
        for question, rows in answers(self.records):
            lines = [(best.where, best.way, number(best.record.value, best.record.unit), best.next_way,
                      number(best.next.value, best.next.unit), self.behind(best.record.value, best.next.value),
                      self.command_of(best.record)) for best in rows]
            parts.append(f"<h3>{html.escape(question)}</h3>" +
                         long_table(("where", "best", "", "next", "", "times", "command"), lines, (2, 4, 5)))
        if len(parts) > 1:
            self.section("What is best", *parts)

    @staticmethod
    def behind(best, other):
        return number(max(best, other) / min(best, other)) if min(best, other) > 0 else ""

    def add_table_1(self):
        found = {}
        for case, metrics in figures_of(self.records, ("paper",)).items():
            if (match := TABLE_1.fullmatch(case)) and "tick_us_mean" in metrics:
                found.setdefault(match["way"], {})[match["size"], int(match["fingers"])] = metrics
        if not found:
            return
        fingers = sorted({many for cells in found.values() for _, many in cells})
        heads = ("", *(count(many, "finger") for many in fingers), "a frame", "command")
        parts = ["<p>A hand circles on the globe, 8 bits, at 0.3 m/s. Time of a tick of all fingers, µs: mean, and behind it the "
                 "largest of each second (the least of three runs). A tick has 1000. The paper measured one finger, and expects "
                 "the time of others to be a multiple of it. A frame: what building one takes besides, where it is not filtered "
                 "only where it is touched.</p>"]
        for way, words in TABLE_1_WAYS.items():
            cells, rows = found.get(way, {}), []
            papers = {many: metrics["papers_tick_us"] for (_, many), metrics in cells.items() if "papers_tick_us" in metrics}
            if papers:
                rows.append(("720x480 in the paper", *(number(papers.get(many, math.nan)) for many in fingers), "", ""))
            for size in dict.fromkeys(size for size, _ in cells):
                here = [cells.get((size, many), {}) for many in fingers]
                times = (f"{number(metrics.get('tick_us_mean', math.nan))} "
                         f"({number(metrics.get('tick_us_second_max_undisturbed', math.nan))})" for metrics in here)
                frame = next((number(metrics["frame_ms"], "ms") for metrics in here if "frame_ms" in metrics), "")
                rows.append((size, *times, frame, self.command("paper", f"globe-{size}-8-")))
            if rows:
                parts.append(f"<h3>{words}</h3>" + table(heads, rows, range(1, len(fingers) + 2)))
        self.section("Table I: sizes and fingers", *parts)

    @staticmethod
    def unless_foreign(make, *arguments):
        """Records of other versions may lack what a plot needs."""
        try:
            return make(*arguments)
        except (LookupError, TypeError, ValueError, ArithmeticError) as fault:
            return f"<p class=note>Not drawn; these records do not fit: {html.escape(repr(fault))}.</p>"

    def plot(self, draw, figures, title):
        def make():
            figure = draw(figures)
            return "" if figure is None else svg_of(figure, title)

        return self.unless_foreign(make)

    def add_plots(self):
        for title, draw, suites, part, words in PLOTS:
            here = [suite for suite in suites if suite in self.machines][:1]
            if here and (drawn := self.plot(draw, figures_of(self.records, suites), title)):
                self.section(title, f"<p>{html.escape(words)} {self.command(here[0], part.strip('.'))}</p>", drawn)

    def add_gpu(self):
        figures = figures_of(self.records, ("gpu",)) if "gpu" in self.machines else {}
        drawn = []
        for title, draw, words in GPU_SECTIONS:
            if figures and (plot := self.plot(draw, figures, title)):
                more = self.unless_foreign(run_table, figures) if title == "Computed and run" else ""
                drawn.append(folded(title, f"<p>{html.escape(words)}</p>{plot}{more}", is_open=not drawn))
        if drawn:
            device = figures.get("machine", {}).get("gpu", "an unnamed device")
            facts = html.escape(self.unless_foreign(facts_of, figures))
            self.section(f"GPU: {device}", f"<p>What frames and touch cost by Vulkan, by the CPU and lazily: {facts}. "
                         f"{self.command('gpu')}</p>", *drawn)

    def add_records(self):
        parts = []
        for suite in self.machines:
            cases = {}
            for record in self.records.values():
                if record.suite == suite:
                    cases.setdefault(record.case, []).append((record.metric, number(record.value, record.unit)))
            parts.append(folded(f"{suite}: {count(len(cases), 'case')}", "".join(
                folded(case, ("" if case in ("machine", "hand") or case.startswith("target: ") else self.command(suite, case)) +
                       table(("figure", "value"), rows, (1,))) + "\n" for case, rows in cases.items())))
        self.section("All records", *parts)

    def text(self):
        facts = {metric: value for suite in self.machines.values() for metric, value in suite.items()}
        machine = ", ".join(str(words) for words in (
            facts.get("cpu"), is_number(facts.get("cores")) and count(int(facts["cores"]), "core"), facts.get("gpu"),
            facts.get("date"), "commit" in facts and f"commit {facts['commit']}") if words)
        links = "".join(f"<a href='#{name}'>{html.escape(title)}</a> " for name, title in self.titles)
        return ("<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>"
                f"<title>Benchmarks of touchable</title><style>{STYLE}</style><h1>Benchmarks of touchable</h1>"
                f"<p>{html.escape(machine)}. Commands are programs of <code>build/release/bench/</code>; what figures mean is in "
                f"<code>bench/README.md</code>.</p><nav>{links}</nav>" + "\n".join(self.parts) + "</html>\n")


def report_page(records, old=None, old_name=""):
    page = Page(records)
    page.add_summary()
    if old is not None:
        page.add_changes(old, old_name)
    page.add_best()
    page.add_table_1()
    page.add_plots()
    page.add_gpu()
    page.add_records()
    return page.text()
