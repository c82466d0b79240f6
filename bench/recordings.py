#!/usr/bin/env python3
"""Asks planar-pair-tracker about sound recordings of drawn cells, and about recordings in whose midst the reflector was
bumped.

    bench/recordings.py BIN_DIR OUT_DIR [--recordings N] [--kinds KIND,...] [--places N] [--first SEED]
        [--sound-only]

Every cell is drawn, its camera calibrated, and its training places are recorded in orders of many kinds: on a spiral
from within (also with even steps of the radius, along its line, from without), ring after ring, row after row, sector
after sector, and as planar-plan orders them. Kinds that planar-virtual-cell does not know are
left out. Every recording is paired as it is, and with the readings shifted from some place on.
Prints how many of them were refused and doubted, and of the shifted ones how many were named within three places.
Ends with status 1 if a sound recording is refused. A recording that OUT_DIR holds already is not made again.
"""

import argparse
import collections
import csv
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys

KINDS = "paper,rough,ordinary,cheap"
SHIFTS_MM = (0.06, 0.1, 0.36)
SHARES = (0.5, 0.06, 0.94)  # of the places before the shift
NEAR_PLACES = 3
SWEEP = 12


def spiral(places):
    for i in range(places):
        radius = math.sqrt(80**2 + (520**2 - 80**2) * (i + 0.5) / places)
        yield radius, 2.4 * i


def rings(places):
    count = max(2, round(math.sqrt(places / 3)))
    radii = [80 + 440 * (i + 0.5) / count for i in range(count)]
    sizes = [max(1, round(places * radius / sum(radii))) for radius in radii]
    for radius, size in zip(radii, sizes):
        for i in range(size):
            yield radius, 2 * math.pi * i / size


def even_radius(places):
    for i in range(places):
        yield 80 + 440 * (i + 0.5) / places, 2.4 * i


def winding(places):
    for i in range(places):
        along = math.sqrt((i + 0.5) / places)
        yield 80 + 440 * along, 12 * math.pi * along


def inward(places):
    return reversed(list(spiral(places)))


def rows(places):
    count = math.ceil(math.sqrt(places * 4 / math.pi))
    steps = [-520 + 1040 * (i + 0.5) / count for i in range(count)]
    for i, y in enumerate(steps):
        for x in steps[::-1] if i % 2 else steps:
            if 80 < math.hypot(x, y) < 520:
                yield math.hypot(x, y), math.atan2(y, x)


def sectors(places, count=8):
    for i in range(places):
        j = i // (places // count + 1)
        share = (i * 0.618034) % 1
        yield math.sqrt(80**2 + (520**2 - 80**2) * share), 2 * math.pi * (j + (i * 0.754878) % 1) / count


ORDERS = {"spiral": spiral, "rings": rings, "planar-plan": None, "even radius": even_radius, "winding": winding,
          "inward": inward, "rows": rows, "sectors": sectors}


def plan_of(order, places):
    rows = [f"turn_{i:02d},sweep3,0,300,{360 / SWEEP * i - 180:g}" for i in range(SWEEP)]
    for i, (radius, angle) in enumerate(order(places)):
        rows.append(f"train_{i:03d},train,{radius * math.cos(angle):.3f},{radius * math.sin(angle):.3f},0")
    return "\n".join(["id,plan,x_mm,y_mm,phi_deg"] + rows) + "\n"


