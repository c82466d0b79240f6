#!/usr/bin/env python3
"""Works a virtual cell through the page of planar-console in headless Chromium.

console.py PLANAR_CONSOLE CELL_FOLDER PICTURES  exit status 1 for a claim that does not hold, a rule of
                                                bench/report/rules.js that the page breaks, or a message on the
                                                browser's console; keeps pictures of the page in the folder PICTURES
"""
import contextlib
import os
import re
import shutil
import signal
import sys
import tempfile
import time

from api import Api
from claims import IDLE, Console, answer_question, check_messages, check_page, claim, enable, open_page, spiral
from webdriver import Browser, Driver

TARGETS = 20
FIRST_PICTURE_S = 1.0
COMMAND_MS = 50
STOP_S = 0.3    # from the last word of a page to the stop, by the interface
RAMP_S = 0.6    # in which the arm comes to rest from full speed, and the state tells so
FARTHEST = 'input[name=step][value="50"]'
FARTHEST_DEG = 15
UNCHECKED = ("health: health.yaml", "")  # the check of a cell takes longer than all of this
SLOW = ("max_speed_deg_s: 60", "max_speed_deg_s: 10")
TYPED = ("tracker: {", "tracker: {source: ask, ")
MONUMENTS = (("datum1", -450, -450), ("datum2", 450, 450), ("datum3", -450, 450))
KEPT_DEG = 4  # takes longer on a slow cell than the console waits for a page
# Holds requests to a path up: all of them, or the first one for so many milliseconds.
HOLD_UP = """const [held, wait_ms] = arguments, real = fetch;
    Object.assign(window, {heldUp: 0, calledBack: 0, letGo: () => { window.fetch = real; }});
    window.fetch = (path, how) => !path.startsWith(held) || wait_ms && heldUp ? real(path, how) : new Promise((go, no) => {
        ++window.heldUp;
        if (how.signal) how.signal.addEventListener("abort", () => no(++window.calledBack));
        if (wait_ms) setTimeout(() => go(real(path, how)), wait_ms);
    })"""
JOGS = "return performance.getEntriesByName(location.origin + '/api/jog').map(entry => entry.duration)"


def jog(page, console):
    enable(page)
    before = console.tip()
    page.click("[data-jog='x -']")
    console.wait_for(lambda state: abs(state["arm"]["tip_mm"][0] - before[0] + 1.0) < 0.01)
    claim("a tap on x minus moves the end point by one step of 1 mm", True)
    page.wait(IDLE)
    page.run("performance.setResourceTimingBufferSize(5000)")
    page.run("document.querySelector('#jog').focus()")
    page.key("up")
    page.key("up", down=False)
    console.wait_for(lambda state: abs(state["arm"]["tip_mm"][1] - before[1] - 1.0) < 0.01)
    claim("the key up moves it by one step along y", True)
    page.wait(IDLE)
    delay = page.run(JOGS)
    claim("a key becomes a command soon", delay[-1] < COMMAND_MS, f"{delay[-1]:.0f} ms")
    page.run(f"document.querySelector('{FARTHEST}').click()")
    begin = console.turned()
    page.press("[data-jog='joint 1 -']")
    console.wait_for(lambda state: begin - state["arm"]["joints_deg"][0] > FARTHEST_DEG + 3)
    page.release()
    console.wait_for(lambda state: state["doing"] == "idle")
    turned = begin - console.turned()
    time.sleep(0.5)
    claim("while a button is held steps follow one another, and end when it is let go",
          turned < 2 * FARTHEST_DEG - 0.1 and begin - console.turned() == turned and len(page.run(JOGS)) == len(delay) + 2,
          f"{turned:.1f} degrees")


