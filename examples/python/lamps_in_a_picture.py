"""Finds the two lamps of a tool in a picture: lamps_in_a_picture.py [PICTURE]

Without a picture it draws two lamps about (200.1875, 150.6875) and (300.4375, 179.9375).
"""

import sys

import numpy as np
from numpy.typing import NDArray

import planar_servo


def draw_lamps() -> NDArray[np.uint8]:
    """Two discs of 20 px, each pixel the mean of 8 x 8 finer ones, blurred a little."""
    v, u = (np.mgrid[0 : 8 * 320, 0 : 8 * 480] - 3.5) / 8
    fine = np.full(u.shape, 12.0)
    for center in ((200.1875, 150.6875), (300.4375, 179.9375)):
        fine[np.hypot(u - center[0], v - center[1]) < 10.0] = 200.0
    image = fine.reshape(320, 8, 480, 8).mean(axis=(1, 3))
    for axis in (0, 1):
        image = 0.5 * image + 0.25 * (np.roll(image, 1, axis) + np.roll(image, -1, axis))
    grey: NDArray[np.uint8] = np.round(image).astype(np.uint8)
    return grey


def read_grey(path: str) -> NDArray[np.uint8]:
    from matplotlib.image import imread  # any other reader will do

    picture = imread(path)
    if picture.ndim == 3:
        picture = picture[..., :3].mean(axis=2)
    scale = 255 if picture.dtype.kind == "f" and picture.max() <= 1 else 1
    grey: NDArray[np.uint8] = np.round(picture * scale).astype(np.uint8)
    return grey


def main() -> int:
    image = read_grey(sys.argv[1]) if len(sys.argv) > 1 else draw_lamps()
    pair = planar_servo.LampTracker().locate(image)
    print("the pair:", pair.status)
    for lamp in pair.lamps:
        sigma = np.sqrt(np.trace(lamp.covariance_px2) / 2)
        print(f"{lamp.status}: center ({lamp.uv_px[0]:.3f}, {lamp.uv_px[1]:.3f}) px, "
              f"known to {sigma:.3f} px, diameter {lamp.diameter_px:.2f} px")
    return 0 if pair.status in ("ok", "ambiguous") else 1


if __name__ == "__main__":
    sys.exit(main())
