"""Writes leaf.csv: a leaf with its stalk, in metres; the blade from the origin along x. Usage: python data/outline/leaf.py > data/outline/leaf.csv

The blade's half width at the fraction q of its length is proportional to q^0.6 (1 - q), 20 mm at most; the stalk reaches back by 12 mm and is
2 mm wide. Corners are about 2.5 mm apart.
"""

from math import ceil, hypot

LENGTH, WIDEST, STALK, STEP = 0.08, 0.02, 0.012, 0.0025
TOP = 0.6 / 1.6  # where the blade is widest


def half_width(q: float) -> float:
    return WIDEST * (q / TOP) ** 0.6 * (1 - q) / (1 - TOP)


def main() -> None:
    # Where the blade is as wide as the stalk, and on from there by equal lengths.
    base = next(q for q in (i / 1e5 for i in range(100000)) if half_width(q) >= 0.001)
    fine = [base + (1 - base) * i / 10000 for i in range(10001)]
    points = [(LENGTH * q, half_width(q)) for q in fine]
    along = [0.0]
    for (x, y), (u, v) in zip(points, points[1:]):
        along.append(along[-1] + hypot(u - x, v - y))
    pieces = ceil(along[-1] / STEP)
    edge = []
    for i in range(pieces):
        edge.append(points[next(j for j, s in enumerate(along) if s >= along[-1] * i / pieces)])
    lower = [(x, -y) for x, y in edge]
    print("# leaf with its stalk, counter-clockwise; made by leaf.py")
    print("x,y")
    for x, y in [(-STALK, 0.001), (-STALK, -0.001), *lower, (LENGTH, 0.0), *reversed(edge)]:
        print(f"{x:.6f},{y:.6f}")


main()
