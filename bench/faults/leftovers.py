#!/usr/bin/env python3
"""Starts programs on a served cell whose board counts from somewhere, and counts those that plan from there.

    tests/support/loopback_only.sh bench/faults/leftovers.py BIN_DIR OUT_DIR --cell DIR [--starts N] [--only PROGRAM]

Before each start planar-jog homes the cell's Grbl board and leaves it at a random place. Half of the starts ask for homing: they must home before anything is moved or told of the joints. The others must refuse and name the drives. The Python module is found as PYTHONPATH says.
Prints for each program how often it homed first, refused rightly, and did neither. Ends with status 1 for the last."""

import argparse
import json
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import urllib.error

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests/support"))
from served_console import ServedConsole

PLACE = "id,x_mm,y_mm\na,300,-200\n"
PLAN = "id,plan,x_mm,y_mm,phi_deg\nt0,pose,300,-200,0\n"
RUNS = {
    "planar-servo": ["--targets", "targets.csv", "--no-health", "--accept-stale", "--accept-map", "--out", "made"],
    "planar-check-cell": [],
    "planar-record": ["--plan", "plan.csv", "--out", "made"],
}
HOMES = re.compile(r"homing: drive (\d) is home|outside (?:its|the) workspace|checking the cell|has lost its")
JOINTS = re.compile(r"^joints (\S+) (\S+) (\S+) deg", re.MULTILINE)
PYTHON = """import logging, planar_servo as ps
logging.basicConfig(level=logging.INFO)
with ps.Cell("live.yaml", accept_stale=True, accept_map=True, check_health=False, home={homes}) as cell:
    cell.move_to((0.3, -0.2))
"""


class Served:
    def __init__(self, programs, out, cell):
        self.log = open(out / "served.txt", "w+", encoding="utf-8")
        self.process = subprocess.Popen([programs / "planar-virtual-cell", "serve", "--cell", cell, "--out", out / "live.yaml"],
                                        stdin=subprocess.PIPE, stdout=self.log, stderr=self.log)
        while "tracker " not in (out / "served.txt").read_text():
            if self.process.poll() is not None:
                sys.exit((out / "served.txt").read_text())
            time.sleep(0.1)
        home = re.search(r"home_deg: \[(.*?)\]", (out / "cell.yaml").read_text())
        self.home_deg = [float(number) for number in home[1].split(",")]

    def is_home(self, joints_deg):
        return all(abs(float(joint) - home) < 0.01 for joint, home in zip(joints_deg, self.home_deg))


def jog(programs, out, lines):
    return subprocess.run([programs / "planar-jog", "--cell", out / "live.yaml"], input=lines, text=True,
                          capture_output=True, check=False)


def leave_somewhere(programs, out, chance):
    turns = [f"joint {joint} {chance.uniform(-14, 14):.2f}\n" for joint in (1, 2, 3) for _ in range(chance.randrange(4))]
    chance.shuffle(turns)
    jog(programs, out, "enable\nhome\n" + "".join(turns))


def told(said, joints, homes, served, refusal):
    """Judges a start by the joints that it told and by what it said without them."""
    if homes:
        return "homed" if joints and served.is_home(joints) else said
    return "refused" if not joints and refusal in said else said


def start_run(name, programs, out, homes, _served):
    command = [programs / name, "--cell", "live.yaml", *RUNS[name], *(["--home"] if homes else [])]
    return judged_run(command, out, homes)


def start_python(_programs, out, homes, _served):
    return judged_run(["/usr/bin/python3", "-c", PYTHON.format(homes=homes)], out, homes)


def judged_run(command, out, homes):
    shutil.rmtree(out / "made", ignore_errors=True)
    with subprocess.Popen(command, cwd=out, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE) as process:
        said = ""
        for line in process.stderr:
            said += line
            if "drive 3 is home" in line:
                process.send_signal(signal.SIGINT)
        status = process.wait(60)
    if not homes:
        return "refused" if status == 1 and re.search("lost their position: 1 2 3; start with (--home|home=True)", said) else said
    return "homed" if HOMES.findall(said)[:3] == ["1", "2", "3"] else said


def start_jog(programs, out, homes, served):
    ended = jog(programs, out, "enable\nhome\nwhere\n" if homes else "enable\nwhere\njoint 1 1\ngo a\n")
    where = JOINTS.search(ended.stdout)
    return told(ended.stderr, where and where.groups(), homes, served, "drives do not know where they stand")


def start_console(programs, out, homes, served):
    with ServedConsole(programs / "planar-console", out / "live.yaml") as console:
        def answer(path, body):
            try:
                return console.ask(path, body)
            except urllib.error.HTTPError as error:
                return json.load(error)

        said = [answer("/api/command", {"line": "enable"})]
        console.rests()
        if homes:
            said.append(answer("/api/command", {"line": "home"}))
        else:
            said += [answer("/api/go", {"x_mm": 300, "y_mm": -200}), answer("/api/jog", {"line": "joint 1 1"})]
        arm = console.rests()["arm"]
        return told(json.dumps([said, arm]), arm["joints_deg"], homes, served, "the arm cannot move yet")


STARTS = {name: lambda *how, name=name: start_run(name, *how) for name in RUNS}
STARTS.update({"planar-jog": start_jog, "planar-console": start_console, "Python": start_python})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("out_dir", type=pathlib.Path)
    parser.add_argument("--starts", type=int, default=200)
    parser.add_argument("--only", choices=STARTS)
    parser.add_argument("--cell", type=pathlib.Path, required=True, help="a calibrated virtual cell")
    options = parser.parse_args()
    programs, out = options.bin_dir.resolve(), options.out_dir.resolve()
    shutil.copytree(options.cell, out)
    (out / "targets.csv").write_text(PLACE)
    (out / "plan.csv").write_text(PLAN)
    served = Served(programs, out, out / "cell.yaml")
    wrong = 0
    for name in [options.only] if options.only else STARTS:
        chance, counts = random.Random(name), {"homed": 0, "refused": 0, "wrong": 0}
        for number in range(options.starts):
            leave_somewhere(programs, out, chance)
            end = STARTS[name](programs, out, number % 2 == 0, served)
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
