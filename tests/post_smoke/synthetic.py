"""Writes a made-up case as thinshell exports one: the smoke test then runs without a build."""

import csv
import json
from pathlib import Path

import numpy as np
import pyvista as pv


STRIP = (0.2, 0.05)  # m


def bend(flat: np.ndarray, curvature: float) -> np.ndarray:
    """Points of the flat strip on a cylinder of the given curvature (1/m)."""
    bent = flat.copy()
    if curvature:
        bent[:, 0] = np.sin(curvature * flat[:, 0]) / curvature
        bent[:, 2] = (1 - np.cos(curvature * flat[:, 0])) / curvature
    return bent


def faces_of(surface: pv.DataSet) -> np.ndarray:
    """The corners of each face."""
    if isinstance(surface, pv.PolyData):
        return surface.faces.reshape(-1, 4)[:, 1:]
    return surface.cells.reshape(-1, 7)[:, 1:4]


def with_arrays(surface: pv.DataSet, flat: np.ndarray, curvature: float) -> pv.DataSet:
    surface.point_data["displacement"] = np.asarray(surface.points) - flat
    surface.point_data["moisture_top"] = (
        curvature / 10 * np.exp(-(((flat[:, 0] - 0.1) / 0.05) ** 2))
    )
    stress = np.zeros((surface.n_cells, 6))
    stress[:, 0] = 1e5 * curvature * np.sin(30 * surface.cell_centers().points[:, 0])
    surface.cell_data["membrane_stress"] = stress
    # Two halves, which must not flow into one another.
    middles = (flat[faces_of(surface)].mean(axis=1))[:, 0]
    surface.cell_data["thickness"] = np.where(middles < STRIP[0] / 2, 1e-3, 2e-3)
    return surface


def bent_strip(curvature: float, cells: tuple[int, int]) -> pv.PolyData:
    """A strip bent to a cylinder of the given curvature (1/m), of flat faces, with arrays."""
    plane = pv.Plane(
        center=(STRIP[0] / 2, 0.0, 0.0),
        i_size=STRIP[0],
        j_size=STRIP[1],
        i_resolution=cells[0],
        j_resolution=cells[1],
    ).triangulate()
    flat = np.asarray(plane.points, dtype=float)
    return with_arrays(pv.PolyData(bend(flat, curvature), plane.faces), flat, curvature)


def curved_strip(curvature: float) -> pv.UnstructuredGrid:
    """The same strip of curved faces: few of them, and points halfway along their edges."""
    columns, rows = 6, 2
    x, y = np.meshgrid(
        np.linspace(0, STRIP[0], 2 * columns + 1),
        np.linspace(-STRIP[1] / 2, STRIP[1] / 2, 2 * rows + 1),
        indexing="ij",
    )
    flat = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    node = np.arange(x.size).reshape(x.shape)
    cells = []
    for i in range(0, 2 * columns, 2):
        for j in range(0, 2 * rows, 2):
            n = node[i : i + 3, j : j + 3]
            cells.append([6, n[0, 0], n[2, 0], n[2, 2], n[1, 0], n[2, 1], n[1, 1]])
            cells.append([6, n[0, 0], n[2, 2], n[0, 2], n[1, 1], n[1, 2], n[0, 1]])
    types = np.full(len(cells), pv.CellType.QUADRATIC_TRIANGLE)
    grid = pv.UnstructuredGrid(np.ravel(cells), types, bend(flat, curvature))
    return with_arrays(grid, flat, curvature)


def write_case(
    case: Path, steps: int = 6, curved: bool = False, cells: tuple[int, int] = (40, 10)
) -> None:
    """The series, its units and a history in `case`; of curved faces if wanted, else so many flat."""
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
            name = f"surface_{step:04}.{'vtu' if curved else 'vtp'}"
            curvature = 10 * step / max(steps - 1, 1)
            strip = curved_strip(curvature) if curved else bent_strip(curvature, cells)
            strip.save(vtk / name)
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
                    "sampling": "edges",
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


def write_sweep(path: Path) -> None:
    """A sweep over two keys: the cube of the first, with its law, a constant that one run lacks, and the round-off of zero; with limits."""
    rows = []
    for thickness in (1e-3, 2e-3, 4e-3):
        for width in ("[3, 2]", "[6, 4]"):
            failed = thickness == 2e-3 and width == "[3, 2]"
            measures = [None] * 3 if failed else [5.0 * thickness**3, 4.0, 1e-53 * thickness]
            row = {"values": [thickness, width], "measures": measures}
            rows.append(row | ({"failure": "did not converge"} if failed else {}))
    fits = [
        {"measure": "energy", "at": width, "exponent": 3.0, "prefactor": 5.0}
        for width in ("[3, 2]", "[6, 4]")
    ]
    sweep = {
        "name": "scaling",
        "keys": ["shell.thickness", "mesh.rectangle.cells"],
        "measures": ["energy", "waves", "amplitude"],
        "limits": [[1e-9, None], [3.5, 4.5], [None, None]],
        "rows": rows,
        "fits": fits,
    }
    path.write_text(json.dumps({"scene": "made up", "passed": True, "sweeps": [sweep]}))
