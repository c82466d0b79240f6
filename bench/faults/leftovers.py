#!/usr/bin/env python3
"""Starts programs on a served cell whose board counts from somewhere, and counts those that plan from there.

    tests/support/loopback_only.sh bench/faults/leftovers.py BIN_DIR OUT_DIR --cell DIR [--starts N] [--only PROGRAM]

Before each start planar-jog homes the cell's Grbl board and leaves it at a random place. A program with --home must home before it moves anything else, one without must refuse and name the drives.
Prints for each program how often it homed first, refused rightly, and did neither. Ends with status 1 for the last."""

import argparse
import csv
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

PLACE = "id,x_mm,y_mm\na,300,-200\n"
PLAN = "id,plan,x_mm,y_mm,phi_deg\nt0,pose,300,-200,0\n"
PROGRAMS = {
    "planar-servo": ["--targets", "targets.csv", "--no-health", "--accept-stale", "--accept-map"],
    "planar-check-cell": [],
    "planar-record": ["--plan", "plan.csv"],
}


class Served:
    def __init__(self, programs, out, cell):
        self.log = open(out / "served.txt", "w+", encoding="utf-8")
        self.process = subprocess.Popen([programs / "planar-virtual-cell", "serve", "--cell", cell, "--out", out / "live.yaml"],
                                        stdin=subprocess.PIPE, stdout=self.log, stderr=self.log)
        while "tracker " not in (out / "served.txt").read_text():
            if self.process.poll() is not None:
                sys.exit((out / "served.txt").read_text())
            time.sleep(0.1)


def leave_somewhere(programs, out, chance):
    turns = [f"joint {joint} {chance.uniform(-14, 14):.2f}\n" for joint in (1, 2, 3) for _ in range(chance.randrange(4))]
    chance.shuffle(turns)
    subprocess.run([programs / "planar-jog", "-q", "--cell", out / "live.yaml"], input="enable\nhome\n" + "".join(turns),
                   text=True, capture_output=True, check=False)


def start(programs, out, name, homes):
    shutil.rmtree(out / "made", ignore_errors=True)
    made = ["--out", "made"] if name != "planar-check-cell" else []
    homing = ["--home"] if homes else []
    command = [programs / name, "--cell", "live.yaml", *PROGRAMS[name], *made, *homing]
    with subprocess.Popen(command, cwd=out, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE) as process:
        said = ""
        for line in process.stderr:
            said += line
            if "drive 3 is home" in line:
                process.send_signal(signal.SIGINT)
        status = process.wait(60)
    if not homes:
        return "refused" if status == 1 and "lost their position: 1 2 3; start with --home" in said else said
    first = re.findall(r"homing: drive (\d) is home|outside (?:its|the) workspace|checking the cell|has lost its", said)
    return "homed" if first[:3] == ["1", "2", "3"] else said


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("out_dir", type=pathlib.Path)
    parser.add_argument("--starts", type=int, default=200)
    parser.add_argument("--only", choices=PROGRAMS)
    parser.add_argument("--cell", type=pathlib.Path, required=True, help="a calibrated virtual cell")
    options = parser.parse_args()
    programs, out = options.bin_dir.resolve(), options.out_dir.resolve()
    shutil.copytree(options.cell, out)
    (out / "targets.csv").write_text(PLACE)
    (out / "plan.csv").write_text(PLAN)
    served = Served(programs, out, out / "cell.yaml")
    wrong = 0
    for name in [options.only] if options.only else PROGRAMS:
        chance, counts = random.Random(name), {"homed": 0, "refused": 0, "wrong": 0}
        for number in range(options.starts):
            leave_somewhere(programs, out, chance)
            end = start(programs, out, name, homes=number % 2 == 0)
            if end not in counts:
                print(f"{name}, start {number}: {end}", file=sys.stderr)
                end = "wrong"
            counts[end] += 1
        print(f"{name:20} " + ", ".join(f"{what} {count}" for what, count in counts.items()), flush=True)
        wrong += counts["wrong"]
    served.process.terminate()
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
