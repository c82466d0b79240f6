"""A planar-console on a port of its own, for tests and benchmarks in Python."""
import json
import re
import signal
import subprocess
import time
import urllib.request


class ServedConsole:
    """A running planar-console: what it printed, its addresses by their words, its origin and tokens."""

    def __init__(self, program, cell, *options):
        self.process = subprocess.Popen([program, "--cell", cell, "--port", "0", *options], stdout=subprocess.PIPE, text=True)
        self.printed = [self.process.stdout.readline() for _ in range(3)]
        self.address = dict(re.match(r"to (.*): (http://\S+)", line).groups() for line in self.printed[:2])
        self.origin = self.address["operate"].split("/?")[0]
        self.token = {right: address.split("=")[1] for right, address in self.address.items()}

    def request(self, path, body=None, timeout=60):
        """Sends what one page orders or asks, and returns the open answer; raises HTTPError for a refusal."""
        headers = {"Authorization": f"Bearer {self.token['operate']}", "X-Planar-Client": "1" * 16,
                   "Content-Type": "application/json"}
        data = None if body is None else json.dumps(body).encode()
        return urllib.request.urlopen(urllib.request.Request(self.origin + path, data, headers), timeout=timeout)

    def ask(self, path, body=None):
        with self.request(path, body) as answer:
            return json.load(answer)

    def rests(self, patience_s=60):
        """Waits until the cell is idle and returns its state."""
        until = time.monotonic() + patience_s
        while (state := self.ask("/api/state"))["doing"] != "idle":
            if time.monotonic() > until:
                raise SystemExit("FAILED: the cell does not come to rest")
            time.sleep(0.02)
        return state

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    def end(self, how=signal.SIGINT):
        """Asks it to end and returns its exit status."""
        self.process.send_signal(how)
        status = self.process.wait(60)
        self.process.stdout.close()
        return status
