"""Plots what a sweep measured against its key, one panel per measure, with the laws fitted to it.

Usage: python post/plot_sweep.py FILE.json [-o plot.png] [--measure NAME ...] [--linear]

FILE.json is the sweep.json of `thinshell report --sweep`. Each sweep is a row of panels; a second
key gives one line per value. Axes are logarithmic where all numbers are positive. A run that failed
has no point, and that is said. Grey lines are the limits that the scene expects.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import style
from case import CaseError
from style import COLOURS, LINES, plt

MARKERS = "os^Dv<>P"
ROUND_OFF = 1e-12  # of the largest number: what is smaller is no number to draw by its logarithm
NOTHING = 1e-30  # no quantity of a scene in SI units is as small
# Units of keys that are often varied, by the last name in the key.
UNITS = {
    "thickness": "m",
    "top_thickness": "m",
    "radius": "m",
    "length": "m",
    "size": "m",
    "radii": "m",
    "scale": "m per unit of the file",
    "youngs_modulus": "Pa",
    "pressure": "Pa",
    "density": "kg/m3",
    "viscosity": "s",
    "dt": "s",
    "end": "s",
}


def load_sweeps(path: Path) -> list[dict[str, Any]]:
    try:
        document = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise CaseError(f"{path}: {error}") from error
    sweeps = document.get("sweeps") if isinstance(document, dict) else None
    if not sweeps or not all("rows" in sweep and "measures" in sweep for sweep in sweeps):
        raise CaseError(f"{path}: no sweeps with rows and measures; is it a sweep.json?")
    return sweeps


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def with_unit(key: str) -> str:
    names = [name for name in key.split(".") if not name.isdigit()]
    unit = UNITS.get(names[-1]) if names else None
    return f"{key} [{unit}]" if unit else key


def set_scale(axis: plt.Axes, values: list[float], linear: bool) -> None:
    """Logarithmic y axis where that tells something; else one that shows a constant as such."""
    largest = max(abs(y) for y in values)
    if largest < NOTHING:
        axis.set_ylim(-1, 1)
    elif max(values) - min(values) <= 1e-6 * largest:
        axis.set_ylim(min(0.5 * values[0], 1.5 * values[0]), max(0.5 * values[0], 1.5 * values[0]))
    # Less than a decade has no ticks on a logarithmic axis.
    elif not linear and ROUND_OFF * largest < min(values) < 0.1 * largest:
        axis.set_yscale("log")


def say_failures(sweep: dict[str, Any]) -> None:
    for row in sweep["rows"]:
        # A run that stopped may have a point all the same: how far it came.
        if "failure" in row and all(value is None for value in row["measures"]):
            values = ", ".join(map(str, row["values"]))
            print(f"plot_sweep: no point of {sweep['name']} at {values}: {row['failure']}")


def lines(sweep: dict[str, Any], place: int) -> dict[Any, list[tuple[Any, float]]]:
    """Points (value of the key, measure) for each value of the second key, or for None without."""
    found: dict[Any, list[tuple[Any, float]]] = {}
    for row in sweep["rows"]:
        second = row["values"][1] if len(row["values"]) > 1 else None
        value = row["measures"][place]
        points = found.setdefault(second, [])
        if value is not None:
            points.append((row["values"][0], value))
    return found


def draw_law(
    axis: plt.Axes,
    fit: dict[str, Any],
    points: list[tuple[Any, float]],
    colour: str,
    of: str = "",
) -> None:
    if fit["exponent"] is None:
        return
    ends = [min(x for x, _ in points), max(x for x, _ in points)]
    law = [fit["prefactor"] * x ** fit["exponent"] for x in ends]
    label = f"{of}power {fit['exponent']:.3g}"
    axis.plot(ends, law, color=colour, linestyle=":", linewidth=1.0, label=label)


def draw_panel(axis: plt.Axes, sweep: dict[str, Any], measure: str, linear: bool) -> int:
    """Returns how many points were drawn."""
    groups = lines(sweep, sweep["measures"].index(measure))
    everything = [point for points in groups.values() for point in points]
    numbers = all(is_number(x) for x, _ in everything)
    for i, (second, points) in enumerate(groups.items()):
        colour = COLOURS[i % len(COLOURS)]
        axis.plot(
            [x if numbers else str(x) for x, _ in points],
            [y for _, y in points],
            color=colour,
            linestyle=LINES[i // len(COLOURS) % len(LINES)],
            marker=MARKERS[i % len(MARKERS)],
            label=None if second is None else f"{second:g}" if is_number(second) else str(second),
        )
        for fit in sweep.get("fits", []):
            if fit["measure"] == measure and fit.get("at") == second and points:
                draw_law(axis, fit, points, colour)
    for fit in sweep.get("fits", []):
        # A law through points of several lines.
        if fit["measure"] == measure and fit.get("at") not in groups and everything:
            draw_law(axis, fit, everything, COLOURS[-1], f"{fit['at']}, ")
    if not linear and numbers and all(x > 0 for x, _ in everything):
        axis.set_xscale("log")
    limits = sweep.get("limits", [])
    bounds = limits[sweep["measures"].index(measure)] if limits else []
    bounds = [value for value in bounds if value is not None]
    for value in bounds:
        axis.axhline(value, color="#8a9096", linestyle="--", linewidth=0.9, zorder=0)
    if everything:
        set_scale(axis, [y for _, y in everything] + bounds, linear)
    axis.set_xlabel(with_unit(sweep["keys"][0]))
    axis.set_ylabel(measure)
    if axis.get_legend_handles_labels()[0]:
        axis.legend(title=sweep["keys"][1] if len(sweep["keys"]) > 1 else None, fontsize=8)
    return len(everything)


def chosen(sweep: dict[str, Any], measures: list[str] | None) -> list[str]:
    return [name for name in sweep["measures"] if measures is None or name in measures]


def draw(
    sweeps: list[dict[str, Any]], measures: list[str] | None, linear: bool
) -> tuple[plt.Figure, int]:
    columns = max(len(chosen(sweep, measures)) for sweep in sweeps)
    size = (4.2 * columns, 3.4 * len(sweeps))
    figure, axes = plt.subplots(
        len(sweeps), columns, figsize=size, layout="constrained", squeeze=False
    )
    count = 0
    for row, sweep in zip(axes, sweeps, strict=True):
        say_failures(sweep)
        names = chosen(sweep, measures)
        row[0].set_title(sweep["name"])
        for axis, name in zip(row, names, strict=False):
            count += draw_panel(axis, sweep, name, linear)
        for axis in row[len(names) :]:
            axis.set_axis_off()
    return figure, count


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("file", type=Path, help="sweep.json of a case")
    parser.add_argument(
        "-o", "--output", type=Path, help="picture, .png, .svg or .pdf [sweep.png beside the file]"
    )
    parser.add_argument(
        "--measure", nargs="+", metavar="NAME", help="measures to draw, by their names [all]"
    )
    parser.add_argument("--linear", action="store_true", help="no logarithmic axes")
    options = parser.parse_args(arguments)
    try:
        sweeps = load_sweeps(options.file)
        known = {name for sweep in sweeps for name in sweep["measures"]}
        for name in options.measure or []:
            if name not in known:
                raise CaseError(f"no measure '{name}'; there are: {', '.join(sorted(known))}")
        sweeps = [sweep for sweep in sweeps if chosen(sweep, options.measure)]
        style.apply_style()
        figure, count = draw(sweeps, options.measure, options.linear)
        if count == 0:
            raise CaseError("no run gave a value")
    except CaseError as error:
        print(f"plot_sweep: {error}", file=sys.stderr)
        return 2
    output = options.output or options.file.parent / "sweep.png"
    style.save(figure, output)
    print(f"plot_sweep: {output} ({count} points)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
