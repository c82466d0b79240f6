#!/usr/bin/env python3
"""Closes the loop over GigE Vision and Grbl's own firmware, and compares it with the same cell in process.

    tests/support/loopback_only.sh bench/grbl/served_firmware.py BIN_DIR FIRMWARE OUT [--every N]

FIRMWARE is the simulator of Grbl 1.1h, which wants a processor for itself. The paper's cell is calibrated in process;
the servo then goes to every N-th target of its four circles, in process and over the served cell, whose log of the
truth says where it came to. Many small corrections follow, each from one frame, from whose exposures the time to the
next move on the serial line counts. After a fault a person puts the arm at its marks and the program goes on.
"""

import argparse
import bisect
import csv
import json
import math
import pathlib
import re
import shutil
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "afternoon"))
from afternoon import Program  # noqa: E402

ATTEMPTS = 20


def rows(path):
    return list(csv.DictReader(line for line in open(path) if not line.startswith("#")))


class Bench:
    def __init__(self, options):
        self.bin, self.out = options.bin.resolve(), options.out.resolve()
        self.out.mkdir(parents=True)
        self.log = open(self.out / "served_firmware.log", "w", buffering=1)
        self.cell, self.firmware, self.every = self.out / "cell", options.firmware.resolve(), options.every

    def run(self, program, *arguments):
        done = Program([self.bin / program, *map(str, arguments)], self.log, self.out)
        return done.end()

    def calibrate(self):
        shutil.copytree(HERE.parents[1] / "calib" / "paper", self.cell)
        if self.run("planar-experiment", "-q", "--cell", "cell/cell.yaml", "--out", "calibrated") != 0:
            raise SystemExit("the cell is not calibrated; see served_firmware.log")
        for file in (self.out / "calibrated" / "ours").glob("*.yaml"):
            shutil.copy(file, self.cell)
        targets = rows(self.out / "calibrated" / "ours" / "run" / "results.csv")[::self.every]
        self.write_targets("circles", [(t["target"], float(t["x_mm"]), float(t["y_mm"])) for t in targets])
        self.write_targets("small", [(f"t{i}", 200 + 40 * math.cos(2.4 * i), 150 + 40 * math.sin(2.4 * i))
                                     for i in range(20)])

    def write_targets(self, name, targets):
        lines = ["id,x_mm,y_mm"] + [f"{i},{x:.3f},{y:.3f}" for i, x, y in targets]
        (self.out / f"{name}.csv").write_text("\n".join(lines) + "\n")

    def serve(self):
        self.served = Program([self.bin / "planar-virtual-cell", "serve", "--cell", "cell/cell.yaml", "--out",
                               "cell/live.yaml", "--truth-log", "truth.csv", "--grbl-firmware", self.firmware],
                              self.log, self.out)
        if self.served.next([r"tracker .*\n"], 60) is None:
            raise SystemExit(f"nothing is served: {self.served.heard}")
        self.tap = subprocess.Popen([sys.executable, HERE / "serial_tap.py", "cell/grbl", "cell/tap", "wire.log"],
                                    cwd=self.out, stdout=subprocess.PIPE)
        self.tap.stdout.readline()
        live = self.cell / "live.yaml"
        live.write_text(live.read_text().replace(str(self.cell / "grbl"), str(self.cell / "tap")))
        self.write_small_steps(live.read_text())

    def write_small_steps(self, cell):
        """The loop makes many small corrections, each from one frame; latency.sh does the same."""
        for old, new in [("gain: 1.0", "gain: 0.3"), ("max_iterations: 12", "max_iterations: 30"),
                         ("settle_ms: 200", "settle_ms: 0"), ("frames_per_measurement: 3", "frames_per_measurement: 1"),
                         ("approach: one_side", "approach: direct")]:
            if old not in cell:
                raise SystemExit(f"live.yaml does not state '{old}'")
            cell = cell.replace(old, new)
        (self.cell / "small.yaml").write_text(cell)

    def servo(self, cell, targets, out):
        """Returns how often the program was started until all targets were tried."""
        for attempt in range(ATTEMPTS):
            self.served.type("arm marks")
            answer = self.served.next([r"the arm .*\n"], 10)
            if answer is None or "stands" not in answer.group():
                raise SystemExit(f"the arm is not put at its marks: {self.served.heard[-500:]}")
            self.run("planar-servo", "-q", "--cell", f"cell/{cell}.yaml", "--targets", f"{targets}.csv", "--out", out,
                     "--at-marks", *(["--resume"] if attempt else []))
            tried = {row["target"] for row in rows(self.out / out / "results.csv")}
            if len(tried) == len(rows(self.out / f"{targets}.csv")):
                return attempt + 1
        raise SystemExit(f"planar-servo has not tried all of {targets}.csv")

    def end(self):
        self.tap.kill()
        self.tap.wait()
        self.served.process.terminate()
        self.served.end()

    def true_errors_mm(self, run):
        """Returns the distances from each target to the true end point at the last look."""
        truth = [(float(r["t_s"]), float(r["x_mm"]), float(r["y_mm"])) for r in rows(self.out / "truth.csv")]
        looks = {step["target"]: float(step["t_s"]) for step in rows(self.out / run / "steps.csv")}
        errors = []
        for target in rows(self.out / "circles.csv"):
            _, x, y = truth[bisect.bisect_right(truth, (looks[target["id"]], math.inf)) - 1]
            errors.append(math.hypot(x - float(target["x_mm"]), y - float(target["y_mm"])))
        return errors

    def exposure_to_command_ms(self, run):
        """Returns the times from each exposure that was corrected to the next move on the line."""
        moves = [float(m.group(1)) for line in open(self.out / "wire.log")
                 if (m := re.match(r"([0-9.]+) > .*\$J=", line))]
        times, before = [], None
        for step in rows(self.out / run / "steps.csv"):
            if before is not None and step["target"] == before["target"]:
                exposed = float(before["t_s"])
                times.append(1e3 * (moves[bisect.bisect_right(moves, exposed)] - exposed))
            before = step
        return sorted(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("firmware", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--every", type=int, default=1, help="of the 100 targets take every N-th")
    bench = Bench(parser.parse_args())
    bench.calibrate()
    bench.run("planar-servo", "-q", "--cell", "cell/cell.yaml", "--targets", "circles.csv", "--out", "in_process",
              "--json", "in_process.json")
    in_process = json.loads((bench.out / "in_process.json").read_text())["after_mean_mm_truth"]
    print(f"in process: mean true error {in_process:.4f} mm", flush=True)
    bench.serve()
    try:
        starts = bench.servo("live", "circles", "served")
        errors = bench.true_errors_mm("served")
        scatter = statistics.stdev(errors)
        print(f"served: mean true error of {len(errors)} targets {statistics.mean(errors):.4f} mm, scatter "
              f"{scatter:.4f} mm, of the mean {scatter / math.sqrt(len(errors)):.4f} mm; started {starts} times",
              flush=True)
        starts = bench.servo("small", "small", "small_run")
        times = bench.exposure_to_command_ms("small_run")
        print(f"from exposure to command: {statistics.median(times):.1f} ms median, "
              f"{times[int(0.99 * len(times))]:.1f} ms at 99 % of {len(times)} corrections; started {starts} times")
    finally:
        bench.end()


if __name__ == "__main__":
    main()
