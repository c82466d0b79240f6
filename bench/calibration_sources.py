#!/usr/bin/env python3
"""Prints what each source of a calibration is worth: mean true error of the closed loop over the
control targets, in mm, median over seeds, and beside it what planar-experiment predicted and which
share of the compensated end points lay within their stated 95 % interval.

    bench/calibration_sources.py BIN_DIR OUT_DIR [--rows NAME[,NAME]] [--seeds N]

On a cell of calib/ a seed draws the plan; drawn cells have the seeds 501, 502, ..., which nothing was
designed on. Figures of every run stay in OUT_DIR/NAME_SEED.json; a run that is there is not made
again. Exit status 1 when a median is above its bound."""

import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys

FIRST_DRAWN = 501
CALIB = pathlib.Path(__file__).resolve().parent.parent / "calib"
NO_READINGS = ["--train", "0", "--unattended", "1000", "--lays", "12", "--board-thickness-mm"]
# name: (kind of cell, options, bound in mm, runs)
ROWS = {
    "paper_200": ("paper", ["--train", "200"], 0.0075, 5),
    "paper_200_1000": ("paper", ["--train", "200", "--unattended", "1000"], 0.0060, 5),
    "paper_12_1000": ("paper", ["--train", "12", "--unattended", "1000"], 0.0095, 5),
    "like_paper_200": ("like paper", ["--train", "200"], 0.006, 10),
    # A caliper shows how far the dots lie below the lamps; the scorer takes out the turn.
    "paper_0_1000": ("paper", [*NO_READINGS, "-5.5"], 0.025, 5),
    "ordinary_0_1000": ("ordinary", [*NO_READINGS, "-5.4"], 0.025, 5),
    "cheap_0_1000": ("cheap", [*NO_READINGS, "-4.8"], 0.050, 5),
    "cheap_12_1000": ("cheap", ["--train", "12", "--unattended", "1000"], 0.050, 5),
    "rough_200": ("like rough", ["--train", "200"], 0.012, 10),
    "rough_200_1000": ("like rough", ["--train", "200", "--unattended", "1000"], 0.010, 10),
}


def cell_of(bin_dir, kind, seed, folder):
    if not kind.startswith("like "):
        return CALIB / kind / "cell.yaml"
    like = kind.split()[1]
    subprocess.run([bin_dir / "planar-virtual-cell", "-q", "draw", "--seed", str(seed), "--like",
                    like, "-o", folder], check=True, stdout=subprocess.DEVNULL)
    return folder / "cell.yaml"


def figures_of(bin_dir, out, name, run):
    """Returns the figures of one run, or why there are none."""
    kind, options, _, _ = ROWS[name]
    drawn = kind.startswith("like ")
    seed = FIRST_DRAWN + run if drawn else 1 + run
    file = out / f"{name}_{seed}.json"
    if not file.exists():
        work = out / f"{name}_{seed}"
        shutil.rmtree(work, ignore_errors=True)
        cell = cell_of(bin_dir, kind, seed, work / "cell")
        done = subprocess.run(
            [bin_dir / "planar-experiment", "-q", "--cell", cell, "--out", work / "run", "--json",
             file, "--seed", "1" if drawn else str(seed), *options],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        shutil.rmtree(work, ignore_errors=True)
        if done.returncode != 0:
            return {"failed": f"seed {seed}: {done.stderr.strip().splitlines()[-1]}"}
    return json.loads(file.read_text())


def row_text(name, runs):
    bound = ROWS[name][2]
    good = [run for run in runs if "failed" not in run]
    if not good:
        return f"{name:<16} {bound:.4f}  none of {len(runs)} runs came to its end", False

    def median(key):
        return statistics.median(run[key] for run in good)

    mean, p95 = median("after_mean_mm_truth"), median("after_p95_mm_truth")
    text = (f"{name:<16} {bound:.4f}  {mean:.4f}  {p95:.4f}  "
            f"{median('predicted_mean_mm') / mean:.2f}  {median('predicted_p95_mm') / p95:.2f}  "
            f"{100 * statistics.mean(run['coverage_95_truth'] for run in good):.0f} %  "
            f"{median('iterations_median'):.0f}  {median('seconds_per_target'):.2f} s  "
            f"{len(good)} of {len(runs)} runs  "
            + " ".join(f"{run['after_mean_mm_truth']:.4f}" for run in good))
    return text, mean <= bound


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("out_dir", type=pathlib.Path)
    parser.add_argument("--rows", default=",".join(ROWS))
    parser.add_argument("--seeds", type=int, help="at most so many runs a row")
    options = parser.parse_args()
    options.out_dir.mkdir(parents=True, exist_ok=True)
    print("row              bound   mean    95 %    predicted/came: mean, 95 %  within stated 95 %  corrections  time")
    within = True
    for name in options.rows.split(","):
        count = min(ROWS[name][3], options.seeds or ROWS[name][3])
        runs = [figures_of(options.bin_dir.resolve(), options.out_dir, name, i)
                for i in range(count)]
        text, kept = row_text(name, runs)
        within = within and kept
        print(text, flush=True)
        for run in runs:
            if "failed" in run:
                print("  " + run["failed"], flush=True)
    sys.exit(0 if within else 1)


if __name__ == "__main__":
    main()