class Cell:
    def __init__(self, programs, folder, kind, seed):
        self.programs, self.folder = programs, folder
        if (folder / "camera.yaml").exists():
            return
        shutil.rmtree(folder, ignore_errors=True)
        folder.parent.mkdir(parents=True, exist_ok=True)
        self.must("planar-virtual-cell", "draw", "--seed", seed, "--like", kind, "-o", folder, at=folder.parent)
        rows = [f"board_{i:02d},grid,,," for i in range(10)]
        (folder / "board.csv").write_text("\n".join(["id,plan,x_mm,y_mm,phi_deg"] + rows) + "\n")
        self.must("planar-record", "--cell", "cell.yaml", "--plan", "board.csv", "--out", "board")
        self.must("planar-calibrate-camera", "--grid", "circles:11x11:50mm", "-o", "camera.yaml", "board")
        shutil.rmtree(folder / "board")

    def run(self, program, *arguments, at=None):
        done = subprocess.run([self.programs / program, "-q", *map(str, arguments)], cwd=at or self.folder,
                              capture_output=True, text=True)
        return done.returncode, done.stderr

    def must(self, program, *arguments, at=None):
        status, said = self.run(program, *arguments, at=at)
        if status != 0:
            raise SystemExit(f"{self.folder}: {program}: {said}")

    def record(self, order, places):
        """Records the places in this order, keeps the tables and leaves the images out."""
        recording = self.folder / order
        if (recording / "lamps.csv").exists():
            return
        shutil.rmtree(recording, ignore_errors=True)
        plan = self.folder / f"{order}.csv"
        if order == "planar-plan":
            (self.folder / "all.csv").unlink(missing_ok=True)
            self.must("planar-plan", "--cell", "cell.yaml", "--readings", places + SWEEP, "-o", "all.csv")
            lines = (self.folder / "all.csv").read_text().splitlines()
            plan.write_text("\n".join(line for line in lines if "grid" not in line) + "\n")
        else:
            plan.write_text(plan_of(ORDERS[order], places))
        self.must("planar-record", "--cell", "cell.yaml", "--plan", plan.name, "--out", order)
        self.must("planar-locate-lamps", "--cell", "cell.yaml", "-o", f"{order}/lamps.csv", order)
        shutil.rmtree(recording / "images")

    def pair(self, order, tracker=None):
        """Returns the exit status, and the messages."""
        tables = ["--tracker", tracker] if tracker else []
        done = subprocess.run(
            [self.programs / "planar-pair-tracker", "--cell", "cell.yaml", "--lamps", f"{order}/lamps.csv",
             "--recording", order, *tables, "--workplane-out", f"{order}_plane.yaml", "--tool-out",
             f"{order}_tool.yaml", "-o", f"{order}_pairs.csv"], cwd=self.folder, capture_output=True, text=True)
        return done.returncode, done.stderr

    def shifted(self, order, first, shift_mm):
        """Writes the readings with those of the training places from `first` on shifted, and returns the table."""
        lines = (self.folder / order / "tracker.csv").read_text().splitlines()
        remarks = [line for line in lines if line.startswith("#")]
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        training = list(dict.fromkeys(row["id"] for row in rows if row["id"].startswith("train")))
        late = set(training[first:])
        for row in rows:
            if row["id"] in late:
                row["x_mm"] = repr(float(row["x_mm"]) + shift_mm)
        with open(self.folder / "shifted.csv", "w", newline="") as table:
            table.write("".join(line + "\n" for line in remarks))
            writer = csv.DictWriter(table, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        return "shifted.csv"

    def training_places(self, order):
        rows = csv.DictReader(line for line in open(self.folder / order / "frames.csv") if not line.startswith("#"))
        return list(dict.fromkeys(row["id"] for row in rows if row["plan"] == "train"))


def step_named(said):
    """Returns the place from which a message says that all differs."""
    found = re.search(r"from place '([^']*)' on", said)
    return found and found.group(1)


def known_kinds(programs, kinds):
    said = subprocess.run([programs / "planar-virtual-cell", "draw", "--help"], capture_output=True, text=True).stdout
    known = [kind for kind in kinds.split(",") if kind in said]
    for kind in set(kinds.split(",")) - set(known):
        print(f"{kind}: planar-virtual-cell does not draw such cells; left out")
    return known


def ask(cell, kind, order, shifts_mm, table):
    """Pairs one recording as it is and shifted, and counts the answers."""
    counts = table[kind, order]
    status, said = cell.pair(order)
    named = step_named(said)
    counts["sound"] += 1
    counts["refused"] += status != 0
    doubted = named is not None or "drifted apart" in said
    counts["doubted"] += status == 0 and doubted
    if status != 0 or doubted:
        print(f"{cell.folder.name}, {order}, sound: exit {status}: {said.strip()}", flush=True)
    places = cell.training_places(order)
    for shift_mm in shifts_mm:
        for share in SHARES:
            first = round(share * len(places))
            _, said = cell.pair(order, cell.shifted(order, first, shift_mm))
            named = step_named(said)
            found = named in places and abs(places.index(named) - first) <= NEAR_PLACES
            counts[f"{shift_mm} at {share}"] += found


def print_table(table, shifts_mm):
    shifts = [f"{shift} at {share}" for shift in shifts_mm for share in SHARES]
    print("| kind | order | sound | refused | doubted | " +
          " | ".join(f"{shift} mm from {100 * share:.0f} %" for shift in shifts_mm for share in SHARES) + " |")
    print("|---" * (5 + len(shifts)) + "|")
    for (kind, order), counts in table.items():
        cells = [counts["sound"], counts["refused"], counts["doubted"], *(counts[shift] for shift in shifts)]
        print(f"| {kind} | {order} | " + " | ".join(map(str, cells)) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("out_dir", type=pathlib.Path)
    parser.add_argument("--recordings", type=int, default=200, help="in all, one in each order to a cell")
    parser.add_argument("--kinds", default=KINDS, help="of cells, as planar-virtual-cell draw --like knows them")
    parser.add_argument("--places", type=int, default=120, help="training places of a recording")
    parser.add_argument("--first", type=int, default=1, help="seed of the first cell of each kind")
    parser.add_argument("--sound-only", action="store_true", help="shift no readings")
    options = parser.parse_args()
    shifts_mm = () if options.sound_only else SHIFTS_MM
    programs = options.bin_dir.resolve()
    kinds = known_kinds(programs, options.kinds)
    table = collections.defaultdict(collections.Counter)
    for i in range(options.recordings):
        cell_number, order = i // len(ORDERS), list(ORDERS)[i % len(ORDERS)]
        kind = kinds[cell_number % len(kinds)]
        seed = options.first + cell_number // len(kinds)
        cell = Cell(programs, options.out_dir.resolve() / f"{kind}{seed}", kind, seed)
        cell.record(order, options.places)
        ask(cell, kind, order, shifts_mm, table)
    print_table(table, shifts_mm)
    refused = sum(counts["refused"] for counts in table.values())
    (options.out_dir / "recordings.json").write_text(
        json.dumps({f"{kind}, {order}": counts for (kind, order), counts in table.items()}, indent=2) + "\n")
    print(f"{options.recordings} sound recordings: {refused} refused (bound none)")
    return 0 if refused == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
