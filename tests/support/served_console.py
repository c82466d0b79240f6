"""A planar-console on a port of its own, for tests and benchmarks in Python."""
import re
import signal
import subprocess


class ServedConsole:
    """A running planar-console: what it printed, its addresses by their words, its origin and tokens."""

    def __init__(self, program, cell):
        self.process = subprocess.Popen([program, "--cell", cell, "--port", "0"], stdout=subprocess.PIPE, text=True)
        self.printed = [self.process.stdout.readline() for _ in range(3)]
        self.address = dict(re.match(r"to (.*): (http://\S+)", line).groups() for line in self.printed[:2])
        self.origin = self.address["operate"].split("/?")[0]
        self.token = {right: address.split("=")[1] for right, address in self.address.items()}

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
