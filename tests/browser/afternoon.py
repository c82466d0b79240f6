#!/usr/bin/env python3
"""Does the afternoon of doc/afternoon.md on a served cell, by the page of planar-console alone.

afternoon.py BIN_DIR CELL_FOLDER PICTURES  serves the virtual cell, forgets its calibration, and works it in headless
                                           Chromium; exit status 1 for a claim that does not hold. Keeps pictures.
"""
import math
import os
import shutil
import sys
import tempfile
import time

from claims import IDLE, Console, answer_question, check_messages, check_page, claim, enable, open_page
from served_cell import ServedCell
from webdriver import Browser, Driver

BOARD = "circles:11x11:25mm"
RAMP_S = 1.0  # in which the arm is at rest
HELD, PLACES, TARGETS = 5, 16, 20
STEPS = ("camera", "lamps", "pairs", "error map", "found arm")
MONUMENTS = ("datum1", "datum2", "datum3")
PERSON = "document.querySelector('#person-text').textContent"
LINES = "document.querySelector('#lines').textContent"
REACHED = "document.querySelectorAll('#target-rows tr.reached').length"
NEXT = "document.querySelector('#next-text').textContent"
JOB = "document.querySelector('#progress-text').textContent"


def spiral(count, inner, outer, turn):
    for i in range(count):
        r = math.sqrt(inner**2 + (outer**2 - inner**2) * (i + 0.5) / count)
        yield f"{r * math.cos(0.6 * i + turn):.3f},{r * math.sin(0.6 * i + turn):.3f}"


def short_plan():
    rows = [f"turn_{i},sweep3,0,150,{60 * i - 150}" for i in range(6)]
    rows += [f"train_{i},train,{place},0" for i, place in enumerate(spiral(PLACES, 80, 225, 0))]
    rows += [f"held_{i},grid,,," for i in range(HELD)] + ["laid,plane_grid,,,", "last,pose,150,100,90"]
    return "\n".join(["id,plan,x_mm,y_mm,phi_deg", *rows]) + "\n"


def hurry(cell):
    """Lets the motors turn faster, and one look at a lamp do."""
    with open(cell, encoding="utf-8") as file:
        text = file.read()
    for old, new in (("max_speed_deg_s: 60, max_acceleration_deg_s2: 400", "max_speed_deg_s: 180, max_acceleration_deg_s2: 1200"),
                     ("max_speed_deg_s: 90, max_acceleration_deg_s2: 600", "max_speed_deg_s: 270, max_acceleration_deg_s2: 1800"),
                     ("frames_per_measurement: 3", "frames_per_measurement: 1")):
        text = text.replace(old, new)
    with open(cell, "w", encoding="utf-8") as file:
        file.write(text)