def stop_between_steps(page, console):
    """Somebody else stops the cell while a held button is between two steps, where nothing is under way."""
    page.run("document.querySelector('input[name=step][value=\"1\"]').click()")
    for _ in range(10):
        begin = console.tip()
        page.press("[data-jog='x +']")
        console.wait_for(lambda state: state["arm"]["tip_mm"][0] - begin[0] > 1.5)
        console.wait_for(lambda state: state["doing"] == "idle")
        between = not console.ask("/api/stop", {})["stopped"]
        time.sleep(0.2 if between else 0)
        at = console.tip()
        time.sleep(1.0 if between else 0)
        rests = console.tip() == at
        page.release()
        page.wait(IDLE)
        if between:
            claim("after a stop of anybody no step of a button that is still held begins", rests)
            claim("it is refused, which the browser's console says, too", all("409" in one for one in page.messages()))
            page.click("#notice-close")
            return
    claim("a stop comes between two steps", False)


def teach(page):
    page.click("#edit summary")
    page.write("#csv", "id,x_mm,y_mm\nnot sent yet")
    page.write("#teach-id", "here")
    page.click("#teach-form button")
    page.wait("[...document.querySelectorAll('#target-rows th')].some(head => head.textContent === 'here')")
    claim("a taught place stands in the table of targets", True)
    claim("and what somebody writes beside it stays", page.run("return document.querySelector('#csv').value").endswith("not sent yet"))
    page.click("#edit summary")


def choose_place(page, console):
    page.wait(IDLE)
    before = console.tip()
    page.click("#field-view", 60, -80)
    page.wait("!document.querySelector('#go').disabled")
    text = page.text("#place")
    claim("a place that is clicked is examined and nothing moves", "can be reached" in text and "mm per axis" in text
          and console.tip() == before, text)
    page.click("#go")
    page.wait("document.querySelector('#progress-text').textContent.includes('reached')", 15)
    claim("'Go there' goes there", True, page.text("#progress-text"))
    page.run(HOLD_UP, "api/place", 1000)
    page.click("#field-view", 60, -80)
    page.click("#field-view", 40, -80)
    page.wait("!document.querySelector('#go').disabled")
    text = page.text("#place")
    time.sleep(1.5)
    page.run("letGo()")
    claim("an answer about a place chosen before tells nothing any more", page.text("#place") == text, text)
    page.write("#place-phi", "9o")
    page.click("#place-form button")
    claim("a direction that is no number is not taken for any", "φ in degrees" in page.text("#place")
          and page.run("return document.querySelector('#go').disabled"), page.text("#place"))
    page.write("#place-phi", "")


def run_targets(page, console, pictures):
    page.click("#edit summary")
    page.write("#csv", "id,x_mm,y_mm\nA,oops,1\n")
    page.click("#targets-form button")
    page.wait("document.querySelector('#notice').hidden === false")
    claim("a wrong line is refused by name", "oops" in page.text("#notice"), page.text("#notice-fault"))
    claim("and the browser's console says no more than that", all("400" in one for one in page.messages()))
    page.write("#csv", spiral(TARGETS))
    page.click("#targets-form button")
    page.wait(f"document.querySelectorAll('#target-rows tr').length === {TARGETS}")
    page.write("#run-name", "first")
    page.click("#run")
    page.wait("document.querySelectorAll('#target-rows tr.reached').length >= 3", 30)
    page.click("#stop")
    page.wait(IDLE)
    done = console.state()["job"]["done"]
    claim("the stop button ends a run in the middle of a move", 3 <= done < TARGETS, f"{done} of {TARGETS} done")
    check_page(page, pictures, "stopped")
    page.click("#resume")
    page.click("#run")
    page.wait(f"document.querySelectorAll('#target-rows tr.reached').length === {TARGETS}", 60)
    page.wait(IDLE)
    claim(f"a resumed run reaches all of {TARGETS} targets", True)
    check_page(page, pictures, "field")
    page.click("#edit summary")
    page.write("#csv", spiral(TARGETS).replace("S1,250.000", "S1,251.000"))
    page.click("#targets-form button")
    page.wait("document.querySelector('#targets-count').textContent.startsWith('19 of')")
    claim("a target that is moved is no longer reached", page.run("return document.querySelector('#target-rows tr').className") == "planned")


