"""Fits an error map to pairs and draws it: fit_and_plot_map.py [PAIRS.csv] PICTURE.png"""

import sys

import matplotlib
import numpy as np
from numpy.typing import NDArray

import planar_servo

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def made_up_pairs() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What an uncorrected lens might do over a field of one metre, with noise of 5 um."""
    random = np.random.default_rng(1)
    p = random.uniform(-0.5, 0.5, (150, 2))
    error = np.column_stack((3e-4 * np.sin(5 * p[:, 0]), 2e-4 * np.cos(6 * p[:, 1]) * p[:, 0]))
    return p, p - error + random.normal(0, 5e-6, p.shape)


def read_pairs(path: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rows = planar_servo.read_table(path, "pairs")
    rows = rows[np.isfinite(rows["x_tracker_mm"])]
    vision = np.column_stack((rows["x_vision_mm"], rows["y_vision_mm"]))
    tracker = np.column_stack((rows["x_tracker_mm"], rows["y_tracker_mm"]))
    return vision / 1e3, tracker / 1e3


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    p_vision, p_tracker = read_pairs(sys.argv[1]) if len(sys.argv) > 2 else made_up_pairs()
    fit = planar_servo.fit_error_map(p_vision, p_tracker)
    print(f"{fit.map.kind}, {fit.n_used} pairs: rms {1e6 * fit.raw_rms:.1f} um before, "
          f"{1e6 * fit.loo_rms:.1f} um at places left out")
    low, high = p_vision.min(axis=0), p_vision.max(axis=0)
    x, y = np.meshgrid(np.linspace(low[0], high[0], 80), np.linspace(low[1], high[1], 80))
    error, sigma, inside = fit.map.predict(np.column_stack((x.ravel(), y.ravel())))
    length = np.where(inside, 1e6 * np.hypot(*error.T), np.nan).reshape(x.shape)

    figure, axes = plt.subplots(figsize=(7, 6))
    mesh = axes.pcolormesh(1e3 * x, 1e3 * y, length, shading="nearest")
    arrows = p_vision - p_tracker
    axes.quiver(*(1e3 * p_vision.T), *arrows.T, color="white", width=0.003)
    axes.set(xlabel="x, mm", ylabel="y, mm", aspect="equal",
             title=f"vision error, known to {1e6 * np.median(sigma[inside]):.1f} um (median)")
    figure.colorbar(mesh, label="µm")
    figure.savefig(sys.argv[-1], dpi=100)


if __name__ == "__main__":
    main()
