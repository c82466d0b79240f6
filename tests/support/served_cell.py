"""A virtual cell that planar-virtual-cell serves as real devices, a person at it, and the wire to its drives."""
import contextlib
import os
import pty
import select
import subprocess
import threading
import time
import tty

HALT = b"\x85"  # Grbl's byte that ends a jog by its ramp


class ServedCell:
    """Serves a virtual cell; `live` becomes the cell file that describes it as a real one."""

    def __init__(self, program, cell, live):
        self.process = subprocess.Popen([program, "serve", "--cell", cell, "--out", live], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        while not (line := self.process.stdout.readline()).startswith("tracker "):
            if not line:
                raise RuntimeError("the cell is not served")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.communicate()

    def do(self, command):
        """Does something by hand, such as `board hold 2`."""
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer or answer.startswith("not understood"):
            raise RuntimeError(f"{command}: {answer}")


class DriveWire:
    """Stands between a program and the serial port of its drives, and notes when a halt is sent, by time.monotonic().
    The program takes `port`, a link, as if it were the drives'."""

    def __init__(self, drives, port):
        self.halts_s = []
        self.drives = os.open(drives, os.O_RDWR | os.O_NOCTTY)
        self.program, self.kept = pty.openpty()  # its other end stays open while no program has it
        for end in (self.drives, self.kept):
            tty.setraw(end)
        os.symlink(os.ttyname(self.kept), port)
        self.ends = False
        self.thread = threading.Thread(target=self._pass_on, daemon=True)
        self.thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.ends = True
        self.thread.join()
        for end in (self.drives, self.program, self.kept):
            os.close(end)

    def _pass_on(self):
        while not self.ends:
            for end in select.select([self.drives, self.program], [], [], 0.1)[0]:
                with contextlib.suppress(OSError):
                    said = os.read(end, 4096)
                    if end == self.program and HALT in said:
                        self.halts_s.append(time.monotonic())
                    os.write(self.drives if end == self.program else self.program, said)
