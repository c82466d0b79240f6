"""Chromium in headless form, by the WebDriver protocol that chromedriver speaks over HTTP [W3C WebDriver]."""
import base64
import json
import re
import subprocess
import time
import urllib.error
import urllib.request

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key of an element's name in the protocol
ARGUMENTS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync",
             "--disable-background-networking", "--disable-component-update", "--hide-scrollbars"]
KEYS = {"up": "\ue013", "left": "\ue012", "right": "\ue014", "escape": "\ue00c", "tab": "\ue004"}


class Driver:
    """A chromedriver process, which opens browsers."""

    def __init__(self):
        self.process = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, text=True)
        for line in self.process.stdout:
            if found := re.search(r"started successfully on port (\d+)", line):
                self.address = f"http://127.0.0.1:{found.group(1)}"
                return
        raise RuntimeError("chromedriver does not start")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


class Browser:
    """A browser with a profile of its own."""

    def __init__(self, driver, width=1500, height=1000):
        self.address = driver.address
        options = {"args": [*ARGUMENTS, f"--window-size={width},{height}"]}
        answer = self._post("/session", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}})
        self.session = f"/session/{answer['sessionId']}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._request("DELETE", self.session)

    def crash(self):
        """Kills the page's process, so that the page can do nothing more."""
        try:
            self._post(f"{self.session}/goog/cdp/execute", {"cmd": "Page.crash", "params": {}})
        except RuntimeError:
            pass  # the answer that the page does not give any more

    def _request(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.address + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60) as response:
                return json.load(response)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(f"{path}: {json.load(error)['value']['message']}") from error

    def _post(self, path, body):
        return self._request("POST", path, body)

    def open(self, address):
        self._post(f"{self.session}/url", {"url": address})

    def add_page(self, kind):
        """Opens another "tab" or "window", turns to it, and returns its name."""
        name = self._post(f"{self.session}/window/new", {"type": kind})["handle"]
        self.turn_to(name)
        return name

    def turn_to(self, page):
        """Lets all that follows happen in this page, which is seen then."""
        self._post(f"{self.session}/window", {"handle": page})

    def first_page(self):
        return self._request("GET", f"{self.session}/window/handles")[0]

    def run(self, script, *arguments):
        """Returns what the body of a function returns in the page."""
        return self._post(f"{self.session}/execute/sync", {"script": script, "args": list(arguments)})

    def text(self, selector):
        return self.run("return document.querySelector(arguments[0]).textContent", selector)

    def wait(self, condition, seconds=10.0):
        """Waits until a JavaScript expression is true, and returns its value and how long that took."""
        begin = time.monotonic()
        while True:
            value = self.run(f"return {condition}")
            taken = time.monotonic() - begin
            if value:
                return value, taken
            if taken > seconds:
                raise AssertionError(f"not within {seconds} s: {condition}")
            time.sleep(0.02)

    def _act(self, *steps, kind="pointer"):
        source = {"type": kind, "id": kind, "actions": list(steps)}
        if kind == "pointer":
            source["parameters"] = {"pointerType": "mouse"}
        self._post(f"{self.session}/actions", {"actions": [source]})

    def _element(self, selector):
        return self._post(f"{self.session}/element", {"using": "css selector", "value": selector})

    def press(self, selector, x=0, y=0):
        """Presses the mouse's button on an element that is enabled, at a distance in pixels from its middle."""
        self.wait(f"!document.querySelector({json.dumps(selector)})?.disabled")
        element = self._element(selector)
        place, before = None, ""
        while place != before:  # what the page still learns of the cell moves what it shows
            before, place = place, self.run("arguments[0].scrollIntoView({block: 'center'}); "
                                            "return JSON.stringify(arguments[0].getBoundingClientRect())", element)
            time.sleep(0.1)
        self._act({"type": "pointerMove", "origin": element, "x": x, "y": y, "duration": 0},
                  {"type": "pointerDown", "button": 0})

    def release(self):
        self._act({"type": "pointerUp", "button": 0})

    def click(self, selector, x=0, y=0):
        self.press(selector, x, y)
        self.release()

    def write(self, selector, text):
        """Puts a text in the place of an input's own."""
        element = self._element(selector)[ELEMENT]
        self._post(f"{self.session}/element/{element}/clear", {})
        self._post(f"{self.session}/element/{element}/value", {"text": text})

    def key(self, name, down=True):
        self._act({"type": "keyDown" if down else "keyUp", "value": KEYS.get(name, name)}, kind="key")

    def developer(self, command, **arguments):
        return self._post(f"{self.session}/goog/cdp/execute", {"cmd": command, "params": arguments})

    def resize(self, width, height):
        self.developer("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def prefer(self, scheme):
        self.developer("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def picture(self, file, whole=False):
        found = self.developer("Page.captureScreenshot", captureBeyondViewport=whole)
        with open(file, "wb") as out:
            out.write(base64.b64decode(found["data"]))

    def messages(self):
        """Returns what the browser's console has shown since the last call."""
        return [entry["message"] for entry in self._post(f"{self.session}/se/log", {"type": "browser"})]
