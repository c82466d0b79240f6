#!/usr/bin/env python3
"""Prints how far first landings miss over a shift on a drawn cell, against the truth, with and without learning the
arm from looks, by fifty targets; OUT_DIR/shift.svg draws them by a hundred. Ends with status 1 unless learning makes
the last quarter of them better.

    bench/shift.py BIN_DIR OUT_DIR [--like KIND] [--seed N] [--train N] [--targets N] [--calibrated DIR]

1200 targets take an hour of the cell's time. The cell is calibrated by planar-experiment, unless DIR, that of
such a run before, holds its files already."""

import argparse
import csv
import math
import pathlib
import random
import shutil
import subprocess
import sys

ROWS = 50
REACH_MM = (120.0, 480.0)
PARTS = {"learning": "true", "unlearned": "false"}
COLOURS = {"learning": "#1f77b4", "unlearned": "#d62728"}


def run(program, *arguments):
    # A target that is not reached ends planar-servo with 1; it has its row like the others.
    status = subprocess.run([program, "-q", *map(str, arguments)], stdout=subprocess.DEVNULL).returncode
    if status not in (0, 1):
        sys.exit(f"{program} ended with {status}")


def calibrate(options, cell):
    drawn, experiment = options.out_dir / "drawn", options.out_dir / "experiment"
    for folder in (drawn, experiment, cell):
        shutil.rmtree(folder, ignore_errors=True)
    run(options.bin_dir / "planar-virtual-cell", "draw", "--seed", options.seed, "--like", options.like, "-o", drawn)
    train = ["--train", options.train] if options.train is not None else []
    run(options.bin_dir / "planar-experiment", "--cell", drawn / "cell.yaml", "--out", experiment,
        "--loop-only", 2, *train)
    cell.mkdir()
    for file in [*(experiment / "ours").glob("*.yaml"), drawn / "truth.yaml", drawn / "cell.yaml"]:
        shutil.copy(file, cell)


def write_cells(cell):
    """Writes the cell once for each part, beside its calibration."""
    text = (cell / "cell.yaml").read_text()
    if "arm_found:" not in text:
        text += "arm_found: arm.yaml\n"
    for part, learns in PARTS.items():
        (cell / f"{part}.yaml").write_text(text.replace("servo: {", f"servo: {{learn: {learns}, "))


def write_targets(path, options):
    chance = random.Random(options.seed)
    with path.open("w") as table:
        table.write("id,x_mm,y_mm\n")
        for i in range(options.targets):
            radius = math.sqrt(chance.uniform(REACH_MM[0] ** 2, REACH_MM[1] ** 2))
            turn = chance.uniform(-math.pi, math.pi)
            table.write(f"t{i + 1},{radius * math.cos(turn):.4f},{radius * math.sin(turn):.4f}\n")


def first_misses_mm(folder):
    lines = [line for line in (folder / "results.csv").read_text().splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    return ([float(row["before_truth_mm"] or "nan") for row in rows],
            sum(int(row["iterations"]) for row in rows) / len(rows),
            sum(row["status"] != "reached" for row in rows))


def mean(values):
    known = [value for value in values if not math.isnan(value)]
    return sum(known) / len(known) if known else math.nan


def means(values, count):
    return [mean(values[i:i + count]) for i in range(0, len(values), count)]


def svg(misses):
    width, height, edge, by = 640, 320, 48, 100
    series = {part: means(values, by) for part, values in misses.items()}
    top = 1.1 * max(max(values) for values in series.values())
    steps = max(2, max(len(values) for values in series.values()))
    x = lambda i: edge + i * (width - 2 * edge) / (steps - 1)
    y = lambda value: height - edge - value / top * (height - 2 * edge)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
             f'font-size="12"><rect width="100%" height="100%" fill="white"/>']
    for i in range(5):
        value = top * i / 4
        parts.append(f'<line x1="{edge}" x2="{width - edge}" y1="{y(value):.1f}" y2="{y(value):.1f}" stroke="#ddd"/>'
                     f'<text x="{edge - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{value:.3f}</text>')
    for n, (part, values) in enumerate(series.items()):
        points = " ".join(f"{x(i):.1f},{y(value):.1f}" for i, value in enumerate(values))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{COLOURS[part]}" stroke-width="2"/>'
                     f'<text x="{width - edge}" y="{20 + 16 * n}" text-anchor="end" fill="{COLOURS[part]}">{part}</text>')
    parts.append(f'<text x="{edge}" y="20">mean miss of first landings, mm</text>'
                 f'<text x="{width / 2}" y="{height - 12}" text-anchor="middle">targets 1 to '
                 f'{max(len(values) for values in misses.values())}</text></svg>\n')
    return "".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("out_dir", type=pathlib.Path)
    parser.add_argument("--like", default="cheap")
    parser.add_argument("--seed", type=int, default=4)
    parser.add_argument("--train", type=int)
    parser.add_argument("--targets", type=int, default=1200)
    parser.add_argument("--calibrated", type=pathlib.Path)
    options = parser.parse_args()
    options.bin_dir, options.out_dir = options.bin_dir.resolve(), options.out_dir.resolve()
    options.out_dir.mkdir(parents=True, exist_ok=True)
    cell = options.calibrated.resolve() if options.calibrated else options.out_dir / "cell"
    if not options.calibrated:
        calibrate(options, cell)
    write_cells(cell)
    targets = options.out_dir / "targets.csv"
    write_targets(targets, options)
    misses, words = {}, []
    for part in PARTS:
        folder = options.out_dir / part
        shutil.rmtree(folder, ignore_errors=True)
        run(options.bin_dir / "planar-servo", "--cell", cell / f"{part}.yaml", "--targets", targets, "--out", folder,
            "--keep-going")
        misses[part], corrections, missed = first_misses_mm(folder)
        words.append(f"{part}: {mean(misses[part]):.4f} mm on average, {corrections:.2f} corrections, "
                     f"{missed} of {len(misses[part])} targets not reached")
    print("targets        unlearned  learning    (mean miss of first landings, mm)")
    for i, (off, on) in enumerate(zip(means(misses["unlearned"], ROWS), means(misses["learning"], ROWS))):
        print(f"{ROWS * i + 1:5d} - {ROWS * (i + 1):5d}   {off:8.4f}  {on:8.4f}")
    print("\n".join(words))
    (options.out_dir / "shift.svg").write_text(svg(misses))
    last = 3 * len(misses["learning"]) // 4
    return 0 if mean(misses["learning"][last:]) < mean(misses["unlearned"][last:]) else 1


if __name__ == "__main__":
    sys.exit(main())
