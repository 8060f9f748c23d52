"""Writes spoon.msh: the middle surface of a plastic spoon, in metres, its bowl at the origin, its handle along x; the hollow side is the top.
Usage: python data/shape/spoon.py > data/shape/spoon.msh

A point at x and the fraction t of the half width w, from -1 to 1, is (x, w t, rim - depth (1 - t^2)). Quadratic triangles, Gmsh 2.2, the middles of the
edges on the surface too. Rows of vertices lie at constant x, among them the ends of the neck, 0.06 and 0.09.
"""

from math import acos, cos, pi, sqrt

BOWL, LENGTH = 0.05, 0.14
ACROSS = 4
WIDEST = 0.022
ROWS = [WIDEST * (1 - cos(0.5 * pi * i / 6)) for i in range(7)]
ROWS += [WIDEST + (BOWL - WIDEST) * i / 6 for i in range(1, 7)]
# Closer at both ends of the neck, where heat creeps out of it.
ROWS += [0.055, 0.058, 0.0592, 0.06, 0.0608, 0.062, 0.0645, 0.067, 0.0695, 0.072, 0.075]
ROWS += [0.15 - x for x in ROWS[-2:-11:-1]]
ROWS += [0.095 + 0.005 * i for i in range(10)]


def half_width(x: float) -> float:
    if x < WIDEST:
        return 0.015 * sqrt(max(0.0, 1 - ((x - WIDEST) / WIDEST) ** 2))
    if x < BOWL:
        return 0.004 + 0.0055 * (1 + cos(pi * (x - WIDEST) / (BOWL - WIDEST)))
    return 0.004 + 0.001 * (x - BOWL) / (LENGTH - BOWL)


def point(x: float, t: float) -> tuple[float, float, float]:
    depth = 0.74 * x * (1 - x / BOWL) ** 2 if x < BOWL else 0.0
    rim = 0.025 * (max(0.0, x - 0.03) / 0.11) ** 2
    return (x, half_width(x) * t, rim - depth * (1 - t * t))


def main() -> None:
    nodes: dict[tuple[float, float], int] = {}

    def node(x: float, t: float) -> int:
        return nodes.setdefault((round(x, 9), t), len(nodes) + 1)

    def face(*corners: tuple[float, float]) -> list[int]:
        middles = []
        for (x, t), (y, u) in zip(corners, corners[1:] + corners[:1]):
            middle = 0.5 * (x + y)
            if min(x, y) > 0:
                middles.append(node(middle, 0.5 * (t + u)))
            elif abs(t + u) < 1:
                # Edges to the tip are straight seen from above, for lines of constant t bend too sharply there.
                middles.append(node(middle, (half_width(x) * t + half_width(y) * u) / 2 / half_width(middle)))
            else:
                # On the rim at half the angle of the ellipse.
                middles.append(node(WIDEST * (1 - cos(0.5 * acos(1 - max(x, y) / WIDEST))), t + u))
        return [node(x, t) for x, t in corners] + middles

    sides = [2 * i / ACROSS - 1 for i in range(ACROSS + 1)]
    faces = [face((0.0, 0.0), (ROWS[1], t), (ROWS[1], u)) for t, u in zip(sides, sides[1:])]
    for x, y in zip(ROWS[1:], ROWS[2:]):
        for t, u in zip(sides, sides[1:]):
            faces += [face((x, t), (y, t), (y, u)), face((x, t), (y, u), (x, u))]
            if t >= 0:
                faces[-2:] = [face((x, t), (y, t), (x, u)), face((y, t), (y, u), (x, u))]
    print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes", len(nodes), sep="\n")
    for (x, t), index in nodes.items():
        print(index, *(f"{c:.9f}" for c in point(x, t)))
    print("$EndNodes\n$Elements", len(faces), sep="\n")
    for index, corners in enumerate(faces, 1):
        print(index, "9 2 0 0", *corners)
    print("$EndElements")


main()
