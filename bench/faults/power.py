#!/usr/bin/env python3
"""Takes the power away at random moments: of what a program wrote only what it had synced remains.

    bench/faults/power.py BUILD/bin OUT [--losses 200] [--seed 1]

planar-servo loses its power and is resumed until it is done, over and over; planar-fit-error-map loses
it while it writes. After each loss every row that was there before is still there, no more than the row
that was just being written is missing, a file that is written at once is whole, and the run goes on. A
small library that is loaded before the C library's (synced_disk.c) keeps what was synced."""

import argparse
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

from cell_folder import make_cell
from kills import TARGETS, kill_once, rows_of, undated, write_targets


class Disk:
    """What a disk holds of one folder for sure."""

    def __init__(self, out):
        self.synced = (out / "synced").resolve()
        self.library = (out / "synced_disk.so").resolve()
        source = Path(__file__).with_name("synced_disk.c")
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", self.library, source], check=True)

    def environment(self, folder):
        """Begins anew: all that the folder holds now is synced."""
        shutil.rmtree(self.synced, ignore_errors=True)
        self.synced.mkdir(parents=True)
        files = [path for path in folder.iterdir() if path.is_file()] if folder.exists() else []
        for path in files:
            shutil.copy(path, self.synced / str(path.stat().st_ino))
        if folder.exists():
            self.names(folder).write_text("".join(f"{path.stat().st_ino} {path.name}\n" for path in files))
        return {**os.environ, "LD_PRELOAD": str(self.library), "SYNCED_DISK": str(self.synced)}

    def names(self, folder):
        return self.synced / f"names.{folder.stat().st_ino}"

    def lose_power(self, folder):
        """Leaves in the folder what was synced of it."""
        if not folder.exists():
            return
        left = {}
        if self.names(folder).exists():
            for line in self.names(folder).read_text().splitlines():
                inode, name = line.split(" ", 1)
                content = self.synced / inode
                left[name] = content.read_bytes() if content.exists() else b""
        shutil.rmtree(folder)
        folder.mkdir()
        for name, content in left.items():
            (folder / name).write_bytes(content)


def ids_in(table):
    return [row["target"] for row in rows_of(table)] if table.exists() and table.stat().st_size else []


def servo_losses(cell, disk, losses):
    write_targets(cell)
    folder = cell.path("powerless")
    table = folder / "results.csv"
    lost, rounds = 0, 0
    while lost < losses:
        shutil.rmtree(folder, ignore_errors=True)
        rounds, kept = rounds + 1, set()
        while True:
            arguments = ["--cell", "cell.yaml", "--targets", "targets.csv", "--out", "powerless", "--no-health",
                         *(["--resume"] if folder.exists() else [])]
            went = kill_once(cell, "planar-servo", arguments, 2.5, disk.environment(folder))
            written = ids_in(table)
            if not went:
                break
            lost += 1
            disk.lose_power(folder)
            left = ids_in(table)
            if not kept <= set(left) or len(left) < len(written) - 1:
                raise SystemExit(f"results.csv: of {written} and {kept} only {left} survived")
            kept = set(left)
        if sorted(written) != sorted(f"T{i}" for i in range(TARGETS)):
            raise SystemExit(f"the resumed run ended with {written}")
    print(f"planar-servo: {lost} losses in {rounds} runs; all {TARGETS} targets have a result each time")
    return lost


def writer_losses(cell, disk, losses):
    folder = cell.path("maps")
    folder.mkdir(exist_ok=True)
    fit = ["-o", "maps/map.yaml", "pairs.csv"]
    status, said = cell.run("planar-fit-error-map", *fit)
    if status != 0:
        raise SystemExit(f"planar-fit-error-map: {said}")
    whole, lost = undated(folder / "map.yaml"), 0
    while lost < losses:
        lost += kill_once(cell, "planar-fit-error-map", fit, 0.5, disk.environment(folder))
        disk.lose_power(folder)
        if undated(folder / "map.yaml") != whole:
            raise SystemExit("map.yaml: half-written")
    print(f"planar-fit-error-map: {lost} losses, the map is whole each time")
    return lost


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--losses", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random.seed(options.seed)
    start = time.monotonic()
    cell = make_cell(options.programs, 7, options.out / "cell").copy_to(options.out / "powerless")
    disk = Disk(options.out)
    lost = servo_losses(cell, disk, options.losses * 3 // 4)
    lost += writer_losses(cell, disk, options.losses - lost)
    print(f"{lost} losses of power in {time.monotonic() - start:.0f} s: nothing lost, nothing half-written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
