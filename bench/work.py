#!/usr/bin/env python3
"""Works, tools and homing by sight on drawn cells, against their truth.

work.py BIN OUT [--like paper|ordinary|cheap] [--seeds N] [--first SEED] [--starts N] [--lays N]

Each cell is drawn, calibrated as planar-experiment calibrates it, and then: single marks of 4 mm are put anywhere in
the field and found in pairs 60 mm apart, of which each is judged by itself; a work of 150 x 100 mm with four marks is
put anywhere, found, and targets on it are reached; a tip 30 mm off the axis is taught by four directions at a mark
and goes to targets; the arm is homed by sight from drawn poses. Prints a row each: median and 95 % of the error, mm or
deg, and the share of components within the stated 95 %.
With --lays so many views of the board on the plane enter, whose height is known as by a caliper.
"""
import argparse
import csv
import json
import math
import random
import re
import subprocess
from pathlib import Path

import yaml  # python3-yaml

MARKS = [(5, 5), (145, 5), (145, 95), (5, 80)]
TIP = (30.0, -4.0)
COLUMNS = "id,x_mm,y_mm,kind,size_mm,z_mm,sigma_z_mm\n"


def run(*command, check=True):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if check and done.returncode not in (0, 1):
        raise RuntimeError(f"{command}: {done.stderr}")
    return done


def rows(path):
    with open(path) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def turned(p, deg):
    c, s = math.cos(math.radians(deg)), math.sin(math.radians(deg))
    return (p[0] * c - p[1] * s, p[0] * s + p[1] * c)


class Figures:
    def __init__(self):
        self.errors, self.within, self.all = {}, {}, {}

    def add(self, name, error, components=(), sigma=None):
        self.errors.setdefault(name, []).append(error)
        for component in components:
            self.all[name] = self.all.get(name, 0) + 1
            self.within[name] = self.within.get(name, 0) + (abs(component) < 1.96 * sigma)

    def print(self):
        for name, errors in self.errors.items():
            errors = sorted(errors)
            share = f"{100 * self.within[name] / self.all[name]:5.1f} % within" if name in self.all else ""
            print(f"{name:28} n {len(errors):4}  median {errors[len(errors) // 2]:.4f}  95 % "
                  f"{errors[int(0.95 * (len(errors) - 1))]:.4f}  max {errors[-1]:.4f}  {share}", flush=True)


def calibrated(bin, cell, like, seed, lays):
    run(bin / "planar-virtual-cell", "draw", "--seed", seed, "--like", like, "-o", cell)
    laid = []
    if lays:
        lamps_mm = yaml.safe_load((cell / "truth.yaml").read_text())["tool"]["lamp_height_mm"]
        laid = ["--lays", lays, "--board-thickness-mm", f"{-lamps_mm:.1f}"]
    run(bin / "planar-experiment", "-q", "--cell", cell / "cell.yaml", "--out", cell / "made", *laid)
    for path in (cell / "made/ours").glob("*.yaml"):
        (cell / path.name).write_bytes(path.read_bytes())
    for picture in (cell / "made/recording/images").glob("*"):
        picture.unlink()
    with open(cell / "cell.yaml", "a") as text:
        text.write("arm_found: arm.yaml\n")


def put(bin, cell, bare, drawing, at):
    (cell / "truth.yaml").write_text(bare)
    run(bin / "planar-virtual-cell", "put", "--cell", cell / "cell.yaml", "--drawing", drawing, "--at",
        ",".join(f"{v:.4f}" for v in at))


def anywhere(rng, reach):
    r, a = reach * math.sqrt(rng.uniform(0.02, 1.0)), rng.uniform(-math.pi, math.pi)
    return r * math.cos(a), r * math.sin(a), rng.uniform(-180, 180)


