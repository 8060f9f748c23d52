"""Draws a case: a picture of one time, and a film of all of them if asked for.

Usage: python post/render.py CASE [-o picture.png] [--film film.mp4] [--scalar NAME]
                             [--component C] [--camera WHERE] [--warp FACTOR]
                             [--time T | --step N] [--size WxH] [--edges] [--cmap NAME]

Reads only what `thinshell export` wrote: CASE/vtk/*.pvd, the surfaces it names, and
CASE/vtk/units.json. The camera and the outline are chosen once for all times, so that pictures of
several times compare. The colours of a film span the range of all times, those of a picture its own.
Arrays of faces are drawn with one colour a face.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import imageio.v2 as imageio
import matplotlib
import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkLogger
from vtkmodules.vtkRenderingCore import vtkTextProperty

from case import CaseError, Series, load_series

# Towards the viewer, in (along the longer horizontal side, along the shorter one, up).
AUTO_DIRECTION = (-0.55, -1.0, 0.6)
DIRECTIONS = {
    "iso": (1.0, -1.0, 0.8),
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, -1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
}
VIEW_ANGLE = 20.0  # degrees; small, so that perspective does not pass for deformation
COMPONENTS = {
    2: ("1", "2"),
    3: ("x", "y", "z"),
    6: ("xx", "yy", "zz", "xy", "yz", "xz"),
    9: ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
}
INK = "#202428"
FONT = str(Path(matplotlib.get_data_path()) / "fonts/ttf/DejaVuSans.ttf")
VTK_FONT_FILE = 4  # vtkTextProperty: use the font file
FILM_SECONDS = 6.0  # at 1 to 30 frames a second


# VTK warns that there is no X server before it turns to EGL or OSMesa, which is meant here.
vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)


def parse_arguments(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("case", type=Path, help="folder of the case, or a .pvd file")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        help="the picture [CASE/picture.png, unless only --film is given]",
    )
    parser.add_argument(
        "--film",
        type=Path,
        help="film of all times, .mp4 or .gif; .gif where no encoder is installed",
    )
    parser.add_argument(
        "--scalar",
        default="displacement",
        help="point or cell array that colours the surface [%(default)s]",
    )
    parser.add_argument(
        "--component", help="of a vector or tensor: x, xy, 1 ... [its Euclidean or Frobenius norm]"
    )
    parser.add_argument(
        "--camera",
        nargs="+",
        default=["auto"],
        help="auto, iso, x, y, z, or nine numbers: position, focus, up",
    )
    parser.add_argument(
        "--warp",
        type=float,
        default=1.0,
        help="factor on the displacement; other than 1 is said in the title",
    )
    when = parser.add_mutually_exclusive_group()
    when.add_argument(
        "--time", type=float, help="draw the exported time nearest to this one [the last]"
    )
    when.add_argument(
        "--step",
        type=int,
        help="draw the N-th exported time, from 0; negative ones count from the end",
    )
    parser.add_argument("--size", default="1280x960", help="pixels, WxH [%(default)s]")
    parser.add_argument(
        "--edges",
        action="store_true",
        help="draw the edges of the mesh; of curved faces those of their flat pieces",
    )
    parser.add_argument(
        "--cmap",
        help="colour map of matplotlib [viridis; coolwarm about zero if the sign changes]",
    )
    options = parser.parse_args(arguments)
    try:
        width, height = (int(side) for side in options.size.split("x"))
    except ValueError:
        parser.error(f"--size {options.size}: expected WIDTHxHEIGHT, such as 1280x960")
    # Video encoders want even numbers.
    options.size = (max(width, 64) // 2 * 2, max(height, 64) // 2 * 2)
    if len(options.camera) == 9:
        try:
            options.camera = [float(number) for number in options.camera]
        except ValueError:
            parser.error("--camera: expected nine numbers")
    elif len(options.camera) != 1 or options.camera[0] not in ("auto", *DIRECTIONS):
        parser.error("--camera: expected auto, iso, x, y, z or nine numbers")
    if options.film and options.film.suffix not in (".mp4", ".gif"):
        parser.error(f"--film {options.film}: expected .mp4 or .gif")
    if options.cmap and options.cmap not in matplotlib.colormaps:
        parser.error(f"--cmap {options.cmap}: matplotlib has no such colour map")
    if options.output is None and options.film is None:
        options.output = (
            options.case.parent if options.case.suffix == ".pvd" else options.case
        ) / "picture.png"
    return options


def component_index(text: str, count: int, array: str) -> int:
    """Index of a component given as a name (xy) or as a number from 1."""
    names = COMPONENTS.get(count, ())
    if text in names:
        return names.index(text)
    if text.isdigit() and 1 <= int(text) <= count:
        return int(text) - 1
    raise CaseError(f"--component {text}: '{array}' has {', '.join(names) or f'1 to {count}'}")


def colour_values(surface: pv.PolyData, array: str, component: str | None) -> np.ndarray:
    """One number per point or cell: the array itself, one component of it, or its norm."""
    data = surface.point_data if array in surface.point_data else surface.cell_data
    if array not in data:
        known = sorted({*surface.point_data.keys(), *surface.cell_data.keys()})
        raise CaseError(
            f"--scalar {array}: not exported; there are {', '.join(known) or 'no arrays'}"
        )
    values = np.asarray(data[array], dtype=float)
    if values.ndim == 1:
        return values
    if component is not None:
        return values[:, component_index(component, values.shape[1], array)]
    # The symmetric tensors keep each shear once; the norm counts it twice.
    weights = np.array([1, 1, 1, 2, 2, 2]) if values.shape[1] == 6 else np.ones(values.shape[1])
    return np.sqrt(values**2 @ weights)


def colour_label(series: Series, array: str, component: str | None) -> str:
    first = series.surfaces[0]
    shape = (first.point_data if array in first.point_data else first.cell_data)[array].shape
    part = "" if len(shape) == 1 else f", {component}" if component else ", norm"
    unit = series.units.get(array, "")
    return f"{array.replace('_', ' ')}{part}" + (f"\n[{unit}]" if unit not in ("", "1") else "")


def colour_range(values: list[np.ndarray]) -> tuple[float, float]:
    """The range of these values; even about zero if the sign changes; never empty."""
    finite = np.concatenate([array[np.isfinite(array)] for array in values])
    if finite.size == 0:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    # Rounding noise about a constant would otherwise use the whole colour map.
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        margin = 0.5 * max(abs(low), abs(high)) or 1.0
        return low - margin, high + margin
    if low < -0.02 * high and high > -0.02 * low:
        return -max(-low, high), max(-low, high)
    return low, high


def warp(surface: pv.PolyData, factor: float) -> pv.PolyData:
    """The surface with its displacement multiplied by `factor`."""
    if factor == 1.0:
        return surface
    if "displacement" not in surface.point_data:
        raise CaseError("--warp: the array 'displacement' was not exported")
    warped = surface.copy()
    warped.points = surface.points + (factor - 1.0) * np.asarray(
        surface.point_data["displacement"]
    )
    return warped


def view_direction(camera: str, extent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors towards the viewer and up."""
    if camera == "auto":
        along, across, up = AUTO_DIRECTION
        # The longer horizontal side runs across the picture.
        direction = (along, across, up) if extent[0] >= extent[1] else (-across, along, up)
    else:
        direction = DIRECTIONS[camera]
    towards = np.array(direction) / np.linalg.norm(direction)
    up = np.array([0.0, 1.0, 0.0]) if abs(towards[2]) > 0.99 else np.array([0.0, 0.0, 1.0])
    return towards, up


