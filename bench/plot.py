#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Draws what `touchable-bench` wrote.

plot.py report RECORDS OUT.html [--compare OLD]   a page: what is best, what got worse, all figures
plot.py pareto TOUCH.json OUT.png      run time against error of every option of the touch solver
plot.py detail TOUCH.json OUT.png      what filters leave of noise against the least relief they keep
plot.py stability LOOP.json OUT.png    up to which stiffness a closed loop is stable, beside theory
plot.py spectrum PAPER.json OUT.png    power spectral density of the force by filter, as the paper's Fig. 19
plot.py count RECORDS                  how many records there are, of which suites

RECORDS and OLD are a file, or a folder of such files.
"""

import argparse
import collections
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # a plot leaves nothing in the source tree
sys.path.append(str(Path(__file__).resolve().parents[1] / "player" / "plot"))

from plots.detail import draw_detail
from plots.files import figures_of, read_records, save, save_text
from plots.pareto import draw_pareto
from plots.report import report_page
from plots.spectrum import draw_spectrum
from plots.stability import draw_stability
from style import BadInput

PICTURES = {"pareto": (draw_pareto, "the globe, a moving surface or real depth with a time and an error"),
            "detail": (draw_detail, "real-detail-... of the suite touch"),
            "stability": (draw_stability, "the suite loop with boundary_n_per_mm"),
            "spectrum": (draw_spectrum, "chest-320x240-8-1f-...-scratch-n1 of the suite paper")}


def write_report(arguments):
    old = None if arguments.compare is None else read_records(arguments.compare)
    save_text(report_page(read_records(arguments.records), old, arguments.compare), arguments.out)


def write_picture(arguments):
    draw, needed = PICTURES[arguments.picture]
    figure = draw(figures_of(read_records(arguments.records)))
    if figure is None:
        raise BadInput(f"{arguments.records}: there is no case of {needed}")
    save(figure, arguments.out)


def print_count(arguments):
    suites = collections.Counter(record.suite for record in read_records(arguments.records).values())
    print(f"{arguments.records}: " + ", ".join(f"{count} figures of {suite}" for suite, count in suites.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True, metavar="report|pareto|detail|stability|spectrum|count")
    for name, run in {"report": write_report, "count": print_count, **dict.fromkeys(PICTURES, write_picture)}.items():
        command = commands.add_parser(name)
        command.add_argument("records")
        if run != print_count:
            command.add_argument("out")
        command.set_defaults(run=run, picture=name)
        if run == write_report:
            command.add_argument("--compare", metavar="OLD", help="earlier records")
    arguments = parser.parse_args()
    try:
        arguments.run(arguments)
    except BadInput as fault:
        print(f"plot.py: {fault}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
