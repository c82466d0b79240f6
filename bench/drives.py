#!/usr/bin/env python3
"""Targets on one served cell whose arm is moved by each kind of drive in turn, against its truth.

drives.py BIN OUT [--targets N] [--kinds grbl,command,modbus,linuxcnc]

The calibrated cell calib/workshop is served; grbl is the emulated board of the served cell, command the example of a
motion program, modbus the emulated drivers of the tests, linuxcnc the real LinuxCNC (installed, and ../shared beside the
checkout; not as root's own: it runs as nobody). Prints a row each: targets reached, mean and largest true error as the
run ended (truth log), seconds per target and their ratio to grbl's. Run it by tests/support/loopback_only.sh.
"""
import argparse
import csv
import os
import random
import re
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/support"))
COUNTS_PER_DEG = (10000 * 100 / 360, 10000 * 100 / 360, 10000 * 50 / 360)  # of calib/workshop


class Server:
    def __init__(self, bin, folder, shafts):
        self.process = subprocess.Popen(
            [bin / "planar-virtual-cell", "serve", "--cell", folder / "cell.yaml", "--out", folder / "live.yaml",
             "--truth-log", folder / "truth.csv", *(["--shafts"] if shafts else [])],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        while not self.process.stdout.readline().startswith("tracker"):
            assert self.process.poll() is None, "nothing is served"

    def end(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(20)


def drives_text(kind, folder):
    if kind == "modbus":
        addresses = iter("123")
        return lambda _: (f"port: {folder}/line, baud: 115200, parity: none, registers: leadshine-rs.yaml, "
                          f"address: {next(addresses)}")
    joints = iter((("A", 0), ("B", 1), ("C", 2)))
    return lambda _: "host: 127.0.0.1, axis: {}, joint: {}".format(*next(joints))


def start_linuxcnc(folder):
    """Starts LinuxCNC with a sampler, whose lines of joints become counts in the pipe."""
    configuration = folder / "configuration"
    shutil.copytree(ROOT.parent / "shared/firmware/linuxcnc", configuration)
    ini = configuration / "planar.ini"  # LinuxCNC's limits count from where its joints stand as they are homed
    ini.write_text(re.sub(r"(M.._LIMIT = -?)(\d+)", lambda found: found[1] + str(2 * int(found[2])), ini.read_text()))
    with open(configuration / "planar.hal", "a", encoding="ascii") as hal:
        hal.write("loadrt sampler depth=4000 cfg=fff\naddf sampler.0 servo-thread\n"
                  + "".join(f"net j{i} => sampler.0.pin.{i}\n" for i in range(3)))
    subprocess.run([ROOT / "tests/drives/linuxcnc.sh", "start", configuration, folder / "linuxcnc"], check=True)
    sampler = subprocess.Popen(["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups", "stdbuf", "-oL",
                                "halsampler", "-c", "0"], stdout=subprocess.PIPE, text=True)
    forward = ("import sys\nscales, told = (%r), None\npipe = open(sys.argv[1], 'w')\n"
               "for line in sys.stdin:\n"
               "    counts = [round(float(v) * s) for v, s in zip(line.split(), scales)]\n"
               "    if counts != told:\n"
               "        pipe.write(' '.join(map(str, counts if told else ['at', *counts])) + '\\n'); pipe.flush()\n"
               "        told = counts\n" % (COUNTS_PER_DEG,))
    return [sampler, subprocess.Popen([sys.executable, "-c", forward, folder / "shafts"], stdin=sampler.stdout)]


def run(bin, out, kind, targets):
    folder = out / kind
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "calib/workshop", folder)
    server = Server(bin, folder, kind != "grbl")
    helpers = []
    if kind == "command":
        shutil.copy(ROOT / "examples/python/motion_program.py", folder)
    if kind == "modbus":
        shutil.copy(ROOT / "calib/modbus/leadshine-rs.yaml", folder)
        helpers.append(subprocess.Popen(
            ["/usr/bin/python3", "-B", ROOT / "tests/drives/modbus_drivers.py", ROOT / "examples/python",
             folder / "line", "--shafts", folder / "shafts"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
        helpers[0].stdout.readline()
    if kind == "linuxcnc":
        helpers += start_linuxcnc(folder)
    if kind in ("modbus", "linuxcnc"):
        text = re.sub(r"program: \[.*?\](?=[,}\n])", drives_text(kind, folder), (folder / "live.yaml").read_text())
        (folder / "live.yaml").write_text(text.replace("kind: command", f"kind: {kind}"))
    begun = time.monotonic()
    done = subprocess.run([bin / "planar-servo", "--cell", folder / "live.yaml", "--targets", targets, "--out",
                           folder / "run", "--no-health", "--home" if kind == "grbl" else "--at-marks"],
                          capture_output=True, text=True)
    seconds = time.monotonic() - begun
    (folder / "log.txt").write_text(done.stderr)
    for helper in reversed(helpers):
        helper.terminate()
    if kind == "linuxcnc":
        subprocess.run([ROOT / "tests/drives/linuxcnc.sh", "stop", "x", folder / "linuxcnc"], check=False)
    server.end()
    if not (folder / "run/results.csv").exists():
        raise SystemExit(f"{kind}: {done.stderr}")
    rows = list(csv.DictReader(line for line in open(folder / "run/results.csv") if line[0] != "#"))
    if done.returncode != 0:
        print(f"{kind}: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
    if not rows:
        raise SystemExit(f"{kind}: no target was tried")
    return rows, seconds, folder


def true_errors(rows, folder):
    """The tool's true distance from each target where it rested last near it."""
    truth = [tuple(map(float, line)) for line in csv.reader(open(folder / "truth.csv")) if line[0][0].isdigit()]
    rests = [(x, y) for (t, x, y, _), (after, *_) in zip(truth, truth[1:] + [(1e12,)]) if after - t > 0.1]
    # Rests come in the order of the targets: those of one end where the next one's begin.
    errors, first = [], 0
    for row, after in zip(rows, [*rows[1:], None]):
        def miss(rest, of):
            return ((rest[0] - float(of["x_mm"])) ** 2 + (rest[1] - float(of["y_mm"])) ** 2) ** 0.5

        def first_near(of):
            return next((i for i in range(first, len(rests)) if miss(rests[i], of) < 1.0), len(rests))

        first = first_near(row)
        end = first_near(after) if after else len(rests)
        near = [d for d in (miss(rest, row) for rest in rests[first:max(end, first + 1)]) if d < 1.0]
        if row["status"] == "reached":
            errors.append(near[-1])
    return errors


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--targets", type=int, default=100)
    parser.add_argument("--kinds", default="grbl,command,modbus,linuxcnc")
    options = parser.parse_args()
    options.bin, options.out = options.bin.resolve(), options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    rng = random.Random(40)
    targets = options.out / "targets.csv"
    with open(targets, "w", encoding="ascii") as table:
        table.write("id,x_mm,y_mm\n")
        for i in range(options.targets):
            table.write(f"T{i},{rng.uniform(120, 330):.3f},{rng.uniform(-250, 250):.3f}\n")
    first = None
    for kind in options.kinds.split(","):
        rows, seconds, folder = run(options.bin, options.out, kind, targets)
        errors = true_errors(rows, folder)
        each = seconds / max(1, len(rows))
        first = first or each
        print(f"{kind:9} {len(errors):4} of {options.targets} reached; true error mean "
              f"{statistics.mean(errors):.4f}, largest {max(errors):.4f} mm; {each:.2f} s a target, "
              f"{each / first:.2f} x {options.kinds.split(',')[0]}", flush=True)


if __name__ == "__main__":
    main()