def place_camera(plotter: pv.Plotter, points: np.ndarray, camera: list) -> None:
    """Frames all points, those of all times, in the part of the picture beside the legend."""
    plotter.camera.view_angle = VIEW_ANGLE
    if len(camera) == 9:
        plotter.camera_position = [camera[0:3], camera[3:6], camera[6:9]]
        plotter.reset_camera_clipping_range()
        return
    low, high = points.min(axis=0), points.max(axis=0)
    towards, up = view_direction(camera[0], high - low)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    above = np.cross(towards, right)
    centre = 0.5 * (low + high)
    # The outline has to fit as well: its corners may reach further than any point.
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    local = (np.vstack([points, corners]) - centre) @ np.column_stack([right, above, towards])
    middle = 0.5 * (local.min(axis=0) + local.max(axis=0)) * [1, 1, 0]
    centre = centre + middle[0] * right + middle[1] * above
    local -= middle
    tangent = np.tan(np.radians(VIEW_ANGLE / 2))
    aspect = plotter.window_size[0] / plotter.window_size[1]
    # Shares of the half width and half height that the object may fill.
    room = np.array([0.78 * aspect, 0.8]) * tangent
    distance = float(np.max(local[:, 2:] + np.abs(local[:, :2]) / room))
    plotter.camera_position = [centre + distance * towards, centre, up]
    plotter.camera.SetWindowCenter(0.12, 0.0)
    plotter.reset_camera_clipping_range()


def set_font(text: vtkTextProperty) -> None:
    text.SetFontFamily(VTK_FONT_FILE)
    text.SetFontFile(FONT)


