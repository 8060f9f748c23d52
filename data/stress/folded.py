"""Writes folded.obj and flat.obj: a strip of 0.1 x 0.02 m, folded sharply across its middle, and the same faces flat."""

import math
from pathlib import Path

FOLD = math.radians(179)  # turn from one half to the other
HALF, ROWS, LENGTH, WIDTH = 4, 2, 0.1, 0.02


def place(i, folded):
    s = LENGTH * (i - HALF) / (2 * HALF)
    turn = FOLD / 2 if folded else 0.0
    return s * math.cos(turn), abs(s) * math.sin(turn)


for name, folded in [("folded", True), ("flat", False)]:
    lines = []
    for i in range(2 * HALF + 1):
        x, z = place(i, folded)
        lines += [f"v {x:.17g} {WIDTH * j / ROWS:.17g} {z:.17g}" for j in range(ROWS + 1)]
    at = lambda i, j: i * (ROWS + 1) + j + 1
    for i in range(2 * HALF):
        for j in range(ROWS):
            lines += [f"f {at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)}", f"f {at(i, j)} {at(i + 1, j + 1)} {at(i, j + 1)}"]
    Path(__file__).with_name(f"{name}.obj").write_text("\n".join(lines) + "\n")