def follow_path(page, pictures):
    page.click("#path-edit summary")
    page.write("#path-csv", "x_mm,y_mm,via_x_mm,via_y_mm\n300,100,,\n300,140,320,120\n")
    page.click("#path-form button")
    page.wait("document.querySelectorAll('#field-view .path').length === 2")
    claim("a path that is kept is drawn in the field", True, page.text("#path-length"))
    page.write("#path-name", "path")
    page.write("#path-speed", "50")
    page.click("#follow")
    page.wait("document.querySelectorAll('#path-rows tr.reached').length === 1", 30)
    page.wait(IDLE)
    claim("it is followed, and how far off is told", "reached" in page.text("#path-rows"), page.text("#progress-text"))
    page.wait("document.querySelector('#reports').textContent.includes('path/report.html')")
    check_page(page, pictures, "path")


def certify(page, pictures):
    for id, value in (("certificate-name", "proof"), ("cycles", "2"), ("certified-targets", "1")):
        page.write(f"#{id}", value)
    claim("a certificate says how many moves it takes", page.text("#certificate-size").startswith("35 moves"))
    page.click("#certificate-form button")
    page.wait("document.querySelector('#progress-text').textContent.startsWith('2 of 35')", 30)
    claim("its progress is told", "left" in page.text("#progress-text"), page.text("#progress-text"))
    check_page(page, pictures, "certificate")
    page.key("escape")
    page.key("escape", down=False)
    page.wait(IDLE)
    claim("Esc ends it", "stopped as asked" in page.text("#progress-text"), page.text("#progress-text"))


def name_options(page):
    """A message that names options of a program names what does the same on the page."""
    plain = "return import('./dom.js').then(({plain}) => plain(arguments[0]))"
    said = page.run(plain, "continue with --resume, or run planar-record --out there --home")
    claim("a message names what is on the page, and a whole command as it is",
          said == "continue with “resume what is there”, or run planar-record --out there --home", said)
    labels = re.findall("“(.*?)”", page.run(plain, "--resume --out --grid --cycles --targets --at-marks"))
    words = page.text("body")
    claim("all that is named so stands on the page", len(labels) == 6 and all(label in words for label in labels), labels)


def check_api(console):
    faults = Api(console.origin, console.token["operate"]).faults()
    claim("the API answers as openapi.json describes it", not faults, "; ".join(sorted(set(faults))))


def second_browser(driver, page, console, pictures):
    with Browser(driver) as other:
        open_page(other, console)
        other.wait("document.querySelector('#operator-text').textContent.includes('Another page')")
        claim("a second page sees that another one moves the cell, and may not", other.run(
            "return [...document.querySelectorAll('.act')].every(control => control.disabled)"))
        other.click("#take")
        claim("taking over takes a second press", "Stop and" in other.text("#take"))
        other.click("#take")
        other.wait("document.querySelector('#operator-text').textContent.startsWith('You')")
        page.wait("document.querySelector('#operator-text').textContent.includes('Another page')")
        claim("the first page sees that it was taken over", True)
        check_messages(other)
    page.wait(IDLE)


def doubt_key(page, console):
    """A held key whose end the page cannot have seen for certain ends its motion."""
    hold = """const panel = document.querySelector("#jog"); panel.focus();
              panel.dispatchEvent(new KeyboardEvent("keydown", {key: "q", code: "KeyQ", bubbles: true}))"""
    tell = """document.querySelector("#jog").dispatchEvent(
              new KeyboardEvent(arguments[0], {key: arguments[1], code: arguments[2], bubbles: true}))"""
    page.run(HOLD_UP, "api/jog/keep")
    page.run(hold)
    console.wait_for(lambda state: state["doing"] == "moving")
    console.wait_for(lambda state: state["doing"] == "idle")
    page.run(tell, "keyup", "q", "KeyQ")
    claim("a page asks no more while the console answers nothing, so that a stop need not wait", page.run("return heldUp") <= 2)
    page.run("letGo()")
    page.wait(IDLE)
    doubts = (("goes up as another letter", ("keyup", "@", "KeyQ")), ("is lost for one that goes up", ("keyup", "x", "KeyX")),
              ("is held while a modifier goes down", ("keydown", "AltGraph", "AltRight")), ("does not repeat", None))
    for words, event in doubts:
        begin = console.turned()
        page.run(hold)
        console.wait_for(lambda state: state["arm"]["joints_deg"][0] - begin > KEPT_DEG)
        if event:
            page.run(tell, *event)
        console.wait_for(lambda state: state["doing"] == "idle")
        turned = console.turned() - begin
        claim(f"a motion ends when its key {words}", turned < FARTHEST_DEG - (1 if event is None else 4),
              f"after {turned:.1f} of {FARTHEST_DEG} degrees")