class Stage:
    """What is the same at all times, and the plotter that draws one time after another."""

    def __init__(self, series: Series, options: argparse.Namespace) -> None:
        self.series = series
        self.options = options
        self.surfaces = [warp(surface, options.warp) for surface in series.surfaces]
        self.values = [
            colour_values(surface, options.scalar, options.component)
            for surface in series.surfaces
        ]
        self.label = colour_label(series, options.scalar, options.component)
        self.points = np.vstack([np.asarray(surface.points) for surface in self.surfaces])
        self.scale = options.size[1] / 960.0
        self.plotter = pv.Plotter(
            off_screen=True, window_size=list(options.size), lighting="light kit"
        )
        self.plotter.set_background("white")
        self.plotter.enable_anti_aliasing("ssaa")
        self._add_frame()
        place_camera(self.plotter, self.points, options.camera)

    def _add_frame(self) -> None:
        """Outline of the space all times fill, the boundary at the first time, and the axes."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        bounds = np.column_stack([low, high]).ravel()
        self.plotter.add_mesh(
            pv.Box(bounds).extract_all_edges(), color="#c4c8cc", line_width=1.2 * self.scale
        )
        first = self.surfaces[0].extract_feature_edges(
            feature_edges=False, manifold_edges=False, non_manifold_edges=False
        )
        if first.n_points:
            self.plotter.add_mesh(first, color="#8a9096", line_width=1.6 * self.scale)
        self.plotter.add_axes(color=INK, line_width=3, viewport=(0.0, 0.0, 0.16, 0.21))
        size = "  x  ".join(f"{side:.3g}" for side in high - low)
        self._add_text(f"outline {size} m", (0.17, 0.03), 8, "#60666c", "outline")

    def _add_text(
        self, text: str, position: tuple[float, float], size: float, color: str, name: str
    ) -> None:
        size = max(round(size * self.scale), 4)
        self.plotter.add_text(
            text,
            position=position,
            viewport=True,
            font_size=size,
            color=color,
            font_file=FONT,
            name=name,
        )

    def _add_scalar_bar(self) -> None:
        bar = self.plotter.add_scalar_bar(
            self.label + "\n",
            vertical=True,
            position_x=0.855,
            position_y=0.18,
            width=0.08,
            height=0.62,
            n_labels=5,
            fmt="{:.3g}",
            color=INK,
            title_font_size=round(17 * self.scale),
            label_font_size=round(16 * self.scale),
            unconstrained_font_size=True,
        )
        bar.SetTextPad(round(6 * self.scale))
        set_font(bar.GetTitleTextProperty())
        set_font(bar.GetLabelTextProperty())

    def draw(self, step: int, colours: tuple[float, float]) -> np.ndarray:
        """The picture of one exported time, coloured over a range, as (height, width, 3) bytes."""
        surface = self.surfaces[step].copy()
        values = self.values[step]
        # By name: a mesh may have as many faces as points.
        on_points = self.options.scalar in surface.point_data
        data = surface.point_data if on_points else surface.cell_data
        data["colour"] = values
        diverging = colours[0] == -colours[1]
        self.plotter.add_mesh(
            surface,
            scalars="colour",
            preference="point" if on_points else "cell",
            name="surface",
            clim=colours,
            cmap=self.options.cmap or ("coolwarm" if diverging else "viridis"),
            smooth_shading=True,
            show_edges=self.options.edges,
            edge_color="#30363c",
            edge_opacity=0.5,
            ambient=0.45,
            diffuse=0.7,
            specular=0.15,
            specular_power=25,
            nan_color="#b0b0b0",
            show_scalar_bar=False,
            reset_camera=False,
        )
        for title in list(self.plotter.scalar_bars.keys()):
            self.plotter.remove_scalar_bar(title)
        self._add_scalar_bar()
        title = f"{self.series.name}    {self.series.moment(step)}"
        if self.options.warp != 1.0:
            title += f"    displacement x {self.options.warp:g}"
        self._add_text(title, (0.03, 0.93), 12, INK, "title")
        self.plotter.reset_camera_clipping_range()
        return self.plotter.screenshot(return_img=True)


def chosen_step(times: list[float], options: argparse.Namespace) -> int:
    if options.time is not None:
        return int(np.argmin(np.abs(np.array(times) - options.time)))
    if options.step is None:
        return len(times) - 1
    if not -len(times) <= options.step < len(times):
        raise CaseError(
            f"--step {options.step}: there are {len(times)} exported times, 0 to {len(times) - 1}"
        )
    return options.step % len(times)


def film_path(wanted: Path) -> Path:
    """The path asked for, or one for a GIF where no video encoder is installed."""
    if wanted.suffix == ".mp4":
        try:
            import imageio_ffmpeg

            imageio_ffmpeg.get_ffmpeg_exe()
        except (ImportError, RuntimeError):
            print("render: no video encoder (imageio-ffmpeg); writing a GIF instead")
            return wanted.with_suffix(".gif")
    return wanted


def write_film(path: Path, stage: Stage) -> None:
    count = len(stage.surfaces)
    colours = colour_range(stage.values)
    rate = float(np.clip(count / FILM_SECONDS, 1, 30))
    if path.suffix == ".mp4":
        # Sides are even, so the encoder needs no padding to blocks.
        writer = imageio.get_writer(path, fps=rate, codec="libx264", quality=8, macro_block_size=2)
    else:
        writer = imageio.get_writer(path, duration=1000 / rate, loop=0)
    with writer:
        for step in range(count):
            writer.append_data(stage.draw(step, colours))


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse_arguments(arguments)
    try:
        series = load_series(options.case)
        step = chosen_step(series.times, options)
        stage = Stage(series, options)
    except CaseError as error:
        print(f"render: {error}", file=sys.stderr)
        return 2
    for path in (options.output, options.film):
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
    if options.output is not None:
        imageio.imwrite(options.output, stage.draw(step, colour_range([stage.values[step]])))
        print(f"render: {options.output} ({options.scalar} at {series.moment(step)})")
    if options.film is not None:
        film = film_path(options.film)
        write_film(film, stage)
        print(f"render: {film} ({len(series.times)} frames)")
    stage.plotter.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
