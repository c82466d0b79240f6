#!/usr/bin/env python3
"""Does the whole afternoon on a served cell, and scores it by the log of the truth.

    tests/support/loopback_only.sh bench/afternoon/afternoon.py BIN_DIR OUT [--seed N] [--train N]
        [--pair-by id|time] [--crash] [--certify CYCLES TARGETS]
        [--serve OPTION ...]

One terminal serves the cell, the other runs the programs of doc/virtual_cell.md; this script types what they ask
for, and nothing else of the simulation reaches them. The same cell is calibrated and run in process as well.
OUT gets the logs and recordings of both, and afternoon.json the mean true errors. With --certify the served cell
gets a certificate, which its tracker judges; its figures are printed beside those of the truth.
"""

import argparse
import csv
import json
import math
import pathlib
import random
import re
import signal
import statistics
import subprocess
import sys
import threading
import time

import true_certificate

TARGETS = 24
ATTEMPTS = 30
TRY_AGAIN = "start again|no frame|does not answer|have not arrived"
BOARD = "circles:11x11:50mm"


def spiral(n, inner, outer, turn):
    for i in range(n):
        r = math.sqrt(inner**2 + (outer**2 - inner**2) * (i + 0.5) / n)
        yield r * math.cos(2.4 * i + turn), r * math.sin(2.4 * i + turn)


def write_plan(path, train):
    rows = ["id,plan,x_mm,y_mm,phi_deg"]
    rows += [f"board_{i:02d},grid,,," for i in range(12)]
    rows += [f"laid_{i},plane_grid,,," for i in range(2)]
    rows += [f"turn_{i:02d},sweep3,0,300,{30 * i - 180}" for i in range(12)]
    places = list(spiral(train, 80, 520, 0))
    random.Random(1).shuffle(places)  # so that a step in time is none in space
    rows += [f"train_{i:03d},train,{x:.3f},{y:.3f},0" for i, (x, y) in enumerate(places)]
    path.write_text("\n".join(rows) + "\n")


def write_targets(path):
    rows = [f"t{i},{x:.3f},{y:.3f}" for i, (x, y) in enumerate(spiral(TARGETS, 100, 500, 1))]
    path.write_text("\n".join(["id,x_mm,y_mm"] + rows) + "\n")


class StampedLog:
    """A log whose lines begin with the minutes and seconds since it was opened."""

    def __init__(self, path):
        self.file, self.began, self.at_begin = open(path, "w", buffering=1), time.monotonic(), True

    def write(self, text):
        for line in re.findall(r"[^\n]*\n|[^\n]+", text):
            if self.at_begin:
                self.file.write("{:3.0f}:{:02.0f} ".format(*divmod(int(time.monotonic() - self.began), 60)))
            self.file.write(line)
            self.at_begin = line.endswith("\n")