def lose_page(driver, console):
    """The page loses the focus, and then is killed, while it holds a motion that would last for some time."""
    with Browser(driver) as page:
        open_page(page, console)
        check_api(console)
        enable(page)
        page.run(f"document.querySelector('{FARTHEST}').click()")
        doubt_key(page, console)
        page.wait(IDLE)
        begin = console.turned()
        page.run("document.querySelector(\"[data-jog='joint 1 -']\").focus()")
        page.key(" ")
        page.key(" ", down=False)
        console.wait_for(lambda state: begin - state["arm"]["joints_deg"][0] > KEPT_DEG)
        page.run("dispatchEvent(new Event('blur'))")
        console.wait_for(lambda state: state["doing"] == "idle")
        claim("a step by the keyboard, too, lasts only while its page is there", begin - console.turned() < FARTHEST_DEG - 4)
        page.wait(IDLE)
        begin = console.turned()
        page.press("[data-jog='joint 1 -']")
        page.run("document.querySelector(\"[data-jog='joint 1 -']\").dispatchEvent(new PointerEvent('pointercancel'))")
        time.sleep(0.5)
        console.wait_for(lambda state: state["doing"] == "idle")
        page.release()
        claim("a touch that the browser takes away is no tap", begin - console.turned() < FARTHEST_DEG - 4)
        for words, lose in (("loses the focus", lambda: page.run("dispatchEvent(new Event('blur'))")),
                            ("is killed", page.crash)):
            begin, motions = console.turned(), len(page.run(JOGS))
            page.release()
            page.press("[data-jog='joint 1 +']")
            console.wait_for(lambda state: state["arm"]["joints_deg"][0] - begin > KEPT_DEG)
            claim("a motion lasts while its button is held", len(page.run(JOGS)) == motions + 1)
            lose()
            taken = console.wait_for(lambda state: state["doing"] == "idle")
            turned = console.turned() - begin
            claim(f"an arm whose page {words} comes to rest", turned < FARTHEST_DEG - 4 and taken < STOP_S + RAMP_S,
                  f"after {taken:.2f} s and {turned:.1f} of {FARTHEST_DEG} degrees")


def other_rights(driver, console, pictures):
    with Browser(driver) as reader:
        open_page(reader, console, "look on")
        reader.wait("document.querySelector('#operator-text').textContent.startsWith('You read')")
        claim("who may only read has no control that moves", reader.run(
            "return [...document.querySelectorAll('.act')].every(control => control.disabled)"))
        check_messages(reader)
    with Browser(driver, 600, 400) as stranger:
        stranger.open(console.address["look on"][:-4] + "0000")
        said = stranger.text("body").strip()
        claim("a wrong token shows a sentence and nothing else", "address" in said and len(said) < 300, said)
        stranger.picture(os.path.join(pictures, "wrong_token.png"))


def silence(page, console):
    """A console that answers nothing is not shown as it was, and what it has not got yet it does not get later."""
    page.wait("!document.querySelector('#check').disabled")
    page.run(HOLD_UP, "api/check")
    page.click("#check")
    console.process.send_signal(signal.SIGSTOP)
    try:
        page.wait("document.body.classList.contains('lost')", 6)
        page.wait("document.querySelector('#state-text').textContent.includes('does not answer')", 6)
        claim("a page that hears nothing says so, and no control moves", page.run(
            "return [...document.querySelectorAll('.act')].every(control => control.disabled)"), page.text("#state-text"))
        claim("an order that is still on its way is called back", page.run("return heldUp === 1 && calledBack === 1"))
    finally:
        console.process.send_signal(signal.SIGCONT)
    page.wait(f"!document.body.classList.contains('lost') && {IDLE}", 15)
    claim("and it goes on once the console answers", True)
    page.messages()


