"""Writes lee_frame.obj: two strips of length 1 and width 0.05 m at a right angle, one upright at x = 0, one along x at z = 1."""

from pathlib import Path

CELLS, WIDTH = 25, 0.05

places = [(0.0, i / CELLS) for i in range(CELLS)] + [(i / CELLS, 1.0) for i in range(CELLS + 1)]
lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, z in places for y in (0.0, WIDTH)]
for i in range(2 * CELLS):
    a, b, c, d = (2 * i + k for k in (1, 3, 4, 2))
    lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"] if i % 2 else [f"f {a} {b} {d}", f"f {b} {c} {d}"]
Path(__file__).with_name("lee_frame.obj").write_text("\n".join(lines) + "\n")
