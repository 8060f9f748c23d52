"""Writes sliver_column.obj and sliver_row.obj: strips of 0.1 x 0.02 m with triangles 10,000 times as long as wide among good ones."""

from pathlib import Path


def write(name, xs, ys):
    lines = [f"v {x:.17g} {y:.17g} 0" for x in xs for y in ys]
    at = lambda i, j: i * len(ys) + j + 1
    for i in range(len(xs) - 1):
        for j in range(len(ys) - 1):
            lines += [f"f {at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)}", f"f {at(i, j)} {at(i + 1, j + 1)} {at(i, j + 1)}"]
    Path(__file__).with_name(f"{name}.obj").write_text("\n".join(lines) + "\n")


xs, ys = [i / 80 for i in range(9)], [j / 200 for j in range(5)]
write("sliver_column", sorted(xs + [0.0375 + 5e-7]), ys)
write("sliver_row", xs, sorted(ys + [0.005 + 1.25e-6]))
