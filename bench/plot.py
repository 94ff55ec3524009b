#!/usr/bin/python3
"""Draws what `touchable-bench` wrote.

plot.py pareto TOUCH.json OUT.png      run time against error of every option of the touch solver
plot.py detail TOUCH.json OUT.png      what filters leave of noise against the least relief they keep
plot.py stability LOOP.json OUT.png    up to which stiffness a closed loop is stable, beside theory
plot.py spectrum PAPER.json OUT.png    power spectral density of the force by filter, as the paper's Fig. 19
plot.py gpu GPU.json PAGE.html         a page: what a GPU, its builder and three ways to touch cost
"""

import argparse
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # a plot leaves nothing in the source tree
sys.path.append(str(Path(__file__).resolve().parents[1] / "player" / "plot"))

from plots.detail import draw_detail
from plots.gpu import draw_gpu
from plots.pareto import draw_pareto
from plots.spectrum import draw_spectrum
from plots.stability import draw_stability
from style import BadInput


def main():
    parser = argparse.ArgumentParser(description="Draws what touchable-bench wrote.")
    commands = parser.add_subparsers(required=True, metavar="pareto|detail|stability|spectrum|gpu")
    pareto = commands.add_parser("pareto", help="run time against error of the touch solver's options")
    pareto.add_argument("results", metavar="TOUCH.json")
    pareto.set_defaults(draw=draw_pareto)
    detail = commands.add_parser("detail", help="what filters leave of noise against the least relief they keep")
    detail.add_argument("results", metavar="TOUCH.json")
    detail.set_defaults(draw=draw_detail)
    stability = commands.add_parser("stability", help="the closed loop's boundary of stability beside theory")
    stability.add_argument("results", metavar="LOOP.json")
    stability.set_defaults(draw=draw_stability)
    spectrum = commands.add_parser("spectrum", help="the spectrum of the force, filter by filter")
    spectrum.add_argument("results", metavar="PAPER.json")
    spectrum.set_defaults(draw=draw_spectrum)
    for command in (pareto, detail, stability, spectrum):
        command.add_argument("out", metavar="OUT.png")
    gpu = commands.add_parser("gpu", help="a page: what a GPU, its builder and three ways to touch cost")
    gpu.add_argument("results", metavar="GPU.json")
    gpu.add_argument("out", metavar="PAGE.html")
    gpu.set_defaults(draw=draw_gpu)
    arguments = parser.parse_args()
    try:
        arguments.draw(arguments)
    except BadInput as fault:
        print(f"plot.py: {fault}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
