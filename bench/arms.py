#!/usr/bin/env python3
"""Runs the experiment on drawn cells of every kind of arm and compares the medians with their bounds.

    bench/arms.py BIN_DIR OUT_DIR [--kinds KIND,...] [--first SEED] [--cells N] [--train READINGS] [--unattended POSES]

Prints a row for each cell, then for each kind the median of the mean true errors at 100 targets, of vision and of
positioning, how many targets were reached, the corrections, the share of the components within their stated 95 %, and
how many predictions lie within a quarter of what was found. Ends with status 1 when a bound is missed. A cell whose
figures OUT_DIR holds already is not run again.
"""

import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import sys

# mm: vision, positioning; share of targets reached; mean corrections
BOUNDS = {
    "paper": (0.0030, 0.0029, 1.0, 0.0),
    "rough": (0.0060, 0.0060, 1.0, 1.0),
    "ordinary": (0.0080, 0.013, 0.98, 4.0),
    "cheap": (0.0120, 0.024, 0.99, 3.0),
}
# the same with 12 readings and 1,000 unattended poses
BOUNDS_UNATTENDED = {**BOUNDS, "ordinary": (0.012, 0.016, 0.98, 4.0)}


def corrections(run):
    """Returns the mean number of corrections of a run's results.csv."""
    with open(run / "results.csv", newline="") as table:
        rows = csv.DictReader(line for line in table if not line.startswith("#"))
        return statistics.mean(int(row["iterations"]) for row in rows)


def run_cell(programs, folder, kind, seed, options):
    """Returns the figures of one cell, or the reason why there are none."""
    figures = folder / "figures.json"
    if not figures.exists():
        subprocess.run([programs / "planar-virtual-cell", "draw", "--seed", str(seed), "--like", kind, "-o", folder / "cell"],
                       check=True, stdout=subprocess.DEVNULL)
        made = subprocess.run([programs / "planar-experiment", "-q", "--cell", folder / "cell" / "cell.yaml",
                               "--out", folder / "run", "--json", figures, *options], capture_output=True, text=True)
        if made.returncode == 2 or not figures.exists():
            return made.stderr.strip() or made.stdout.strip()
        for picture in (folder / "run" / "recording" / "images").glob("*"):
            picture.unlink()
    found = json.loads(figures.read_text())
    found["corrections"] = corrections(folder / "run" / "ours" / "run")
    return found


def row_of(found):
    before, after = found["before_mean_mm_truth"], found["after_mean_mm_truth"]
    return (f"{found['vision_after_mean_mm']:8.4f} {before:9.4f} {after:9.4f} {found['predicted_mean_mm']:9.4f} "
            f"{100 * found['coverage_95_truth']:7.1f} {found['reached']:5d} of {found['targets']} {found['corrections']:6.2f}")


def summary(kind, cells, bound):
    """Prints the medians of a kind and returns whether its bounds are kept."""
    def middle(key):
        return statistics.median(found[key] for found in cells)
    vision, after = middle("vision_after_mean_mm"), middle("after_mean_mm_truth")
    reached = sum(found["reached"] for found in cells) / sum(found["targets"] for found in cells)
    made = statistics.mean(found["corrections"] for found in cells)
    within = statistics.mean(found["coverage_95_truth"] for found in cells)
    least = min(found["coverage_95_truth"] for found in cells)
    near = sum(abs(found["predicted_mean_mm"] / found["after_mean_mm_truth"] - 1) <= 0.25 for found in cells)
    worse = sum(found["after_mean_mm_truth"] > 1.05 * found["before_mean_mm_truth"] for found in cells)
    print(f"{kind:9} median: vision {vision:.4f} ({bound[0]:.4f}), positioning {after:.4f} ({bound[1]:.4f}) mm; reached "
          f"{100 * reached:.1f} % ({100 * bound[2]:.0f}); {made:.2f} corrections ({bound[3]:g}); {100 * within:.1f} % within "
          f"95 %, least {100 * least:.1f}; predicted within a quarter on {near} of {len(cells)}; worse than the arm alone "
          f"by 5 % on {worse}")
    return vision <= bound[0] and after <= bound[1] and reached >= bound[2] and made <= bound[3]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--kinds", default=",".join(BOUNDS))
    parser.add_argument("--first", type=int, default=201)
    parser.add_argument("--cells", type=int, default=10)
    parser.add_argument("--train", type=int)
    parser.add_argument("--unattended", type=int)
    options = parser.parse_args()
    more = [f"--{name}={value}" for name, value in (("train", options.train), ("unattended", options.unattended)) if value]
    bounds = BOUNDS_UNATTENDED if options.unattended else BOUNDS
    kept = True
    print("kind seed   vision  arm alone   with it predicted  within 95 %  reached  corrections")
    for kind in options.kinds.split(","):
        cells = []
        for seed in range(options.first, options.first + options.cells):
            found = run_cell(options.programs, options.out / f"{kind}{seed}", kind, seed, more)
            if isinstance(found, str):
                print(f"{kind:9}{seed:5} {found}", flush=True)
                kept = False
                continue
            cells.append(found)
            print(f"{kind:9}{seed:5} {row_of(found)}", flush=True)
        kept = bool(cells) and summary(kind, cells, bounds[kind]) and kept
    sys.exit(0 if kept else 1)


if __name__ == "__main__":
    main()
