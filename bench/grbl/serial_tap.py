#!/usr/bin/env python3
"""serial_tap.py PORT NAME LOG: carries a serial port to a pseudo-terminal NAME, and appends to LOG when each byte of
either side has passed: seconds of the computer's steady clock, > for the board or < for the program, the bytes."""

import os
import pty
import select
import sys
import time
import tty

port, name, log = sys.argv[1:]
board = os.open(port, os.O_RDWR | os.O_NOCTTY)
program, end = pty.openpty()
tty.setraw(board)
tty.setraw(end)
if os.path.islink(name):
    os.remove(name)
os.symlink(os.ttyname(end), name)
print("ready", flush=True)
with open(log, "w", buffering=1) as passed:
    while True:
        for side in select.select([board, program], [], [])[0]:
            data = os.read(side, 4096)
            os.write(program if side == board else board, data)
            passed.write(f"{time.monotonic():.6f} {'<' if side == board else '>'} {data!r}\n")
