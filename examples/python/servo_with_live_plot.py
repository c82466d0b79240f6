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
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    figure, axes = plt.subplots(figsize=(7, 4))
    axes.set(xlabel="corrections", ylabel="from the target, mm", yscale="log")
    axes.xaxis.get_major_locator().set_params(integer=True)
    reached = 0
    with planar_servo.Cell(sys.argv[1]) as cell:
        for target in TARGETS:
            name = f"({1e3 * target[0]:.0f}, {1e3 * target[1]:.0f}) mm"
            (line,) = axes.plot([], [], "o-", label=name)
            axes.legend()

            def show(step: planar_servo.Step) -> None:
                if step.p_believed is None:
                    print(f"  not seen: {step.status}")
                    return
                far_mm = 1e3 * float(np.hypot(*(step.target - step.p_believed)))
                print(f"  {far_mm:.4f} mm away, known to {1e3 * step.uncertainty:.4f} mm")
                line.set_data([*line.get_xdata(), step.iteration], [*line.get_ydata(), far_mm])
                axes.relim()
                axes.autoscale_view()
                plt.pause(0.001)

            move = cell.move_to(target, on_step=show)
            reached += move.reached
            print(f"{name}: {move.status} {move.reason}")
            truth = cell.true_position()
            if truth is not None:
                print(f"  {1e3 * np.hypot(*(truth - target)):.4f} mm away in truth")
    if len(sys.argv) > 2:
        figure.savefig(sys.argv[2], dpi=100)
    else:
        plt.show()
    return 0 if reached == len(TARGETS) else 1


if __name__ == "__main__":
    sys.exit(main())