def marks_and_works(bin, cell, bare, rng, figures, n):
    pair, work = cell / "pair.csv", cell / "work.csv"
    pair.write_text(COLUMNS + "A,0,0,bright_disc,4,-10,0\nB,60,0,bright_disc,4,-10,0\n")
    work.write_text(COLUMNS + "".join(f"F{i},{x},{y},bright_disc,4,-10,0\n" for i, (x, y) in enumerate(MARKS)))
    found = cell / "work.yaml"
    for _ in range(n):
        at = anywhere(rng, 480)
        put(bin, cell, bare, pair, at)
        if run(bin / "planar-find-work", "--cell", cell / "cell.yaml", "--drawing", pair, "-o", found, "--near",
               ",".join(f"{v:.3f}" for v in at), "--report", "none").returncode == 0:
            for mark in yaml.safe_load(found.read_text())["works"][0]["fiducials"]:
                dx, dy = turned(mark["drawn_mm"], at[2])
                off = (mark["seen_mm"][0] - at[0] - dx, mark["seen_mm"][1] - at[1] - dy)
                figures.add("mark of 4 mm", math.hypot(*off), off, mark["sigma_mm"])
        else:
            figures.add("marks not found", 1.0)
    for i in range(n):
        at = anywhere(rng, 300)
        put(bin, cell, bare, work, at)
        made = run(bin / "planar-find-work", "--cell", cell / "cell.yaml", "--drawing", work, "-o", found,
                   "--drawing-sigma-mm", 0, "--report", "none")
        if made.returncode != 0:
            figures.add("works not found", 1.0)
            print(f"{cell.name}, work at {at}: {made.stderr.strip()}")
            continue
        targets = [(rng.uniform(10, 140), rng.uniform(10, 90)) for _ in range(4)]
        (cell / "t.csv").write_text("id,x_mm,y_mm\n" + "".join(f"T{k},{x},{y}\n" for k, (x, y) in enumerate(targets)))
        out = cell / f"run{i}"
        run(bin / "planar-servo", "-q", "--cell", cell / "cell.yaml", "--work", found, "--targets",
            cell / "t.csv", "--out", out)
        for row in rows(out / "results.csv"):
            if not row["after_truth_dx_mm"]:
                figures.add("targets without an end", 1.0)
                print(f"{cell.name}, target at {row['x_mm']}, {row['y_mm']}: {row['status']}")
                continue
            dx, dy = turned(targets[int(row["target"][1:])], at[2])
            off = (float(row["x_mm"]) + float(row["after_truth_dx_mm"]) - at[0] - dx,
                   float(row["y_mm"]) + float(row["after_truth_dy_mm"]) - at[1] - dy)
            figures.add("target on a work", math.hypot(*off))
            seen = (off[0] - float(row["after_own_view_dx_mm"]), off[1] - float(row["after_own_view_dy_mm"]))
            figures.add("where it is believed", math.hypot(*seen), seen, float(row["uncertainty_mm"]))


def tools(bin, cell, bare, rng, figures, n):
    """The tip is brought to a mark by the truth, to 5 um per axis; the poses are as vision sees them."""
    (cell / "truth.yaml").write_text(bare)
    mark = (rng.uniform(150, 300), rng.uniform(-150, 150))
    places = []
    for k in range(4):
        phi = 90 * k + 10
        tip = turned(TIP, phi)
        places.append((mark[0] - tip[0], mark[1] - tip[1], phi))
    (cell / "p.csv").write_text("id,x_mm,y_mm,phi_deg\n" +
                                "".join(f"T{k},{x},{y},{phi}\n" for k, (x, y, phi) in enumerate(places)))
    out = cell / "taught"
    run(bin / "planar-servo", "-q", "--cell", cell / "cell.yaml", "--targets", cell / "p.csv", "--out", out)
    steps = {row["target"]: row for row in rows(out / "steps.csv")}
    taught = "id,x_mm,y_mm,phi_deg\n"
    for row in rows(out / "results.csv"):
        k, step = int(row["target"][1:]), steps[row["target"]]
        # Where vision would see P with the tip at the mark: what it sees, less where the truth is beside that.
        x = float(step["x_mm"]) - float(row["after_truth_dx_mm"]) + rng.gauss(0, 0.005)
        y = float(step["y_mm"]) - float(row["after_truth_dy_mm"]) + rng.gauss(0, 0.005)
        taught += f"T{k},{x},{y},{step['phi_deg']}\n"
    (cell / "taught.csv").write_text(taught)
    made = run(bin / "planar-teach-tool", "--cell", cell / "cell.yaml", "-o", cell / "needle.yaml", "--poses",
               cell / "taught.csv", "--sigma-mm", 0.008, "--json", cell / "taught.json")
    if made.returncode != 0:
        figures.add("tools not taught", 1.0)
        return
    tip = json.loads((cell / "taught.json").read_text())
    off = [a - b for a, b in zip(tip["p_TE_mm"], TIP)]
    figures.add("tip of a tool", math.hypot(*off))
    text = (cell / "cell.yaml").read_text()
    (cell / "tools.yaml").write_text(text + "tools: {needle: needle.yaml}\n")
    targets = [(rng.uniform(100, 350), rng.uniform(-200, 200), rng.uniform(-170, 170)) for _ in range(n)]
    (cell / "t.csv").write_text("id,x_mm,y_mm,phi_deg\n" +
                                "".join(f"T{k},{x},{y},{phi}\n" for k, (x, y, phi) in enumerate(targets)))
    out = cell / "tooled"
    run(bin / "planar-servo", "-q", "--cell", cell / "tools.yaml", "--tool", "needle", "--targets",
        cell / "t.csv", "--out", out)
    steps = {row["target"]: row for row in rows(out / "steps.csv")}
    for row in rows(out / "results.csv"):
        if not row["after_truth_dx_mm"]:
            figures.add("tool's targets without an end", 1.0)
            continue
        # The judge takes the tip as it was taught; the true one is beside it.
        wrong = turned(off, float(steps[row["target"]]["phi_deg"]))
        miss = (float(row["after_truth_dx_mm"]) - wrong[0], float(row["after_truth_dy_mm"]) - wrong[1])
        figures.add("tip at its target", math.hypot(*miss))
        seen = (miss[0] - float(row["after_own_view_dx_mm"]), miss[1] - float(row["after_own_view_dy_mm"]))
        figures.add("where the tip is believed", math.hypot(*seen), seen, float(row["uncertainty_mm"]))


