"""What the tests of planar-console's page have in common: a console, claims about its page, and what a person does."""
import contextlib
import json
import math
import os
import sys
import time
import urllib.request

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../support"))
from served_console import ServedConsole

RULES = os.path.join(HERE, "../../bench/report/rules.js")
IDLE = "document.querySelector('#lamp').dataset.doing === 'idle'"


class Console(ServedConsole):
    """A planar-console, and its answers to whoever may look on."""

    def state(self):
        headers = {"Authorization": f"Bearer {self.token['look on']}"}
        request = urllib.request.Request(f"{self.origin}/api/state", headers=headers)
        with urllib.request.urlopen(request, timeout=5) as answer:
            return json.load(answer)

    def tip(self):
        return self.state()["arm"]["tip_mm"]

    def turned(self):
        return self.state()["arm"]["joints_deg"][0]

    def wait_for(self, condition, seconds=5.0):
        begin = time.monotonic()
        while time.monotonic() - begin < seconds:
            with contextlib.suppress(OSError):  # silent while it reads the cell's files anew
                if condition(self.state()):
                    return time.monotonic() - begin
            time.sleep(0.01)
        raise AssertionError(f"not within {seconds} s: {self.state()}")


def claim(words, holds, found=""):
    print(f"{'ok' if holds else 'FAILED'}: {words}{f' ({found})' if found != '' else ''}", flush=True)
    if not holds:
        raise AssertionError(words)


def spiral(count):
    places = [(250 + 10 * i, 0.1 * i) for i in range(count)]
    return "id,x_mm,y_mm\n" + "".join(
        f"S{i + 1},{r * math.cos(a):.3f},{r * math.sin(a):.3f}\n" for i, (r, a) in enumerate(places))


def check_page(page, pictures, name):
    """Checks the page as it stands by the rules for every page, light and dark, and keeps its pictures."""
    with open(RULES, encoding="utf-8") as file:
        rules = file.read()
    for scheme in ("light", "dark"):
        page.prefer(scheme)
        for width, height in ((1600, 1000), (390, 844)):
            page.resize(width, height)
            page.run("scrollTo(0, 0)")
            page.picture(os.path.join(pictures, f"{name}_{width}_{scheme}.png"), whole=True)
        page.resize(1600, 1000)
        page.key("tab")  # the focus is shown to those who use keys
        page.key("tab", down=False)
        faults = page.run(rules + "; return faultsOfPage()")
        claim(f"{name}, {scheme}: the page keeps the rules of every page", not faults, "; ".join(faults))
    page.prefer("light")


def open_page(page, console, right="operate"):
    begin = time.monotonic()
    page.open(console.address[right])
    page.wait("document.querySelector('#whole') && document.querySelector('#whole').naturalWidth > 0")
    taken = time.monotonic() - begin
    page.wait("!document.querySelector('#take').dataset.mine || true")
    return taken


def enable(page):
    page.click("[data-line=enable]")
    page.wait("document.querySelector('#answer').textContent.includes('drives are on')")
    page.wait(IDLE)


def answer_question(page, about, text=""):
    """Waits for a question and answers it by Enter, with a reading where one is given."""
    page.wait(f"document.querySelector('#person-text').textContent.includes({json.dumps(about)})")
    if text:
        page.write("#reading", text)
    page.click("#person-form .main")


def check_messages(page):
    messages = page.messages()
    claim("the browser's console shows no message", not messages, "; ".join(messages))
