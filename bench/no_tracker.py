#!/usr/bin/env python3
"""Cells calibrated without a tracker, by lays of a board, a bar and marks of the base, against their truth.

no_tracker.py BIN OUT [--like paper,ordinary] [--first SEED] [--seeds N] [--poses N] [--lays N] [--print PERCENT]
              [--without bar,marks]

Draws cells, records N poses and lays of a board that is printed larger than its pitch says, takes pictures of a bar of
500 mm in eight places with four marks of the base (both known to 0.005 mm, and drawn so), learns the map with them, and
moves to 25 places. Prints the true mean error of each cell, its part that a common shift, turn and scale explain, and what
share of components of what is believed lies within the stated 95 %.
"""
import argparse
import csv
import json
import math
import random
import re
import shutil
import statistics
import subprocess
from pathlib import Path

MARKS = ((350, 300), (-350, 300), (-330, -320), (330, -320))
PLACES = ((0, 0, 0), (-100, 180, 25), (120, -170, 50), (0, 0, 70), (170, 90, 95), (-170, -60, 115), (0, 0, 140), (90, 180, 160))


class Cell:
    def __init__(self, bin, folder):
        self.bin, self.folder = bin, folder

    def run(self, program, *words, accept=(0,)):
        done = subprocess.run([self.bin / program, *map(str, words)], cwd=self.folder, capture_output=True, text=True)
        if done.returncode not in accept:
            raise SystemExit(f"{program}: {done.stderr[-2000:]}")
        return done.stdout


def put(cell, drawing, at):
    cell.run("planar-virtual-cell", "put", "--cell", "cell.yaml", "--drawing", drawing, "--at", at)


def take_bar(cell, rng):
    """Pictures of the bar and the base's marks, each with the bar elsewhere."""
    true_length = 500 + rng.gauss(0, 0.005)
    ends = "id,x_mm,y_mm,kind,size_mm\nA,0,0,bright_disc,5\nB,{},0,bright_disc,5\n"
    (cell.folder / "bar.csv").write_text(ends.format(500))
    (cell.folder / "true_bar.csv").write_text(ends.format(f"{true_length:.5f}"))
    for name, sigma in (("marks.csv", 0.0), ("true_marks.csv", 0.005)):
        (cell.folder / name).write_text("id,x_mm,y_mm,kind,size_mm\n" + "".join(
            f"M{i},{x + rng.gauss(0, sigma):.4f},{y + rng.gauss(0, sigma):.4f},bright_disc,6\n"
            for i, (x, y) in enumerate(MARKS)))
    truth = (cell.folder / "truth.yaml").read_bytes()
    for i, (x, y, turn) in enumerate(PLACES):
        (cell.folder / "truth.yaml").write_bytes(truth)
        put(cell, "true_marks.csv", "0,0,0")
        back = 250 * math.cos(math.radians(turn)), 250 * math.sin(math.radians(turn))
        put(cell, "true_bar.csv", f"{x - back[0]:.3f},{y - back[1]:.3f},{turn}")
        cell.run("planar-record", "-q", "--cell", "cell.yaml", "--bar", "bar.csv", "--bar-places", i + 1, "--out", "bar")
    (cell.folder / "truth.yaml").write_bytes(truth)


def calibrate(cell, options, rng):
    # Each program begins at the cell's time 0, so that the camera would jump back by what it drifted in a recording.
    truth = cell.folder / "truth.yaml"
    truth.write_text(re.sub(r"px_per_h: .*", "px_per_h: [0, 0]", truth.read_text()))
    text = (cell.folder / "cell.yaml").read_text()
    datum = text.index("datum:")
    end = text.index("workspace:", datum)
    (cell.folder / "cell.yaml").write_text(text[:datum] + "datum: []\n" + text[end:])
    pitch = 50 * (1 + options.print / 100)
    cell.run("planar-plan", "--cell", "cell.yaml", "--readings", 0, "--unattended", options.poses, "--lays", options.lays,
             "-o", "plan.csv")
    cell.run("planar-record", "-q", "--cell", "cell.yaml", "--plan", "plan.csv", "--out", "recording")
    cell.run("planar-calibrate-camera", "--grid", f"circles:11x11:{pitch:.4f}mm", "--model", "auto", "--report", "none",
             "-o", "camera.yaml", "recording")
    cell.run("planar-locate-lamps", "--cell", "cell.yaml", "--report", "none", "-o", "lamps.csv", "recording")
    cell.run("planar-pair-tracker", "--cell", "cell.yaml", "--lamps", "lamps.csv", "--recording", "recording",
             "--workplane-from", "grid", "--grid", f"circles:11x11:{pitch:.4f}mm", "--lays-out", "lays.csv",
             "--workplane-out", "workplane.yaml", "--tool-out", "tool.yaml", "-o", "pairs.csv", "--report", "none")
    take_bar(cell, rng)
    images = sorted((cell.folder / "bar").glob("bar_*.png"))
    extra = []
    for source in ("bar", "marks"):
        if source not in options.without:
            extra += [f"--{source}", f"{source}.csv", f"--{source}-sigma-mm", "0.005"]
    cell.run("planar-fit-error-map", "--cell", "cell.yaml", "--lays", "lays.csv", *extra,
             *(["--image", *images] if extra else []), "-o", "map.yaml", "--report", "none", "--json", "fit.json",
             "pairs.csv")


