"""Works a served cell through planar-console: served_console.py BIN_DIR CELL_FOLDER LIVE_FOLDER."""
import os
import pathlib
import statistics
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from served_cell import DriveWire, ServedCell
from served_console import ServedConsole

BIN, HIDDEN, LIVE = sys.argv[1:]
LOSSES, KEPT, STOP_S, PATIENCE_S = 10, 30, 0.3, 60


def check(holds, what):
    if not holds:
        raise SystemExit(f"FAILED: {what}")


class Console(ServedConsole):
    def command(self, line):
        answer = self.ask("/api/command", {"line": line})
        check(answer["done"], f"{line}: {answer}")


def lose_jog(console, wire, line):
    """Returns the time from the last word of who holds a jog to the halt on the drives' wire."""
    console.ask("/api/jog", {"line": line})
    for _ in range(KEPT):
        before, said_s = len(wire.halts_s), time.monotonic()
        check(console.ask("/api/jog/keep", {})["held"], "the jog has ended before it was lost")
    console.rests()
    read_s = time.monotonic() + 1.0  # by when the wire's reader has what was sent
    while len(wire.halts_s) == before and time.monotonic() < read_s:
        time.sleep(0.01)
    check(len(wire.halts_s) > before, "nothing was sent to the drives")
    return wire.halts_s[before] - said_s


def try_lost_jogs(console, wire):
    delays_s = [lose_jog(console, wire, f"joint 1 {15 if i % 2 else -15}") for i in range(LOSSES)]
    print("from the last word to the halt on the wire:", " ".join(f"{1e3 * delay:.0f}" for delay in delays_s), "ms")
    check(statistics.median(delays_s) < STOP_S, f"the halts came later than {STOP_S} s")  # the machine may be busy


def try_other_programs(console, cell):
    """Its devices obey one program at a time."""
    stands = console.ask("/api/state")["arm"]["joints_deg"]
    for program, *arguments in (("planar-jog",), ("planar-servo", "--targets", "targets.csv", "--out", "run"),
                                ("planar-record", "--plan", "plan.csv", "--out", "recording")):
        done = subprocess.run([f"{BIN}/{program}", "--cell", cell, *arguments], capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=PATIENCE_S)
        check(done.returncode == 1 and "another program" in done.stderr, done)
    check(console.ask("/api/state")["arm"]["joints_deg"] == stands, "the arm has moved")
    console.command("joint 1 1")


def try_end_with_failed_drives(console, wire):
    """It ends as any other."""
    wire.ends = True  # nothing passes any more
    until = time.monotonic() + PATIENCE_S
    while not any(doubt["where"].startswith("drive") for doubt in console.ask("/api/state")["doubts"]):
        check(time.monotonic() < until, "drives that do not answer are no doubt")
        time.sleep(0.1)
    status = console.end()
    check(status == 0, f"it ended with {status}")


def main():
    os.mkdir(LIVE)
    cell, link = f"{LIVE}/cell.yaml", os.path.abspath(f"{LIVE}/drives")
    with ServedCell(f"{BIN}/planar-virtual-cell", f"{HIDDEN}/cell.yaml", cell) as _, \
         DriveWire(f"{HIDDEN}/grbl", link) as wire:
        text = pathlib.Path(cell).read_text(encoding="utf-8")
        pathlib.Path(cell).write_text(text.replace(os.path.abspath(f"{HIDDEN}/grbl"), link), encoding="utf-8")
        with Console(f"{BIN}/planar-console", cell) as console:
            console.command("enable")
            console.command("home")
            try_lost_jogs(console, wire)
            try_other_programs(console, cell)
            try_end_with_failed_drives(console, wire)


main()
