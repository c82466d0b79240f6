"""The example motion program with a fault: faulty_motion.py EXAMPLES FAULT [AT], from its AT-th answer on."""
import os
import signal
import sys
import time

sys.path.insert(0, sys.argv[1])
import motion_program

FAULT, AT = sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 1
count = 0


def answer(machine, request):
    global count
    count += 1
    if FAULT == "runs on" and request == "stop":
        return "ok"
    said = motion_program.obey(machine, request)
    if FAULT == "loses" and count == AT:
        machine.losses += 1
    if FAULT == "stalls" and count == AT:
        machine.stop()
    if FAULT == "alarm" and count == AT:
        machine.stop()
        machine.fault = "motor 2 is hot"
    return said


def write(text):
    if FAULT == "late" and count == AT:
        time.sleep(0.6)
    if FAULT == "ends" and count == AT:
        sys.exit(3)
    if FAULT == "dies" and count == AT:
        os.kill(os.getpid(), signal.SIGKILL)
    if FAULT == "garbage" and count == AT:
        text = "\x00\xff?" + text
    if FAULT == "endless" and count == AT:
        text = "x" * 5000
    if FAULT == "other number" and count == AT:
        text = "7" + text
    if FAULT == "nowhere" and count == AT:
        text = text.split()[0] + " ok 1 2 here"
    if FAULT == "idle" and count == AT:
        text = text.split()[0] + " ok 1 2 3 idle 0"
    sys.stdout.buffer.write((text + "\n").encode("latin-1") * (2 if FAULT == "twice" and count == AT else 1))
    sys.stdout.flush()


if FAULT == "stays":
    signal.signal(signal.SIGTERM, lambda *_: open(sys.argv[4], "w").write("told"))
    motion_program.serve(motion_program.Machine())
    time.sleep(60)
motion_program.serve(motion_program.Machine(), None, answer, write)
