"""Draws a small case with every script of post/ and looks at the pixels.

Usage: python tests/post_smoke/smoke.py [CASE]

CASE is the folder of a computed and exported case; without one a made-up case is drawn. Prints one
line per check and exits with 1 at the first that fails.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import imageio.v3 as iio
import numpy as np

from synthetic import write_case, write_ladder, write_sweep

POST = Path(__file__).resolve().parents[2] / "post"
sys.path.append(str(POST))

import plot_sweep  # noqa: E402
from case import load_series  # noqa: E402


class SmokeError(Exception):
    """A picture is not what it should be."""


def run(script: str, *arguments: object) -> None:
    finished = subprocess.run(
        [sys.executable, POST / script, *map(str, arguments)], capture_output=True, text=True
    )
    if finished.returncode != 0:
        raise SmokeError(
            f"{script} ended with {finished.returncode}: {finished.stderr}{finished.stdout}"
        )


def check(what: str, passed: bool, detail: str) -> None:
    if not passed:
        raise SmokeError(f"{what}: {detail}")
    print(f"post: ok: {what} ({detail})")


def field_of_view(picture: np.ndarray) -> np.ndarray:
    """The part of a picture that holds only the object: no title, no legend, no axes."""
    height, width = picture.shape[:2]
    return picture[int(0.1 * height) : int(0.78 * height), : int(0.8 * width), :3].astype(int)


def surface_pixels(picture: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of the coloured pixels; the grey outline has next to no saturation."""
    view = field_of_view(picture)
    return view[np.ptp(view, axis=2) > 24]


def check_picture(what: str, picture: np.ndarray, smallest_share: float) -> None:
    view = field_of_view(picture)
    coloured = surface_pixels(picture)
    share = len(coloured) / (view.shape[0] * view.shape[1])
    check(f"{what} shows a surface", smallest_share < share < 0.9, f"{share:.1%} of the view")
    hues = len(np.unique(coloured // 16, axis=0))
    check(f"{what} is coloured by the field", hues >= 8, f"{hues} distinct colours")


def check_plot(what: str, path: Path) -> None:
    picture = iio.imread(path)[..., :3].astype(int)
    coloured = float(np.mean(np.ptp(picture, axis=2) > 60))
    check(f"{what} has lines", coloured > 3e-4, f"{coloured:.2%} coloured")


def smoke_curved(folder: Path) -> None:
    """Few curved faces must look like many flat ones."""
    views = {}
    for name, curved in (("flat", False), ("curved", True)):
        write_case(folder / name, steps=2, curved=curved)
        picture = folder / f"{name}.png"
        run("render.py", folder / name, "-o", picture, "--size", "640x480")
        views[name] = np.ptp(field_of_view(iio.imread(picture)), axis=2) > 24
    drawn = load_series(folder / "curved").surfaces[-1].cell_centers().points
    off = np.abs(np.hypot(drawn[:, 0], drawn[:, 2] - 0.1) - 0.1).max()
    # Faces drawn flat would miss the cylinder by 1e-3 m, and halved ones by 2e-4 m.
    check("curved faces are drawn curved", off < 1e-4, f"{off:.1e} m off the cylinder")
    check_picture("the picture of curved faces", iio.imread(folder / "curved.png"), 0.005)
    different = np.logical_xor(*views.values()).sum() / views["flat"].sum()
    check("few curved faces look like many flat", different < 0.05, f"{different:.1%} differs")


def smoke_faces(folder: Path) -> None:
    """Arrays of faces keep one colour a face, and a picture uses all colours for its own range."""
    # This one has as many faces as points.
    write_case(folder / "few", steps=3, cells=(3, 2))
    write_case(folder / "faces", steps=3)
    picture = folder / "faces.png"
    look = ("-o", picture, "--camera", "z", "--size", "640x480")
    run("render.py", folder / "few", *look, "--step", "0", "--scalar", "thickness")
    _, counts = np.unique(surface_pixels(iio.imread(picture)) // 16, axis=0, return_counts=True)
    share = np.sort(counts)[-2:].sum() / counts.sum()
    check("faces of two values have two colours", share > 0.9, f"{share:.1%} of the surface")
    run("render.py", folder / "faces", *look, "--step", "1", "--scalar", "moisture_top")
    red, green, blue = surface_pixels(iio.imread(picture)).T
    yellow = float(np.mean((red > 180) & (green > 180) & (blue < 120)))
    check("a picture has a range of its own", yellow > 0.01, f"{yellow:.1%} at the top of it")


def smoke_sweep(folder: Path) -> None:
    """Constants and the round-off of zero have axes on which they can be read, keys their units."""
    write_sweep(folder / "axes.json")
    figure, _ = plot_sweep.draw(plot_sweep.load_sweeps(folder / "axes.json"), None, False)
    energy, waves, amplitude = figure.axes
    check("a power law has logarithmic axes", energy.get_yscale() == "log", energy.get_yscale())
    ticks = [tick for tick in waves.get_yticks() if waves.get_ylim()[0] <= tick <= waves.get_ylim()[1]]
    inside = waves.get_ylim()[0] < 3.5 < 4.5 < waves.get_ylim()[1]
    check("a constant has ticks and its limits in view", len(ticks) > 2 and inside, f"{ticks}")
    check("round-off has no logarithm", amplitude.get_yscale() == "linear", f"{amplitude.get_ylim()}")
    check("the key has its unit", energy.get_xlabel().endswith("[m]"), energy.get_xlabel())


def smoke(case: Path, folder: Path) -> None:
    run(
        "render.py",
        case,
        "-o",
        folder / "picture.png",
        "--film",
        folder / "film.mp4",
        "--size",
        "640x480",
    )
    check_picture("the picture", iio.imread(folder / "picture.png"), 0.005)
    run(
        "render.py",
        case,
        "-o",
        folder / "above.png",
        "--camera",
        "z",
        "--component",
        "x",
        "--edges",
        "--size",
        "640x480",
    )
    check_picture("the view from above", iio.imread(folder / "above.png"), 0.005)

    film = next(path for path in (folder / "film.mp4", folder / "film.gif") if path.is_file())
    frames = list(iio.imiter(film))
    shape = field_of_view(frames[0]).shape
    moved = max(
        float(np.mean(np.abs(field_of_view(frame) - field_of_view(frames[0])) > 40))
        for frame in frames
    )
    check(
        "the film moves",
        len(frames) > 1 and moved > 1e-3,
        f"{len(frames)} frames of {shape[1]}x{shape[0]}, {moved:.1%} changes",
    )

    run("history.py", case, "-o", folder / "history.png")
    check_plot("the history", folder / "history.png")
    write_ladder(folder / "ladder.json")
    run("plot_report.py", folder / "ladder.json", "-o", folder / "ladder.png")
    check_plot("the ladder", folder / "ladder.png")
    write_sweep(folder / "sweep.json")
    run("plot_sweep.py", folder / "sweep.json", "-o", folder / "sweep.png")
    check_plot("the sweep", folder / "sweep.png")


def main() -> int:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        if len(sys.argv) > 1:
            case = Path(sys.argv[1])
        else:
            case = folder / "case"
            write_case(case)
        try:
            smoke(case, folder)
            smoke_curved(folder)
            smoke_faces(folder)
            smoke_sweep(folder)
        except SmokeError as error:
            print(f"post: FAILED: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
