#!/usr/bin/python3
"""Draws what `touchable touch`, `touchable export` and `touchable-bench` wrote.

plot.py forces FORCES.csv OUT.png              force over time, one strip per finger
plot.py paths EXPORT_DIR FORCES.csv OUT.png    the frame's depth, and where the proxies went over it
plot.py pareto TOUCH.json OUT.png              run time against error of every option of the touch solver
plot.py stability LOOP.json OUT.png            up to which stiffness a closed loop is stable, beside theory
"""

import argparse
import sys

sys.dont_write_bytecode = True  # a plot leaves nothing in the source tree

from plots.pareto import draw_pareto
from plots.stability import draw_stability
from plots.style import BadInput
from plots.touch import draw_forces, draw_paths


def main():
    parser = argparse.ArgumentParser(description="Draws what touchable and touchable-bench wrote.")
    commands = parser.add_subparsers(required=True, metavar="forces|paths|pareto|stability")
    forces = commands.add_parser("forces", help="force over time, one strip per finger")
    forces.add_argument("forces", metavar="FORCES.csv")
    forces.set_defaults(draw=draw_forces)
    paths = commands.add_parser("paths", help="the proxies' paths over a frame's depth")
    paths.add_argument("export", metavar="EXPORT_DIR")
    paths.add_argument("forces", metavar="FORCES.csv")
    paths.set_defaults(draw=draw_paths)
    pareto = commands.add_parser("pareto", help="run time against error of the touch solver's options")
    pareto.add_argument("results", metavar="TOUCH.json")
    pareto.set_defaults(draw=draw_pareto)
    stability = commands.add_parser("stability", help="the closed loop's boundary of stability beside theory")
    stability.add_argument("results", metavar="LOOP.json")
    stability.set_defaults(draw=draw_stability)
    for command in (forces, paths, pareto, stability):
        command.add_argument("out", metavar="OUT.png")
    arguments = parser.parse_args()
    try:
        arguments.draw(arguments)
    except BadInput as fault:
        print(f"plot.py: {fault}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