class Afternoon:
    def __init__(self, page, console, served, folder, pictures):
        self.page, self.console, self.served = page, console, served
        self.folder, self.pictures = folder, pictures

    def look(self, name):
        check_page(self.page, self.pictures, name)

    def home(self):
        enable(self.page)
        self.page.click("[data-line=home]")
        self.console.wait_for(lambda state: state["arm"]["homed"] and state["doing"] == "idle", 60)
        claim("the button homes the arm by its switches", True)

    def do_next(self, step):
        self.page.wait(f"{NEXT}.startsWith('{step}: ')", 20)
        opened = self.console.state()["opened"]
        if step == "camera":
            command = self.page.text("#next-command")
            claim("the command of what is next names the board of the recording", f"--grid {BOARD}" in command, command)
        self.page.write("#step-board", BOARD)
        self.page.click("#step-form button")
        self.console.wait_for(lambda state: state["opened"] > opened, 120)
        self.page.wait(f"!{NEXT}.startsWith('{step}: ') && {JOB}.includes('is done')", 20)
        claim(f"what is next is done: {step}", True, self.page.text("#next-text"))
        check_messages(self.page)

    def plan(self):
        self.look("fresh")
        self.do_next("plan")
        with open(os.path.join(self.folder, "plan.csv"), "w", encoding="utf-8") as plan:
            plan.write(short_plan())

    def read_monuments(self):
        for monument in MONUMENTS:
            self.page.wait(f"{PERSON}.includes(\"'{monument}'\")", 30)
            self.served.do(f"reflector {monument}")
            answer_question(self.page, f"'{monument}'")

    def record(self):
        self.page.write("#board", BOARD)
        self.page.click("#record-form button")
        self.read_monuments()
        self.page.wait(f"{PERSON}.includes('back on the tool')")
        self.served.do("reflector tool")
        self.look("monuments")
        answer_question(self.page, "back on the tool")
        self.page.wait(f"{JOB}.startsWith('8 of')", 60)
        self.look("places")
        self.read_monuments()
        self.show_boards()
        self.page.wait(f"{JOB}.includes('positions recorded')", 30)
        claim("the recording is complete", self.console.state()["job"]["ok"], self.page.text("#progress-text"))

    def show_boards(self):
        for i, shown in enumerate(["hold 0", "hold 2", "hold 4", "hold 5", "hold 6", "lay 0"]):
            view = f"held_{i}" if i < HELD else "laid"
            try:
                self.page.wait(f"{PERSON}.includes('{view}: ') || {PERSON}.includes('is taken; ')", 30)
            except AssertionError as fault:
                raise AssertionError(f"{fault}; the page says: {self.page.text('#person-text')}") from None
            wanted = self.page.text("#person-text")
            self.served.do(f"board {shown}")
            if i == 1:
                claim("what the board is wanted for stands in large letters, above what is seen",
                      "move it" in wanted.split("\n")[0] and "more view" in wanted.split("\n")[1], wanted)
                self.look("held")
            taken = f"{LINES}.includes('{view} is taken')"
            if not self.page.run(f"return {taken}"):  # a view that is wanted is taken by itself
                self.page.click("#person-form .main")
            self.page.wait(taken, 20)
        claim("the page says that each view is taken", True, self.page.text("#person-text"))
        self.page.wait(f"{PERSON}.includes('still in the picture')", 30)
        self.served.do("board remove")
        self.page.wait(f"{PERSON}.includes('is gone')", 30)
        self.page.click("#person-form .main")

    def check(self):
        self.page.click("#check")
        self.page.wait(f"!({IDLE})", 30)
        self.page.wait(IDLE, 300)  # as long as a loaded machine takes
        found = self.page.text("#progress-text")
        claim("the check finds the cell as it was at its calibration", "as it was at its calibration" in found, found)

    def lose_camera(self):
        self.served.do("camera off")
        self.page.wait("!document.querySelector('#doubts').hidden", 30)
        claim("a camera that is lost while nothing moves is a doubt with its remedy",
              "cable and power" in self.page.text("#doubt-list"), self.page.text("#doubt-list"))
        self.look("no_camera")
        self.served.do("camera on")
        self.page.wait("document.querySelector('#doubts').hidden && !document.querySelector('#frame.stale')", 30)
        claim("and none once it is back, with new pictures", True)

    def run(self):
        rows = [f"T{i},{place}" for i, place in enumerate(spiral(TARGETS, 90, 215, 1))]
        self.page.click("#edit summary")
        self.page.write("#csv", "\n".join(["id,x_mm,y_mm", *rows]) + "\n")
        self.page.click("#targets-form button")
        self.page.wait(f"document.querySelectorAll('#target-rows tr').length === {TARGETS}")
        self.page.click("#run")
        self.page.wait(f"{REACHED} >= 5", 60)
        self.served.do("camera off")
        self.page.wait("document.querySelector('#state-text').textContent.startsWith('Waiting for the camera')", 30)
        time.sleep(RAMP_S)
        at = self.console.tip()
        self.look("waits_for_camera")
        claim("targets wait for a camera that is lost, and nothing moves", self.console.tip() == at,
              self.page.text("#state-text"))
        self.served.do("camera on")
        self.page.wait(f"{REACHED} === {TARGETS}", 90)
        claim("and are reached once it is back", True)
        self.page.wait(f"{IDLE} && document.querySelector('#reports a') && {NEXT}.startsWith('certificate: ')", 30)
        claim("the run counts as done, and all files are named relative to the cell's folder",
              self.folder not in self.page.text("body"), self.page.text("#next-command"))
        self.look("ran")

    def read_report(self):
        report = self.page.run("return document.querySelector('#reports a').href")
        self.page.open(report)
        claim("the report of the run is there", f"{TARGETS} of {TARGETS}" in self.page.text("body"), report)


def work(day):
    day.home()
    day.plan()
    day.home()
    day.record()
    for step in STEPS:
        day.do_next(step)
    day.look("calibrated")
    day.home()
    day.check()
    day.lose_camera()
    day.run()
    check_messages(day.page)
    day.read_report()


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    programs, cell, pictures = (os.path.abspath(path) for path in sys.argv[1:])
    os.makedirs(pictures, exist_ok=True)
    with tempfile.TemporaryDirectory() as parent, Driver() as driver:
        hidden, folder = os.path.join(parent, "hidden"), os.path.join(parent, "cell")
        shutil.copytree(cell, hidden)
        hurry(f"{hidden}/cell.yaml")
        os.mkdir(folder)
        live = os.path.join(folder, "cell.yaml")
        with ServedCell(f"{programs}/planar-virtual-cell", f"{hidden}/cell.yaml", live) as served, \
             Console(f"{programs}/planar-console", live) as console, Browser(driver) as page:
            open_page(page, console)
            try:
                work(Afternoon(page, console, served, folder, pictures))
            except AssertionError:
                page.picture(os.path.join(pictures, "failed.png"), whole=True)
                raise


if __name__ == "__main__":
    main()
