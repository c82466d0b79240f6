#!/usr/bin/env python3
"""Measures what readers cost a console and its loop, and how soon a jog begins.

    bench/console/load.py BIN_DIR CELL_DIR [--readers N] [--seconds S]

CELL_DIR is a calibrated virtual cell; a copy is worked. Readers fetch each new picture at 5 Hz and follow the
events, as the page does. Prints by how much they lengthen the server's processor time per picture; the time per
target of a run with and without them; and the time from a jog's request to the first state that moves. Exit status 1
beyond the bounds."""

import argparse
import json
import os
import pathlib
import shutil
import statistics
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests/support"))
from served_console import ServedConsole

MOST_PER_PICTURE_MS = 15.0
MOST_LONGER = 0.05
MOST_JOG_MS = 50.0
RATE_HZ = 5.0
PLACES = [(150, 250), (-200, 300), (250, 100), (0, 350), (-300, 50), (100, 400)]


class Served(ServedConsole):
    def processor_s(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def run(self, name):
        """Runs over the targets and returns the seconds of each."""
        self.ask("/api/run", {"out": name, "resume": False})
        while (job := self.ask("/api/state")["job"])["ended"] is None:
            time.sleep(0.2)
        if not job["ok"]:
            sys.exit(f"the run {name} ended: {job['ended']}")
        with self.request("/api/events") as stream:
            rows = []
            for line in stream:
                if line.startswith(b"data: "):
                    row = json.loads(line[6:])
                    if row.get("job") == job["id"]:
                        rows.append(row)
                    if "seq" in row:
                        return [row["seconds"] for row in rows]


class Readers:
    """So many pages that look on."""

    def __init__(self, served, count):
        self.served, self.read, self.going = served, 0, True
        self.threads = [threading.Thread(target=work) for _ in range(count) for work in (self.watch, self.follow)]

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.going = False
        for thread in self.threads:
            thread.join()

    def watch(self):
        while self.going:
            begin = time.monotonic()
            with self.served.request("/api/picture.jpg") as picture:
                picture.read()
            self.read += 1
            time.sleep(max(0.0, 1.0 / RATE_HZ - (time.monotonic() - begin)))

    def follow(self):
        with self.served.request("/api/events") as stream:
            for _ in stream:
                if not self.going:
                    return


def cost(served, readers, seconds):
    """Returns the server's processor milliseconds per picture that it made, and the pictures read."""
    with Readers(served, readers) as reading:
        served.ask("/api/state")  # by which it knows that somebody watches
        time.sleep(1.0)
        begun, first = served.processor_s(), served.ask("/api/state")["picture"]["seq"]
        before = reading.read
        for _ in range(int(seconds)):
            time.sleep(1.0)
            served.ask("/api/state")
        made = served.ask("/api/state")["picture"]["seq"] - first
        return 1e3 * (served.processor_s() - begun) / made, made, reading.read - before


def jog_ms(served):
    begin = time.monotonic()
    served.ask("/api/jog", {"line": "joint 1 0.5"})
    while served.ask("/api/state")["doing"] == "idle":
        time.sleep(0.001)  # more than 1,000 requests a second are refused
    moving = time.monotonic() - begin
    while served.ask("/api/state")["doing"] != "idle":
        served.ask("/api/jog/keep", {})
        time.sleep(0.01)
    return 1e3 * moving


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("cell", type=pathlib.Path)
    parser.add_argument("--readers", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        cell = pathlib.Path(shutil.copytree(options.cell, pathlib.Path(folder) / "cell"))
        with Served(options.bin / "planar-console", cell / "cell.yaml") as served:
            return measure(served, options)


def measure(served, options):
    served.ask("/api/command", {"line": "enable"})
    jogs = [jog_ms(served) for _ in range(9)]
    alone, made, _ = cost(served, 0, options.seconds)
    print(f"no reader: {alone:.1f} ms of processor per picture, the virtual camera's included ({made} made)")
    watched, made, read = cost(served, options.readers, options.seconds)
    print(f"{options.readers} readers: {watched - alone:.1f} ms more per picture ({made} made, {read} read); "
          f"{MOST_PER_PICTURE_MS} are allowed")
    print(f"from a jog's request to the state that moves: {statistics.median(jogs):.1f} ms median; {MOST_JOG_MS} are allowed")
    served.ask("/api/targets", {"csv": "id,x_mm,y_mm\n" + "".join(f"t{i},{x},{y}\n" for i, (x, y) in enumerate(PLACES))})
    served.run("first")  # which checks the cell
    quiet = statistics.median(served.run("quiet"))
    with Readers(served, options.readers):
        busy = statistics.median(served.run("busy"))
    print(f"time per target: {quiet:.3f} s without readers, {busy:.3f} s with {options.readers}, "
          f"{busy / quiet:.3f} times; {1 + MOST_LONGER} are allowed")
    return watched - alone > MOST_PER_PICTURE_MS or busy > (1 + MOST_LONGER) * quiet or statistics.median(jogs) > MOST_JOG_MS


if __name__ == "__main__":
    sys.exit(main())
