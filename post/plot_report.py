"""Plots error against cost from mesh ladders, one line per director, mesh, sampling and thickness.

Usage: python post/plot_report.py FILE.json ... [-o plot.png]
                                  [--x wall_s|gflop|dofs|faces|factorizations]

A row of a ladder has the keys director, mesh, thickness, faces, dofs, error, order, wall_s, gflop and
factorizations, and sampling where the ladder varies that. Rows are found wherever they stand in the files; all files are drawn into one plot.
A row whose error is null is left out, and that is said.
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import style
from case import CaseError
from style import COLOURS, LINES, plt

AXES = {
    "wall_s": "run time [s]",
    "gflop": "run time [Gflop of dense products]",
    "dofs": "unknowns",
    "faces": "faces",
    "factorizations": "factorisations",
}
MARKERS = "os^Dv<>P"


def ladder_rows(value: Any) -> Iterator[dict[str, Any]]:
    """Every object with a director and an error in a JSON value."""
    if isinstance(value, dict):
        if "director" in value and "error" in value:
            yield value
        else:
            for member in value.values():
                yield from ladder_rows(member)
    elif isinstance(value, list):
        for member in value:
            yield from ladder_rows(member)


def load_rows(path: Path) -> list[dict[str, Any]]:
    try:
        rows = list(ladder_rows(json.loads(path.read_text())))
    except (OSError, ValueError) as error:
        raise CaseError(f"{path}: {error}") from error
    if not rows:
        raise CaseError(f"{path}: no rows with the keys 'director' and 'error'")
    return rows


def key(row: dict[str, Any]) -> tuple[str, str, float | None]:
    mesh = ", ".join(str(row[name]) for name in ("mesh", "sampling") if row.get(name))
    return str(row["director"]), mesh, row.get("thickness")


def is_positive(value: Any) -> bool:
    return isinstance(value, (int, float)) and value > 0


def usable(rows: list[dict[str, Any]], x: str) -> list[dict[str, Any]]:
    """The rows that have a place on logarithmic axes; names the others."""
    kept = []
    for row in rows:
        if is_positive(row["error"]) and is_positive(row.get(x)):
            kept.append(row)
        else:
            what = f"{describe(key(row))}, {row.get('faces', '?')} faces"
            print(f"plot_report: left out {what}: error {row['error']}, {x} {row.get(x)}")
    return kept


def describe(formulation: tuple[str, str, float | None]) -> str:
    director, mesh, thickness = formulation
    parts = [director.replace("_", " "), mesh]
    if isinstance(thickness, (int, float)):
        parts.append(f"{thickness:g} m")
    return ", ".join(part for part in parts if part)


def order_of(rows: list[dict[str, Any]]) -> str:
    """Order of convergence at the finest mesh that has one, as the report gives it."""
    orders = [row["order"] for row in rows if isinstance(row.get("order"), (int, float))]
    return f" (order {orders[-1]:.2f})" if orders else ""


def draw(rows: list[dict[str, Any]], x: str) -> plt.Figure:
    groups: dict[tuple[str, str, float | None], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    # Director: colour; mesh and sampling: line; thickness: marker.
    kinds = [list(dict.fromkeys(group[part] for group in groups)) for part in range(3)]
    several = len(kinds[2]) > 1
    figure, axis = plt.subplots(figsize=(6.4, 4.8), layout="constrained")
    for group, members in groups.items():
        members.sort(key=lambda row: row.get("faces", row[x]))
        director, mesh, thickness = (kinds[part].index(group[part]) for part in range(3))
        axis.loglog(
            [row[x] for row in members],
            [row["error"] for row in members],
            color=COLOURS[director % len(COLOURS)],
            linestyle=LINES[mesh % len(LINES)],
            marker=MARKERS[thickness % len(MARKERS)],
            label=describe((*group[:2], group[2] if several else None)) + order_of(members),
        )
    errors = np.array([row["error"] for row in rows])
    axis.set_ylim(errors.min() / 2, errors.max() * 2)
    if not several and kinds[2][0] is not None:
        axis.set_title(f"thickness {kinds[2][0]:g} m")
    axis.set_xlabel(AXES[x])
    axis.set_ylabel("error")
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    axis.grid(which="minor", linewidth=0.3)
    return figure


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("files", type=Path, nargs="+", help="ladder.json of one or more cases")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        help="picture, .png, .svg or .pdf [error_against_<x>.png beside the first file]",
    )
    parser.add_argument(
        "--x", choices=AXES, default="wall_s", help="horizontal axis [%(default)s]"
    )
    options = parser.parse_args(arguments)
    try:
        rows = usable([row for path in options.files for row in load_rows(path)], options.x)
        if not rows:
            raise CaseError(f"no row has both an error and '{options.x}'")
    except CaseError as error:
        print(f"plot_report: {error}", file=sys.stderr)
        return 2
    output = options.output or options.files[0].parent / f"error_against_{options.x}.png"
    style.apply_style()
    style.save(draw(rows, options.x), output)
    print(f"plot_report: {output} ({len(rows)} rows)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
