#!/usr/bin/env python3
"""Kills programs at random moments and looks at what they leave behind.

    bench/faults/kills.py BUILD/bin OUT [--kills 500]

planar-servo and planar-record are killed and resumed until they are done; planar-fit-error-map and
planar-pair-tracker are killed while they write. After each kill every table must be readable, its
rows whole and each id there once; a file that is written at once is there whole or not at all. In the
end the resumed run has a result of every target, as good as that of an uninterrupted one."""

import argparse
import csv
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from cell_folder import make_cell

TARGETS = 12


def rows_of(path):
    """Reads a table as the programs do: a last line without its end does not count."""
    text = path.read_text()
    whole = text[:text.rfind("\n") + 1]
    lines = [line for line in whole.splitlines() if not line.startswith("#")]
    rows = list(csv.reader(lines))
    broken = [row for row in rows if len(row) != len(rows[0])]
    if broken:
        raise SystemExit(f"{path}: a row of {len(broken[0])} fields in a table of {len(rows[0])}")
    return [dict(zip(rows[0], row)) for row in rows[1:]]


def write_targets(cell):
    cell.path("targets.csv").write_text("id,x_mm,y_mm\n" + "".join(
        f"T{i},{-330 + 55 * i},{150 + 7 * i}\n" for i in range(TARGETS)))


def kill_once(cell, program, arguments, longest_s, environment=None):
    """Runs a program and kills it after a random time. Returns whether it was killed."""
    process = subprocess.Popen([str((cell.programs / program).resolve()), *map(str, arguments)],
                               cwd=cell.folder, env=environment, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        process.wait(random.uniform(0.02, longest_s))
        return False
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
        return True


def to_go_on(cell, program, arguments, folder):
    """Returns the arguments by which a program begins its work, or resumes where it was killed."""
    begun = cell.path(folder).exists()
    return [*arguments, "--resume"] if begun and program == "planar-servo" else arguments


def resume_until_done(cell, kills, program, arguments, folder, table, key, longest_s):
    """Kills a program and resumes it until it ends by itself. Returns the number of kills."""
    killed, finished = 0, set()
    while killed < kills:
        was_killed = kill_once(cell, program, to_go_on(cell, program, arguments, folder), longest_s)
        killed += was_killed
        if (cell.path(folder) / table).exists():
            rows = rows_of(cell.path(folder) / table)
            ids = [row[key] for row in rows]
            if table == "results.csv" and len(ids) != len(set(ids)):
                raise SystemExit(f"{table}: an id stands twice")
            if not finished <= set(ids):
                raise SystemExit(f"{table}: lost {finished - set(ids)}")
            finished = set(ids)
        if not was_killed:
            break
    return killed


def kill_servo(cell, kills):
    write_targets(cell)
    cell.servo(out="whole")
    whole = cell.true_errors_mm("whole")
    arguments = ["--cell", "cell.yaml", "--targets", "targets.csv", "--out", "killed", "--no-health"]
    killed, rounds = 0, 0
    while killed < kills:
        subprocess.run(["rm", "-rf", cell.path("killed")], check=True)
        killed += resume_until_done(cell, kills - killed, "planar-servo", arguments, "killed",
                                    "results.csv", "target", 2.5)
        rounds += 1
    status, said = cell.run("planar-servo",
                            *to_go_on(cell, "planar-servo", arguments, "killed"))
    resumed = cell.true_errors_mm("killed")
    if status != 0 or len(resumed) != TARGETS:
        raise SystemExit(f"the resumed run has {len(resumed)} of {TARGETS} targets: {said}")
    print(f"planar-servo: {killed} kills in {rounds} runs; mean true error {sum(resumed) / TARGETS:.4f} mm, "
          f"uninterrupted {sum(whole) / TARGETS:.4f} mm")
    return killed


def kill_record(cell, kills):
    cell.path("plan.csv").write_text("id,plan,x_mm,y_mm,phi_deg\n" + "".join(
        f"p{i},train,{-330 + 22 * i},{150 + 3 * i},0\n" for i in range(30)))
    killed, rounds = 0, 0
    while killed < kills:
        subprocess.run(["rm", "-rf", cell.path("killed_recording")], check=True)
        killed += resume_until_done(
            cell, kills - killed, "planar-record",
            ["--cell", "cell.yaml", "--plan", "plan.csv", "--out", "killed_recording"],
            "killed_recording", "frames.csv", "id", 0.8)
        rounds += 1
    status, said = cell.run("planar-record", "--cell", "cell.yaml", "--plan", "plan.csv", "--out",
                            "killed_recording")
    ids = {row["id"] for row in rows_of(cell.path("killed_recording") / "frames.csv")}
    if status != 0 or len(ids) != 30:
        raise SystemExit(f"the resumed recording has {len(ids)} of 30 places: {said}")
    print(f"planar-record: {killed} kills in {rounds} recordings; all 30 places are there")
    return killed


def undated(path):
    return [line for line in path.read_text().splitlines() if not line.startswith("created:")]


def kill_writers(cell, kills):
    killed = 0
    fit = ["-o", "map.yaml", "pairs.csv"]
    status, said = cell.run("planar-fit-error-map", *fit)
    if status != 0:
        raise SystemExit(f"planar-fit-error-map: {said}")
    whole = undated(cell.path("map.yaml"))
    while killed < kills:
        killed += kill_once(cell, "planar-fit-error-map", fit, 0.5)
        if undated(cell.path("map.yaml")) != whole:
            raise SystemExit("map.yaml: half-written")
        killed += kill_once(cell, "planar-pair-tracker",
                            ["--cell", "cell.yaml", "--lamps", "lamps.csv", "--recording", "recording",
                             "--workplane-out", "w.yaml", "--tool-out", "t.yaml", "-o", "p.csv"], 0.6)
        for name in ("w.yaml", "t.yaml", "p.csv"):
            if cell.path(name).exists() and not cell.path(name).read_text().endswith("\n"):
                raise SystemExit(f"{name}: half-written")
    print(f"planar-fit-error-map and planar-pair-tracker: {killed} kills, no file half-written")
    return killed


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random.seed(options.seed)
    start = time.monotonic()
    cell = make_cell(options.programs, 7, options.out / "cell").copy_to(options.out / "killed")
    share = options.kills // 3
    killed = kill_servo(cell, share) + kill_record(cell, share)
    killed += kill_writers(cell, options.kills - killed)
    print(f"{killed} kills in {time.monotonic() - start:.0f} s: nothing lost, nothing half-written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