def errors_of(cell, rng):
    targets = []
    while len(targets) < 25:
        x, y = rng.uniform(-420, 420), rng.uniform(-420, 420)
        if 150 < math.hypot(x, y) < 420:
            targets.append((x, y))
    (cell.folder / "targets.csv").write_text("id,x_mm,y_mm\n" + "".join(
        f"T{i},{x:.3f},{y:.3f}\n" for i, (x, y) in enumerate(targets)))
    cell.run("planar-servo", "-q", "--cell", "cell.yaml", "--targets", "targets.csv", "--out", "run", "--no-health",
             accept=(0, 1))
    rows = [row for row in csv.DictReader(line for line in open(cell.folder / "run/results.csv") if line[0] != "#")
            if row["status"] == "reached"]
    number = lambda row, key: float(row[key])
    off = [(number(r, "x_mm"), number(r, "y_mm"), number(r, "after_truth_dx_mm"), number(r, "after_truth_dy_mm"))
           for r in rows]
    within = statistics.mean(abs(number(row, f"believed_{axis}_mm")) < 1.96 * number(row, "uncertainty_mm")
                             for row in rows for axis in ("dx", "dy"))  # what is believed less the truth
    return off, within


def in_common(off):
    """Mean length of what a shift, a turn and a scale leave (least squares about the middle)."""
    n = len(off)
    mx, my = sum(o[0] for o in off) / n, sum(o[1] for o in off) / n
    sx, sy = sum(o[2] for o in off) / n, sum(o[3] for o in off) / n
    square = sum((o[0] - mx) ** 2 + (o[1] - my) ** 2 for o in off)
    scale = sum((o[0] - mx) * (o[2] - sx) + (o[1] - my) * (o[3] - sy) for o in off) / square
    turn = sum((o[0] - mx) * (o[3] - sy) - (o[1] - my) * (o[2] - sx) for o in off) / square
    left = [math.hypot(o[2] - sx - scale * (o[0] - mx) + turn * (o[1] - my),
                       o[3] - sy - scale * (o[1] - my) - turn * (o[0] - mx)) for o in off]
    return statistics.mean(left), 1e6 * scale, math.degrees(turn), math.hypot(sx, sy)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--like", default="paper,ordinary")
    parser.add_argument("--first", type=int, default=7101)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--lays", type=int, default=12)
    parser.add_argument("--print", type=float, default=0.1)
    parser.add_argument("--without", default="")
    options = parser.parse_args()
    for like in options.like.split(","):
        means, shares = [], []
        for seed in range(options.first, options.first + options.seeds):
            folder = (options.out / f"{like}{seed}").resolve()
            shutil.rmtree(folder, ignore_errors=True)
            cell = Cell(options.bin.resolve(), folder.parent)
            folder.parent.mkdir(parents=True, exist_ok=True)
            cell.run("planar-virtual-cell", "draw", "--seed", seed, "--like", like, "-o", folder)
            cell.folder = folder
            rng = random.Random(seed)
            calibrate(cell, options, rng)
            shutil.rmtree(folder / "recording/images")  # 1.5 GB
            off, within = errors_of(cell, rng)
            mean = statistics.mean(math.hypot(o[2], o[3]) for o in off)
            left, scale, turn, shift = in_common(off)
            fit = json.load(open(folder / "fit.json"))
            print(f"{like} {seed}: {len(off)} reached, true error mean {mean:.4f} mm, of it {left:.4f} not common (scale "
                  f"{scale:+.1f} ppm, turn {turn:+.5f} deg, shift {shift:.4f} mm); {100 * within:.0f} % within stated; "
                  f"fixed by {fit.get('fixed_by')}", flush=True)
            means.append(mean)
            shares.append(within)
        print(f"{like}: median of {len(means)} cells {statistics.median(means):.4f} mm, "
              f"{100 * statistics.mean(shares):.0f} % within the stated 95 %", flush=True)


if __name__ == "__main__":
    main()
