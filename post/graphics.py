"""Tells whether this machine can draw off screen: renders a ball and looks for it in the picture.

Usage: python post/graphics.py

Exit code 0 if the ball is there, 1 or a crash otherwise; the last line printed says what is wrong.
"""

import sys

import numpy as np
import pyvista as pv


def main() -> int:
    plotter = pv.Plotter(off_screen=True, window_size=(64, 64))
    plotter.set_background("white")
    plotter.add_mesh(pv.Sphere(theta_resolution=8, phi_resolution=8), color="black")
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    dark = float(np.mean(picture.mean(axis=2) < 200))
    if not 0.05 < dark < 0.95:
        print(f"the test picture is blank ({dark:.0%} of it is dark)")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
