#!/usr/bin/env python3
"""Injects faults into a drawn and calibrated virtual cell, one at a time, and tells what was said.

    bench/faults/table.py BUILD/bin OUT [--only WORDS] [--healthy]

Each fault is named (the messages contain its cause), misnamed (they contain another one), noticed (the
exit status is not 0, or there is a message at all) or silent. For what moved, the largest true error of
the targets that were called reached says what the fault cost. All that was said stands in OUT/said.txt.
--healthy runs 20 drawn cells ten times each instead, in which nothing is wrong."""

import argparse
import re
import sys
from pathlib import Path

from cell_folder import make_cell
import faults
import input_faults
import lab_faults

ALL = faults.ALL + lab_faults.ALL + input_faults.ALL
KINDS = ("named", "misnamed", "noticed", "silent")
SILENT_COST_MM = 0.05

# Words by which a program says what is wrong, or asks whether it is.
CAUSES = re.compile(
    r"camera (has )?(shifted|turned|tilted|moved?\b|come closer)|focused elsewhere|lamp \d has moved|"
    r"lamp moved|lamps are not seen|lamps dim|window|reflection|been touched|slip|stray|lose steps|"
    r"stops scatter|joint \d has lost|play of joint|direction of joint|gear ratio of|link \d has|"
    r"coupling of|motors' warmth|"
    r"elbow|home is not|drive lost|picture is mirrored|reflector was|tracker moved|monument|"
    r"mirrored|exchange|shifted by|frozen|was made with|was changed after|the unit", re.IGNORECASE)


# What is said of a sound cell, too.
SOUND = re.compile(r".*(checking the cell( again)?: |the cell is as it was at its calibration).*\n?")


def verdict(fault, status, said):
    said = SOUND.sub("", said)
    if re.search(fault.causes, said, re.IGNORECASE):
        return "named"
    if CAUSES.search(said):
        return "misnamed"
    return "noticed" if status != 0 or said.strip() else "silent"


def said_line(fault, said):
    """The line that names the cause, or else the first one."""
    lines = SOUND.sub("", said).splitlines()
    naming = [line for line in lines if re.search(fault.causes, line, re.IGNORECASE)]
    return (naming or lines or [""])[0].strip()


def fault_table(programs, out, only):
    cell = make_cell(programs, 7, out / "cell")
    other = make_cell(programs, 8, out / "other")
    cell.use_found_arm()
    status, said = cell.servo()
    healthy = cell.true_errors_mm()
    if status != 0:
        sys.exit(f"the healthy cell is not reached: {said}")
    print(f"healthy: {max(healthy):.4f} mm at most")
    counts = dict.fromkeys(KINDS, 0)
    costly, told = [], []
    (out / "said.txt").write_text("")
    for fault in ALL:
        if only and not re.search(only, fault.name):
            continue
        copy = cell.copy_to(out / "spoilt")
        fault.inject(copy, other)
        status, said = fault.run(copy)
        errors = copy.true_errors_mm(meant=fault.meant)
        cost = max(errors) if errors else 0.0
        kind = verdict(fault, status, said)
        with open(out / "said.txt", "a") as log:
            log.write(f"{kind}: {fault.name}, exit {status}\n{said}\n")
        counts[kind] += 1
        if cost > SILENT_COST_MM:
            (costly if kind == "silent" else told).append(fault.name)
        print(f"{kind:8} {fault.name:56} exit {status}  {cost:8.4f} mm  {said_line(fault, said)[:150]}",
              flush=True)
    if not any(counts.values()):
        sys.exit(f"no fault is called {only}")
    all_faults, any_named = sum(counts.values()), counts["named"] + counts["misnamed"]
    share, right = any_named / all_faults, counts["named"] / max(any_named, 1)
    print(f"{all_faults} faults: " + ", ".join(f"{n} {kind}" for kind, n in counts.items()) +
          f"; {100 * share:.0f} % named (bound 80), {100 * right:.0f} % of these by the right cause "
          f"(bound 90); reached beyond {SILENT_COST_MM} mm and silent: {', '.join(costly) or 'none'} "
          f"(bound none), with a word: {', '.join(told) or 'none'}")
    return not costly and share >= 0.8 and right >= 0.9


def healthy_runs(programs, out):
    refused, runs = 0, 0
    for seed in range(101, 121):
        cell = make_cell(programs, seed, out / f"healthy{seed}")
        for i in range(10):
            cell.path("targets.csv").write_text(
                f"id,x_mm,y_mm\nT1,{-300 + 60 * i},{220 - 15 * i}\n")
            status, said = cell.servo()
            runs += 1
            if status != 0:
                refused += 1
                print(f"cell {seed}, run {i}: {said.strip()}", flush=True)
    print(f"{runs} healthy runs on 20 drawn cells: {refused} refused (bound 1)")
    return refused <= 1


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", help="a pattern of the names of faults")
    parser.add_argument("--healthy", action="store_true")
    options = parser.parse_args()
    kept = (healthy_runs(options.programs, options.out) if options.healthy else
            fault_table(options.programs, options.out, options.only))
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
