"""Positions the arm of a calibrated cell and plots its looks: servo_with_live_plot.py CELL.yaml [PICTURE.png]

With a picture nothing is shown and the plot ends there. Ctrl-C brings the arm to rest.
"""

import sys

import matplotlib
import numpy as np

import planar_servo

if len(sys.argv) > 2:
    matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

TARGETS = np.array([[0.15, 0.25], [-0.2, 0.3], [0.05, -0.35]])  # metres, base frame


def main() -> int:
    figure, axes = plt.subplots(figsize=(7, 4))
    axes.set(xlabel="look", ylabel="from the target, mm", yscale="log")
    distances_mm: list[float] = []
    (line,) = axes.plot([], [], "o-")

    def show(step: planar_servo.Step) -> None:
        if step.p_believed is None:
            print(f"  not seen: {step.status}")
            return
        distances_mm.append(1e3 * float(np.hypot(*(step.target - step.p_believed))))
        print(f"  look {step.iteration}: {distances_mm[-1]:.4f} mm away, "
              f"known to {1e3 * step.uncertainty:.4f} mm")
        line.set_data(np.arange(len(distances_mm)), distances_mm)
        axes.relim()
        axes.autoscale_view()
        plt.pause(0.001)

    reached = 0
    with planar_servo.Cell(sys.argv[1]) as cell:
        for target in TARGETS:
            move = cell.move_to(target, on_step=show)
            reached += move.reached
            print(f"({1e3 * target[0]:.0f}, {1e3 * target[1]:.0f}) mm: {move.status} {move.reason}")
            truth = cell.true_position()
            if truth is not None:
                print(f"  {1e3 * np.hypot(*(truth - target)):.4f} mm away in truth")
    figure.savefig(sys.argv[2], dpi=100) if len(sys.argv) > 2 else plt.show()
    return 0 if reached == len(TARGETS) else 1


if __name__ == "__main__":
    sys.exit(main())