def read_report(page, console, folder):
    name = "run #1 of 100%25.html"
    with open(os.path.join(folder, name), "w", encoding="utf-8") as report:
        report.write("<p>how it went</p>")
    page.open(console.address["operate"])
    page.wait("document.querySelector('#reports a')")
    page.open(page.run("return [...document.querySelectorAll('#reports a')].find(a => a.textContent === arguments[0]).href", name))
    claim("a report of any name is opened", "how it went" in page.text("body"), name)
    page.open(console.address["operate"])


def many_pages(driver, console):
    """A browser has six connections to a host, and each page that is seen keeps one for its events."""
    with Browser(driver) as browser:
        open_page(browser, console)
        for _ in range(7):
            browser.add_page("tab")
            open_page(browser, console)
        claim("of eight tabs the one that is seen shows state and picture", True)
        for _ in range(5):
            browser.add_page("window")
            browser.open(console.address["operate"])
            browser.wait(IDLE, 30)
        browser.turn_to(browser.first_page())
        browser.wait(IDLE, 30)
        stops = console.state()["stops"]
        browser.click("#stop")
        taken = console.wait_for(lambda state: state["stops"] > stops, 3)
        claim("of six windows that are seen each can stop", True, f"after {taken:.2f} s")


def record(driver, console, pictures):
    """A person types the readings of a tracker. Those of the monuments are what the cell file says."""
    with Browser(driver) as page:
        open_page(page, console)
        enable(page)
        page.click("#record-form button")
        for id, x, y in MONUMENTS:
            answer_question(page, f"'{id}'", f"{x},{y},0")
        answer_question(page, "back on the tool")
        page.wait("document.querySelector('#person-text').textContent.includes(\"'t1'\")")
        claim("a recording asks in large letters, beside the monuments that were read",
              page.run("return document.querySelectorAll('#monuments li').length") == len(MONUMENTS),
              page.text("#person-text"))
        check_page(page, pictures, "recording")
        page.key("escape")
        page.key("escape", down=False)
        page.wait(IDLE)
        claim("Esc ends a recording while it asks", page.run("return document.querySelector('#person').hidden"),
              console.state()["job"]["ended"])
        check_messages(page)


@contextlib.contextmanager
def copy_of(cell, old, new):
    """A copy of a cell's folder; its cell file with a new text in the place of an old one."""
    with tempfile.TemporaryDirectory() as parent:
        folder = shutil.copytree(cell, os.path.join(parent, os.path.basename(os.path.normpath(cell))))
        file = os.path.join(folder, "cell.yaml")
        with open(file, encoding="utf-8") as source:
            text = source.read()
        with open(file, "w", encoding="utf-8") as changed:
            changed.write(text.replace(old, new))
        yield file


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    program, cell, pictures = sys.argv[1:]
    os.makedirs(pictures, exist_ok=True)
    with Driver() as driver:
        with copy_of(cell, *UNCHECKED) as file, Console(program, file) as console, Browser(driver) as page:
            taken = min(open_page(page, console) for _ in range(3))  # the machine may be busy
            claim(f"a picture is there within {FIRST_PICTURE_S} s", taken < FIRST_PICTURE_S, f"{taken:.2f} s")
            jog(page, console)
            stop_between_steps(page, console)
            teach(page)
            choose_place(page, console)
            run_targets(page, console, pictures)
            follow_path(page, pictures)
            certify(page, pictures)
            name_options(page)
            second_browser(driver, page, console, pictures)
            other_rights(driver, console, pictures)
            check_messages(page)
            many_pages(driver, console)
            silence(page, console)
            read_report(page, console, os.path.dirname(file))
            check_messages(page)
        with copy_of(cell, *TYPED) as file, Console(program, file) as console:
            with open(os.path.join(os.path.dirname(file), "plan.csv"), "w", encoding="utf-8") as plan:
                plan.write("id,plan,x_mm,y_mm,phi_deg\nt1,train,300,100,0\n")
            record(driver, console, pictures)
        with copy_of(cell, *SLOW) as file, Console(program, file) as console:
            lose_page(driver, console)


if __name__ == "__main__":
    main()
