"""What the pictures and plots read of a case: the exported series, the units and the history."""

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyvista as pv


class CaseError(Exception):
    """An exported file is missing or not what it should be; the message names it."""


@dataclass(frozen=True)
class Series:
    """The surface at each exported time, and the unit of each array and of `time`."""

    name: str
    times: list[float]
    surfaces: list[pv.PolyData]
    units: dict[str, str]

    def moment(self, step: int) -> str:
        """The time of a step in words; in statics it is the load factor and has no unit."""
        unit = self.units.get("time", "")
        return f"t = {self.times[step]:.4g}" + (f" {unit}" if unit not in ("", "1") else "")


def load_series(case: Path) -> Series:
    """Reads `case/vtk/*.pvd`, or the `.pvd` file given, with the `units.json` beside it."""
    pvd = case
    if case.suffix != ".pvd":
        found = sorted((case / "vtk").glob("*.pvd"))
        if not found:
            raise CaseError(f"{case / 'vtk'}: no .pvd file; run `thinshell export` first")
        pvd = found[0]
    try:
        reader = pv.PVDReader(pvd)
    except (OSError, SyntaxError, ValueError) as error:
        raise CaseError(f"{pvd}: {error}") from error
    times = [float(time) for time in reader.time_values]
    if not times:
        raise CaseError(f"{pvd}: the series is empty")
    surfaces = []
    for time in times:
        reader.set_active_time_value(time)
        data = reader.read().combine()
        # Curved faces are few and large: each becomes sixteen flat ones. Flat faces stay.
        surface = data.extract_surface(
            pass_pointid=False,
            pass_cellid=False,
            nonlinear_subdivision=2,
            algorithm="dataset_surface",
        )
        if surface.n_points == 0:
            raise CaseError(f"{pvd}: no surface at time {time:g}")
        if not np.isfinite(surface.points).all():
            raise CaseError(f"{pvd}: positions at time {time:g} are not finite")
        surfaces.append(surface)
    units_file = pvd.parent / "units.json"
    units = json.loads(units_file.read_text()) if units_file.is_file() else {}
    name = case.stem if case.suffix == ".pvd" else case.resolve().name
    return Series(name, times, surfaces, units)


def load_history(case: Path) -> dict[str, np.ndarray]:
    """Reads `case/history.csv`, or the `.csv` file given: one array per column, NaN if empty."""
    path = case if case.suffix == ".csv" else case / "history.csv"
    if not path.is_file():
        raise CaseError(f"{path}: no such file; run `thinshell run` first")
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise CaseError(f"{path}: no steps yet")
    try:
        return {key: np.array([float(row[key] or "nan") for row in rows]) for key in rows[0]}
    except (TypeError, ValueError) as error:
        raise CaseError(f"{path}: {error}") from error