def homings(bin, cell, bare, rng, figures, starts):
    text = (cell / "cell.yaml").read_text().replace("direction: 1,", "direction: 1, home: {reference: sight},")
    (cell / "sight.yaml").write_text(text)
    (cell / "one.csv").write_text("id,x_mm,y_mm\nA,200,100\n")
    for i in range(starts):
        bend = rng.choice((-1, 1)) * rng.uniform(25, 150)
        one = rng.uniform(-170, 170)
        home = (one, one + bend, rng.uniform(-170, 170))
        truth = re.sub(r"^  home_deg: .*\n", "", bare, flags=re.M)
        (cell / "truth.yaml").write_text(truth.replace("arm:\n", f"arm:\n  home_deg: {list(home)}\n", 1))
        out = cell / f"home{i}"
        done = run(bin / "planar-servo", "--no-health", "--cell", cell / "sight.yaml", "--targets", cell / "one.csv",
                   "--home", "--nearest-turn", "--out", out)
        said = re.search(r"homed by sight: joints (\S+) (\S+) (\S+) deg", done.stderr)
        if not said:
            figures.add("not homed, refused", 1.0)
            continue
        # The turns of motor 2 and of joint 3 that told elbows and lamps apart, from what the log says.
        turns = [float(t) for t in re.findall(r"motor 2 turns by (\S+) deg", done.stderr)]
        three = [float(t) for t in re.findall(r"motor 3 turns by (\S+) deg", done.stderr)]
        stands = [home[0], home[1] + sum(turns), home[2] + sum(turns) + sum(three)]
        off = [abs((float(a) - b + 180) % 360 - 180) for a, b in zip(said.groups(), stands)]
        figures.add("joint homed by sight, deg", max(off))
        if "elbow is on the side" not in done.stderr:
            figures.add("by the calibrated elbow", max(off))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--like", default="paper")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=901)
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--lays", type=int, default=0)
    options = parser.parse_args()
    figures = Figures()
    for seed in range(options.first, options.first + options.seeds):
        cell, rng = options.out / f"{options.like}{seed}", random.Random(seed)
        calibrated(options.bin, cell, options.like, seed, options.lays)
        bare = (cell / "truth.yaml").read_text()
        marks_and_works(options.bin, cell, bare, rng, figures, 4)
        tools(options.bin, cell, bare, rng, figures, 6)
        homings(options.bin, cell, bare, rng, figures, options.starts)
        print(f"after {options.like} {seed}")
        figures.print()


if __name__ == "__main__":
    main()
