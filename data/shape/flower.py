"""Writes flower.obj: a hexagon with six petals, flat, in metres. Usage: python data/shape/flower.py > data/shape/flower.obj

Every row of vertices is parallel to the edge of the hexagon that its petal stands on, so that what depends on the distance from that edge
alone is the same all along a row. Groups: `center`, `petals`.
"""

from math import cos, pi, sin, tan

APOTHEM = 0.008  # of the hexagon
LENGTH = 0.02  # of a petal
BULGE = 1.2  # how much a petal widens: half widths are b cos(q) (1 + BULGE sin(q)), sin(q) the fraction of its length
ACROSS = 6  # cells across a petal, and rows of the sector behind it
ROWS = 12  # along a petal
BEHIND = [0.0, 0.0025, 0.0048, 0.0066, 0.0075, 0.00785, APOTHEM]  # rows of a sector, closer where moisture may creep in


def main() -> None:
    vertices: dict[tuple[float, float], int] = {}
    faces: dict[str, list[list[int]]] = {"center": [], "petals": []}

    def vertex(x: float, y: float, turn: float) -> int:
        point = (round(cos(turn) * x - sin(turn) * y, 9) + 0.0, round(sin(turn) * x + cos(turn) * y, 9) + 0.0)
        return vertices.setdefault(point, len(vertices) + 1)

    def row(x: float, half: float, cells: int, turn: float) -> list[int]:
        return [vertex(x, half * (2 * i / cells - 1) if cells else 0.0, turn) for i in range(cells + 1)]

    for petal in range(6):
        turn = petal * pi / 3
        rows = [row(x, x * tan(pi / 6), i, turn) for i, x in enumerate(BEHIND)]
        for inner, outer in zip(rows, rows[1:]):
            for i in range(len(inner)):
                faces["center"].append([inner[i], outer[i], outer[i + 1]])
            for i in range(len(inner) - 1):
                faces["center"].append([inner[i], outer[i + 1], inner[i + 1]])
        rows = [rows[-1]]
        for i in range(1, ROWS):
            q = 0.5 * pi * i / ROWS
            half = APOTHEM * tan(pi / 6) * cos(q) * (1 + BULGE * sin(q))
            rows.append(row(APOTHEM + LENGTH * sin(q), half, ACROSS, turn))
        for inner, outer in zip(rows, rows[1:]):
            for i in range(ACROSS):
                left = i < ACROSS // 2
                a, b, c, d = inner[i], outer[i], outer[i + 1], inner[i + 1]
                faces["petals"] += [[a, b, d], [b, c, d]] if left else [[a, b, c], [a, c, d]]
        tip = vertex(APOTHEM + LENGTH, 0.0, turn)
        faces["petals"] += [[a, tip, b] for a, b in zip(rows[-1], rows[-1][1:])]
    for x, y in vertices:
        print(f"v {x} {y} 0")
    for name, group in faces.items():
        print(f"g {name}")
        for face in group:
            print("f", *face)


main()
