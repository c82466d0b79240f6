"""Calibrates a camera from points that another detector found: calibrate_from_detections.py CAMERA.yaml

Here they are made up: a board of 11 x 8 corners seen by a camera of known lens, to 0.1 px.
"""

import sys

import numpy as np
from numpy.typing import NDArray

import planar_servo

SIZE = (1280, 960)
TRUTH = planar_servo.Camera("plumb_bob", 1400, 1400, 640, 480, [-0.1, 0.02])


def turned(degrees: tuple[float, float, float]) -> NDArray[np.float64]:
    """The rotation about x, then y, then z."""
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians(degrees)):
        c, s = np.cos(angle), np.sin(angle)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        about = np.eye(3)
        about[i, i] = about[j, j] = c
        about[i, j], about[j, i] = -s, s
        turn = about @ turn
    return turn


def detections(points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """One array (88, 2) of pixels for each view, in the order of the board's points."""
    random = np.random.default_rng(3)
    board = np.column_stack((points - points.mean(axis=0), np.zeros(len(points))))
    views = []
    for tilt in [(0, 0, 0), (30, 0, 5), (-30, 0, 20), (0, 30, 40), (0, -30, 60), (25, 25, 90)]:
        for shift in [(-0.04, -0.03), (0.04, 0.03)]:
            pixels = TRUTH.project(board @ turned(tilt).T + [*shift, 0.45])
            views.append(pixels + random.normal(0, 0.1, pixels.shape))
    return views


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    points = planar_servo.board_points("chessboard:11x8:25mm")
    found = planar_servo.calibrate_camera(points, detections(points), *SIZE)
    print(f"{found.model}: rms {found.rms_px:.3f} px, {found.held_out_rms_px:.3f} px left out")
    names = ("fx", "fy", "cx", "cy")
    for name, sigma in zip(names, found.standard_deviations):
        print(f"{name}: {getattr(found.camera, name):.2f} +- {sigma:.2f} px, "
              f"truth {getattr(TRUTH, name):.2f}")
    found.write(sys.argv[1])
    print("written:", sys.argv[1])


if __name__ == "__main__":
    main()
