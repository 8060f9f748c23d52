"""Plots the history of a run against time: step size, iterations, convergence, energies, run time.

Usage: python post/history.py CASE [-o history.png] [--columns NAME ...]

Reads CASE/history.csv. Columns of one kind share a panel; a column that a run does not have is
left out.
"""

import argparse
import itertools
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib.ticker
import numpy as np

import style
from case import CaseError, load_history
from style import plt

# Title, unit and scale of each panel, and the columns it takes by exact name.
COUNTS = (
    "newton_iterations",
    "fallback_iterations",
    "factorizations",
    "halvings",
    "negative_pivots",
)
PANELS = [
    ("time step", "s", "log", ("dt_s",)),
    ("work", "count", "linear", COUNTS),
    ("residual", "", "log", ("residual",)),
    ("increment", "m", "log", ("increment_m",)),
    ("run time", "s", "linear", ("wall_s",)),
]
ENERGY = "_energy_J"


def arrange(columns: list[str]) -> list[tuple[str, str, str, list[str]]]:
    """The panels that these columns fill; one of its own for each column that no panel knows."""
    panels = []
    energies = [name for name in columns if name.endswith(ENERGY)]
    if energies:
        panels.append(("energy", "J", "linear", energies))
    for title, unit, scale, names in PANELS:
        present = [name for name in names if name in columns]
        if present:
            panels.append((title, unit, scale, present))
    known = {name for _, _, _, names in panels for name in names}
    panels += [(name, "", "linear", [name]) for name in columns if name not in known]
    return panels


def label(column: str) -> str:
    return column.removesuffix(ENERGY).removesuffix("_s").replace("_", " ")


def show_decades(axis: plt.Axes, values: np.ndarray) -> None:
    """Gives a logarithmic axis at least two decades; a constant would show its rounding."""
    positive = np.log10(values[values > 0])
    if positive.size:
        low, high = float(positive.min()), float(positive.max())
        margin = max(0.15, 1.0 - (high - low) / 2)
        axis.set_ylim(10 ** (low - margin), 10 ** (high + margin))
    axis.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())


def draw(history: dict[str, np.ndarray], columns: list[str], title: str) -> plt.Figure:
    panels = arrange(columns)
    time = history["time_s"]
    figure, axes = plt.subplots(
        len(panels),
        1,
        sharex=True,
        squeeze=False,
        figsize=(6.4, 1.2 + 1.7 * len(panels)),
        layout="constrained",
    )
    marker = "." if time.size <= 60 else None
    for axis, (name, unit, scale, members) in zip(axes[:, 0], panels, strict=True):
        for line, column in zip(itertools.cycle(style.LINES), members):
            values = history[column]
            if scale == "log":
                # Zero has no place on this axis; it marks steps without an iteration.
                values = np.where(values > 0, values, np.nan)
            axis.plot(time, values, line, marker=marker, label=label(column))
        axis.set_yscale(scale)
        if scale == "log":
            show_decades(axis, np.concatenate([history[column] for column in members]))
        if scale == "linear" and unit != "count":
            axis.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
        if unit == "count":
            axis.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(integer=True))
        axis.set_ylabel(f"{name} [{unit}]" if unit else name)
        if len(members) > 1:
            axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes[-1, 0].set_xlabel("time [s]")
    figure.suptitle(title)
    figure.align_ylabels()
    return figure


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("case", type=Path, help="folder of the case, or a .csv file")
    parser.add_argument(
        "-o", "--output", type=Path, help="picture, .png, .svg or .pdf [CASE/history.png]"
    )
    parser.add_argument("--columns", nargs="+", help="columns to plot [all but step and time_s]")
    options = parser.parse_args(arguments)
    try:
        history = load_history(options.case)
        if "time_s" not in history:
            raise CaseError(f"{options.case}: the history has no column 'time_s'")
        columns = options.columns or [name for name in history if name not in ("step", "time_s")]
        for name in columns:
            if name not in history:
                raise CaseError(
                    f"--columns {name}: no such column; there are {', '.join(history)}"
                )
    except CaseError as error:
        print(f"history: {error}", file=sys.stderr)
        return 2
    case = options.case.parent if options.case.suffix == ".csv" else options.case
    output = options.output or case / "history.png"
    style.apply_style()
    style.save(draw(history, columns, case.resolve().name), output)
    print(f"history: {output} ({', '.join(columns)})")
    return 0


if __name__ == "__main__":
    sys.exit(main())
