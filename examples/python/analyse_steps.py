"""Says how a run of planar-servo went, from its steps.csv: analyse_steps.py RUN [PICTURE.png]"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

import planar_servo

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    run = Path(sys.argv[1])
    steps = planar_servo.read_table(run / "steps.csv")
    results = planar_servo.read_table(run / "results.csv")
    record = planar_servo.read_file(run / "run.yaml")
    print(f"{record.format}: {len(results)} targets, {np.sum(results['status'] == 'reached')} reached")

    seen = steps[np.isfinite(steps["miss_mm"])]
    for number in np.unique(seen["step"]):
        miss = seen["miss_mm"][seen["step"] == number]
        print(f"look {number}: {len(miss)} targets, {np.median(miss):.4f} mm away in the median, "
              f"{miss.max():.4f} mm at most")
    ends = np.array([seen["miss_mm"][seen["target"] == name][-1] for name in np.unique(seen["target"])])
    print(f"at the end by its own view: {ends.mean():.4f} mm mean")
    if np.any(np.isfinite(results["after_truth_mm"])):
        print(f"by the truth: {np.nanmean(results['after_truth_mm']):.4f} mm mean")

    if len(sys.argv) > 2:
        figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
        for name in np.unique(seen["target"]):
            way = seen[seen["target"] == name]
            axes.plot(way["step"], 1e3 * way["miss_mm"], "o-", color="tab:blue", alpha=0.5)
        axes.set(title=f"{len(results)} targets", xlabel="look", ylabel="seen from the target, µm")
        axes.set_ylim(bottom=0)
        axes.xaxis.get_major_locator().set_params(integer=True)
        figure.savefig(sys.argv[2], dpi=100)


if __name__ == "__main__":
    main()
