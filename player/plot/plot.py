#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""plot.py FORCES.csv [EXPORT_DIR] writes a PNG to standard output: what `touchable plot` calls."""

import sys

sys.dont_write_bytecode = True  # a plot leaves nothing in the source tree

from style import BadInput
from touch import draw_forces, draw_paths


def main():
    try:
        figure = draw_forces(*sys.argv[1:]) if len(sys.argv) == 2 else draw_paths(*sys.argv[1:])
        figure.savefig(sys.stdout.buffer, format="png", dpi=130)
    except BadInput as fault:
        print(fault, file=sys.stderr)
        return 3
    except OSError as fault:
        print(f"the picture cannot be written: {fault}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
