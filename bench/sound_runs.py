#!/usr/bin/env python3
"""Runs planar-servo on calibrated cells that nothing happened to, and counts the runs that were stopped.

    bench/sound_runs.py BIN_DIR OUT_DIR --calibrated DIR [--kinds KIND,...] [--runs N] [--targets N]

DIR is the folder in which bench/arms.py left its cells. Every run has other targets and other noise; a cell's runs
follow each other, so that the arm learned in one serves the next. A run is stopped when it ends before its last target,
or doubts what it reached. Prints a row for each cell. Ends with status 1 when a run was stopped.
"""

import argparse
import csv
import math
import pathlib
import random
import re
import shutil
import subprocess
import sys

REACH_MM = (120.0, 480.0)


def calibrated_copy(made, folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for file in [*(made / "run" / "ours").glob("*.yaml"), made / "cell" / "truth.yaml", made / "cell" / "cell.yaml"]:
        shutil.copy(file, folder)
    cell = folder / "cell.yaml"
    if "arm_found:" not in cell.read_text():
        cell.write_text(cell.read_text() + "arm_found: arm.yaml\n")


def write_targets(path, count, chance):
    with path.open("w") as table:
        table.write("id,x_mm,y_mm\n")
        for i in range(count):
            radius = math.sqrt(chance.uniform(REACH_MM[0] ** 2, REACH_MM[1] ** 2))
            turn = chance.uniform(-math.pi, math.pi)
            table.write(f"t{i + 1},{radius * math.cos(turn):.4f},{radius * math.sin(turn):.4f}\n")


def servo(programs, folder, number, count):
    """Returns the rows of one run's results, and what the program said."""
    truth = folder / "truth.yaml"
    truth.write_text(re.sub(r"(?m)^seed: .*$", f"seed: {1000 + number}", truth.read_text()))
    write_targets(folder / "targets.csv", count, random.Random(number))
    out = folder / f"run{number}"
    made = subprocess.run([programs / "planar-servo", "-q", "--cell", folder / "cell.yaml", "--targets",
                           folder / "targets.csv", "--out", out], capture_output=True, text=True)
    lines = (out / "results.csv").read_text().splitlines() if (out / "results.csv").exists() else []
    return list(csv.DictReader(line for line in lines if not line.startswith("#"))), made.stderr.strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("out_dir", type=pathlib.Path)
    parser.add_argument("--calibrated", type=pathlib.Path, required=True)
    parser.add_argument("--kinds", default="paper,rough,ordinary,cheap")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--targets", type=int, default=20)
    options = parser.parse_args()
    stopped_of_all = 0
    for kind in options.kinds.split(","):
        for made in sorted(options.calibrated.glob(f"{kind}[0-9]*")):
            folder = options.out_dir / made.name
            calibrated_copy(made, folder)
            stopped = reached = 0
            for number in range(options.runs):
                rows, said = servo(options.bin_dir.resolve(), folder, number, options.targets)
                reached += sum(row["status"] == "reached" for row in rows)
                if len(rows) < options.targets or any(row["status"] == "doubted" for row in rows):
                    stopped += 1
                    print(f"{made.name} run {number} stopped after {len(rows)} targets: {said}", flush=True)
            print(f"{made.name}: {stopped} of {options.runs} runs stopped, {reached} of "
                  f"{options.runs * options.targets} targets reached", flush=True)
            stopped_of_all += stopped
    print(f"{stopped_of_all} runs stopped (bound none)")
    sys.exit(1 if stopped_of_all else 0)


if __name__ == "__main__":
    main()
