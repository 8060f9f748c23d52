"""Opens a case in ParaView, colours it by one array and saves a screenshot.

Usage: pvpython post/paraview_view.py CASE [-o paraview.png] [--scalar NAME] [--component C]
                                      [--time T] [--size WxH] [--state view.pvsm]

For ParaView 5.11 or newer; tested with 5.11.0 of Debian 12. That build draws only with an X
server, so on a machine without one: xvfb-run -a pvpython post/paraview_view.py CASE.

Reads CASE/vtk/*.pvd and CASE/vtk/units.json. `--state` also writes a state file, which opens the
same view in the ParaView window.
"""

import argparse
import json
import sys
from pathlib import Path

from paraview import simple


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("case", type=Path, help="folder of the case, or a .pvd file")
    parser.add_argument("-o", "--output", type=Path, help="the picture [CASE/paraview.png]")
    parser.add_argument(
        "--scalar", default="displacement", help="point or cell array [%(default)s]"
    )
    parser.add_argument(
        "--component", default="Magnitude", help="of a vector or tensor: X, XY, ... [%(default)s]"
    )
    parser.add_argument(
        "--time", type=float, help="the exported time nearest to this one [the last]"
    )
    parser.add_argument("--size", default="1280x960", help="pixels, WxH [%(default)s]")
    parser.add_argument("--state", type=Path, help="state file to write, .pvsm")
    options = parser.parse_args()
    try:
        options.size = [int(side) for side in options.size.split("x", 1)]
        if len(options.size) != 2:
            raise ValueError
    except ValueError:
        parser.error(f"--size {options.size}: expected WIDTHxHEIGHT, such as 1280x960")
    return options


def find_series(case: Path) -> Path:
    if case.suffix == ".pvd":
        return case
    found = sorted((case / "vtk").glob("*.pvd"))
    if not found:
        sys.exit(f"paraview_view: {case / 'vtk'}: no .pvd file; run `thinshell export` first")
    return found[0]


def main() -> None:
    options = parse_arguments()
    pvd = find_series(options.case)
    source = simple.PVDReader(registrationName=pvd.stem, FileName=str(pvd.resolve()))
    simple.UpdatePipeline(proxy=source)
    times = list(source.TimestepValues) or [0.0]
    time = (
        times[-1]
        if options.time is None
        else min(times, key=lambda known: abs(known - options.time))
    )

    in_points = options.scalar in source.PointData.keys()
    arrays = source.PointData if in_points else source.CellData
    if options.scalar not in arrays.keys():
        known = ", ".join([*source.PointData.keys(), *source.CellData.keys()])
        sys.exit(f"paraview_view: --scalar {options.scalar}: not exported; there are {known}")
    vector = arrays[options.scalar].GetNumberOfComponents() > 1

    view = simple.CreateView("RenderView")
    view.ViewSize = options.size
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.OrientationAxesLabelColor = [0.1, 0.1, 0.1]
    view.ViewTime = time
    simple.GetAnimationScene().AnimationTime = time
    simple.UpdatePipeline(time=time, proxy=source)

    display = simple.Show(source, view, "GeometryRepresentation")
    display.Representation = "Surface"
    # Sheets are lit from one side only; without this the other one is nearly black.
    display.Ambient = 0.35
    colour = ("POINTS" if in_points else "CELLS", options.scalar)
    simple.ColorBy(display, (*colour, options.component) if vector else colour)
    # The range of all times, so that pictures of several times compare.
    display.RescaleTransferFunctionToDataRangeOverTime()

    units_file = pvd.parent / "units.json"
    units = json.loads(units_file.read_text()) if units_file.is_file() else {}
    table = simple.GetColorTransferFunction(options.scalar)
    table.ApplyPreset("Viridis (matplotlib)", True)
    bar = simple.GetScalarBar(table, view)
    bar.Title = f"{options.scalar.replace('_', ' ')} [{units.get(options.scalar, '1')}]"
    bar.ComponentTitle = options.component.lower() if vector else ""
    bar.TitleColor = bar.LabelColor = [0.1, 0.1, 0.1]
    bar.Visibility = 1

    unit = units.get("time", "1")
    moment = f"t = {time:.4g}" + (f" {unit}" if unit != "1" else "")
    title = simple.Text(registrationName="time", Text=f"{options.case.resolve().stem}    {moment}")
    simple.Show(title, view).Color = [0.1, 0.1, 0.1]

    simple.ResetCamera(view)
    view.CameraViewUp = [0.0, 0.0, 1.0]
    focus = view.CameraFocalPoint
    distance = sum((there - here) ** 2 for there, here in zip(view.CameraPosition, focus)) ** 0.5
    direction = (-0.43, -0.77, 0.47)
    view.CameraPosition = [centre + distance * part for centre, part in zip(focus, direction)]
    simple.ResetCamera(view)

    folder = options.case.parent if options.case.suffix == ".pvd" else options.case
    output = options.output or folder / "paraview.png"
    simple.SaveScreenshot(str(output), view, ImageResolution=options.size)
    print(f"paraview_view: {output} ({options.scalar} at {moment})")
    if options.state:
        simple.SaveState(str(options.state))
        print(f"paraview_view: {options.state}")


if __name__ == "__main__":
    main()