class Program:
    """A program whose output is heard while it runs."""

    def __init__(self, command, log, cwd):
        log.write("$ " + " ".join(map(str, command)) + "\n")
        self.log, self.heard, self.read = log, "", 0
        self.process = subprocess.Popen(command, cwd=cwd, text=True, bufsize=0, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.thread = threading.Thread(target=self._hear, daemon=True)
        self.thread.start()

    def _hear(self):
        while text := self.process.stdout.read(1):
            self.heard += text
            self.log.write(text)

    def type(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def next(self, patterns, patience_s):
        """Returns the match that comes first in what is said next; None when nothing matches in time."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            found = [m for p in patterns if (m := re.compile(p).search(self.heard, self.read))]
            if found:
                first = min(found, key=lambda m: m.start())
                self.read = first.end()
                return first
            if not self.thread.is_alive():
                return None
            time.sleep(0.05)
        return None

    def end(self):
        self.process.stdin.close()
        self.thread.join()
        return self.process.wait()


class Afternoon:
    def __init__(self, options):
        self.bin, self.out, self.options = options.bin.resolve(), options.out.resolve(), options
        self.out.mkdir(parents=True)
        self.crash = options.crash
        self.views = {}  # how often the board was held and laid
        self.log = StampedLog(self.out / "afternoon.log")

    def run(self, folder, program, *arguments):
        began = time.monotonic()
        done = Program([self.bin / program, *map(str, arguments)], self.log, folder)
        status = done.end()
        self.log.write(f"({program}: {time.monotonic() - began:.0f} s)\n")
        if status != 0:
            raise SystemExit(f"{program} ended with {status}: {done.heard[-2000:]}")

    def at_cell(self, line):
        self.served.type(line)
        answer = self.served.next([r"the (board|reflector) is .*\n", r"not understood.*\n"], 30)
        if answer is None or answer.group().startswith("not"):
            raise SystemExit(f"the served cell does not obey '{line}'")

    def operate(self, folder, program, *arguments):
        """Runs a program that asks for a person, and starts it again when it says so, as when the computer lost too
        many frames."""
        command = [self.bin / program, *map(str, arguments)]
        for attempt in range(ATTEMPTS):
            operated = self.operate_once(folder, command)
            status = operated.end()
            if status == 0:
                self.log.write(f"({program} was started {attempt + 1} times)\n")
                return operated
            if status != -signal.SIGKILL and not re.search(TRY_AGAIN, operated.heard):
                break
            time.sleep(5)  # in which the camera forgets who controlled it
        raise SystemExit(f"{program} has failed: {operated.heard[-2000:]}")

    def operate_once(self, folder, command):
        """Does what the program asks of a person."""
        asks = [r"place the reflector on '(?P<monument>[^']*)'", r"reflector back on the tool",
                r"more views? of the board", r"more lays? of the board", r"is taken", r"arm's way"]
        program = Program(command, self.log, folder)
        if self.crash:
            threading.Thread(target=self.kill_midway, args=(program, folder), daemon=True).start()
        verb = None
        while program.thread.is_alive():
            said = program.next(asks, 20 if verb else 3600)
            if said is None and verb is None:
                continue
            word = said.group() if said else "another view"
            if "monument" in (said.groupdict() if said else {}) and said.group("monument"):
                self.at_cell(f"reflector {said.group('monument')}")
                program.type("")
            elif "back on" in word:
                self.at_cell("reflector tool")
                program.type("")
            elif "arm's way" in word:
                verb = None
                self.at_cell("board remove")
            else:
                if "of the board" in word:
                    verb = "lay" if "lay" in word else "hold"
                self.views[verb] = self.views.get(verb, -1) + 1
                self.at_cell(f"board {verb} {self.views[verb]}")
        return program

    def kill_midway(self, program, folder):
        """Kills the recording, once, when it has half of the places."""
        half, frames = f"\ntrain_{self.options.train // 2:03d},", folder / "recording" / "frames.csv"
        while program.thread.is_alive():
            if frames.exists() and half in frames.read_text():
                self.crash = False
                program.process.kill()
                return
            time.sleep(0.2)

    def calibrate(self, folder, pair_by):
        self.run(folder, "planar-calibrate-camera", "--grid", BOARD, "--model", "auto", "-o", "camera.yaml",
                 "recording")
        self.run(folder, "planar-locate-lamps", "--cell", "cell.yaml", "-o", "lamps.csv", "recording")
        self.run(folder, "planar-pair-tracker", "--cell", "cell.yaml", "--lamps", "lamps.csv", "--recording",
                 "recording", "--pair-by", pair_by, "--workplane-out", "workplane.yaml", "--tool-out",
                 "tool.yaml", "--health-out", "health.yaml", "-o", "pairs.csv")
        self.run(folder, "planar-fit-error-map", "--cell", "cell.yaml", "--arm-out", "arm.yaml", "-o",
                 "map.yaml", "pairs.csv")
        with open(folder / "cell.yaml", "a") as cell:
            cell.write("arm_found: arm.yaml\n")

    def in_process(self):
        folder = self.out / "in_process"
        self.run(self.out, "planar-virtual-cell", "draw", "--seed", self.options.seed, "-o", folder)
        write_plan(folder / "plan.csv", self.options.train)
        write_targets(folder / "targets.csv")
        self.run(folder, "planar-record", "--cell", "cell.yaml", "--plan", "plan.csv", "--out", "recording")
        self.calibrate(folder, "id")
        self.run(folder, "planar-servo", "--cell", "cell.yaml", "--targets", "targets.csv", "--out", "run",
                 "--json", "run.json")
        return json.loads((folder / "run.json").read_text())["after_mean_mm_truth"]

    def live(self):
        workshop, folder = self.out / "workshop", self.out / "live"
        folder.mkdir()
        self.run(self.out, "planar-virtual-cell", "draw", "--seed", self.options.seed, "-o", workshop)
        write_plan(folder / "plan.csv", self.options.train)
        write_targets(folder / "targets.csv")
        self.served = Program([self.bin / "planar-virtual-cell", "serve", "--cell", workshop / "cell.yaml",
                               "--out", folder / "cell.yaml", "--truth-log", self.out / "truth.csv",
                               *self.options.serve], self.log, self.out)
        try:
            if self.served.next([r"tracker .*\n"], 60) is None:
                raise SystemExit(f"nothing is served: {self.served.heard}")
            self.run(folder, "planar-doctor", "--cell", "cell.yaml")
            self.operate(folder, "planar-record", "--cell", "cell.yaml", "--plan", "plan.csv", "--out", "recording",
                         "--grid", BOARD, "--home")
            self.calibrate(folder, self.options.pair_by)
            self.run(folder, "planar-servo", "--cell", "cell.yaml", "--targets", "targets.csv", "--out", "run",
                     "--home")
            if self.options.certify:
                cycles, targets = self.options.certify
                self.operate(folder, "planar-certify", "--cell", "cell.yaml", "--out", "certificate", "--cycles",
                             cycles, "--targets", targets, "--home")
        finally:
            self.served.process.terminate()
            self.served.end()
        return self.true_error(folder)

    def true_error(self, folder):
        """Returns the mean distance from each target to the true end point at the last look, and the standard
        deviation of that mean, mm."""
        rows = lambda path: csv.DictReader(line for line in open(path) if not line.startswith("#"))
        truth = [(float(r["t_s"]), float(r["x_mm"]), float(r["y_mm"])) for r in rows(self.out / "truth.csv")]
        looks = {}
        for step in rows(folder / "run" / "steps.csv"):
            looks[step["target"]] = max(float(step["t_s"]), looks.get(step["target"], -math.inf))
        errors = []
        for target in rows(folder / "targets.csv"):
            _, x, y = max(row for row in truth if row[0] <= looks[target["id"]])
            errors.append(math.hypot(x - float(target["x_mm"]), y - float(target["y_mm"])))
        return statistics.mean(errors), statistics.stdev(errors) / math.sqrt(len(errors))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--train", type=int, default=60, help="places to which the map is fitted")
    parser.add_argument("--pair-by", choices=["id", "time"], default="id", help="of the served cell's readings")
    parser.add_argument("--crash", action="store_true", help="kill the recording once, when it has half of the places")
    parser.add_argument("--certify", nargs=2, type=int, metavar=("CYCLES", "TARGETS"),
                        help="size of a certificate of the served cell")
    parser.add_argument("--serve", nargs=argparse.REMAINDER, default=[], help="options of planar-virtual-cell serve")
    options = parser.parse_args()
    if not (options.bin / "planar-record").exists():
        parser.error(f"{options.bin} has no planar-record; give the folder of the built programs, build/release/bin")
    if options.out.exists():
        parser.error(f"{options.out} exists already; name a new folder")
    afternoon = Afternoon(options)
    in_process = afternoon.in_process()
    live, live_sigma = afternoon.live()
    figures = {"in_process_mean_mm_truth": in_process, "live_mean_mm_truth": live,
               "live_mean_sigma_mm": live_sigma, "ratio": live / in_process}
    (afternoon.out / "afternoon.json").write_text(json.dumps(figures, indent=2) + "\n")
    print(f"mean true error of {TARGETS} targets: in process {in_process:.4f} mm, served {live:.4f} "
          f"+- {live_sigma:.4f} mm, ratio {live / in_process:.2f}")
    if options.certify:
        text, agree = true_certificate.compare(afternoon.out / "truth.csv", afternoon.out / "live" / "certificate")
        print(text)
        sys.exit(0 if agree else 1)


if __name__ == "__main__":
    main()
