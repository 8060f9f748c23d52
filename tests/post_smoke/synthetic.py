"""Writes a made-up case as thinshell exports one: the smoke test then runs without a build."""

import csv
import json
from pathlib import Path

import numpy as np
import pyvista as pv


def bent_strip(curvature: float) -> pv.PolyData:
    """A strip of 0.2 m x 0.05 m bent to a cylinder of the given curvature (1/m), with arrays."""
    plane = pv.Plane(
        center=(0.1, 0.0, 0.0), i_size=0.2, j_size=0.05, i_resolution=40, j_resolution=10
    ).triangulate()
    flat = np.asarray(plane.points, dtype=float)
    turned = flat.copy()
    if curvature:
        turned[:, 0] = np.sin(curvature * flat[:, 0]) / curvature
        turned[:, 2] = (1 - np.cos(curvature * flat[:, 0])) / curvature
    surface = pv.PolyData(turned, plane.faces)
    surface.point_data["displacement"] = turned - flat
    surface.point_data["moisture_top"] = (
        curvature / 10 * np.exp(-(((flat[:, 0] - 0.1) / 0.05) ** 2))
    )
    stress = np.zeros((surface.n_cells, 6))
    stress[:, 0] = 1e5 * curvature * np.sin(30 * surface.cell_centers().points[:, 0])
    surface.cell_data["membrane_stress"] = stress
    return surface


def write_case(case: Path, steps: int = 6) -> None:
    """The series, its units and a history in `case`."""
    vtk = case / "vtk"
    vtk.mkdir(parents=True, exist_ok=True)
    entries = []
    with (case / "history.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(
            "step time_s dt_s halvings newton_iterations fallback_iterations factorizations "
            "residual increment_m "
            "kinetic_energy_J membrane_energy_J bending_energy_J wall_s".split()
        )
        for step in range(steps):
            time = 0.1 * step
            name = f"surface_{step:04}.vtp"
            bent_strip(10 * step / max(steps - 1, 1)).save(vtk / name)
            entries.append(f'<DataSet timestep="{time:g}" group="" part="0" file="{name}"/>')
            writer.writerow(
                [
                    step,
                    time,
                    0.1,
                    0,
                    4,
                    0,
                    4,
                    1e-9,
                    1e-7,
                    1e-6 * np.exp(-time),
                    1e-5 * time,
                    1e-4 * time**2,
                    0.2 * step,
                ]
            )
    body = "\n".join(entries)
    (vtk / "surface.pvd").write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
        f"{body}\n</Collection>\n</VTKFile>\n"
    )
    (vtk / "units.json").write_text(
        json.dumps(
            {"time": "s", "displacement": "m", "moisture_top": "1", "membrane_stress": "N/m"}
        )
    )


def write_ladder(path: Path) -> None:
    """Rows of a ladder of meshes: two formulations, second order, one row without an error."""
    rows = []
    for director, slow in (("mid_edge", 1.0), ("averaged", 0.6)):
        for level in range(5):
            faces = 64 * 4**level
            rows.append(
                {
                    "director": director,
                    "mesh": "regular",
                    "thickness": 1e-3,
                    "faces": faces,
                    "dofs": 3 * faces,
                    "error": None
                    if level == 4 and director == "averaged"
                    else 0.1 / slow / 4**level,
                    "order": None if level == 0 else 2.0,
                    "wall_s": 0.02 * slow * 4.6**level,
                    "factorizations": 8,
                }
            )
    path.write_text(json.dumps({"rows": rows}))
