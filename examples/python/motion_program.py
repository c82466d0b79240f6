#!/usr/bin/env python3
"""Moves three motors for `kind: command`: motion_program.py [SHAFTS]

The motors are simulated: put calls of your machine where Machine has formulas. SHAFTS is the pipe at which
`planar-virtual-cell serve --shafts` is told where the motors are. doc/motion_program.md has the protocol.
"""
import select
import sys
import time
from collections.abc import Callable
from typing import TextIO

SILENCE_S = 0.5  # planar-servo asks every few milliseconds while the machine moves


class Machine:
    """Counts of three motors, and the straight move that they make."""

    def __init__(self) -> None:
        self.on, self.losses, self.fault = False, 0, ""
        self.begin, self.way = [0.0] * 3, [0.0] * 3
        self.since, self.duration, self.ramp = 0.0, 0.0, 0.0

    def share(self) -> float:
        """Returns how much of the way is done: it speeds up for `ramp`, and slows down as long."""
        t, left = time.monotonic() - self.since, self.since + self.duration - time.monotonic()
        if left <= 0:
            return 1.0
        speed = 1 / (self.duration - self.ramp)
        if t < self.ramp:
            return speed * t * t / (2 * self.ramp)
        return 1 - speed * left * left / (2 * self.ramp) if left < self.ramp else speed * (t - self.ramp / 2)

    def counts(self) -> list[int]:
        share = self.share()
        return [round(begin + share * way) for begin, way in zip(self.begin, self.way)]

    def moves(self) -> bool:
        return time.monotonic() < self.since + self.duration

    def move(self, counts: list[int], duration: float, ramp: float) -> None:
        self.begin = [float(count) for count in self.counts()]
        self.way = [end - begin for end, begin in zip(counts, self.begin)]
        self.since, self.duration, self.ramp = time.monotonic(), duration, ramp

    def stop(self) -> None:
        """Brakes with the acceleration of the move, along its way."""
        t = time.monotonic() - self.since
        if not self.moves() or t > self.duration - self.ramp:
            return
        speed, ramp = 1 / (self.duration - self.ramp), min(t, self.ramp)
        share = self.share() + speed * ramp / self.ramp * ramp / 2
        self.way = [share * way for way in self.way]
        self.duration, self.ramp = t + ramp, ramp

    def where(self) -> str:
        motion = "off" if not self.on else "moving" if self.moves() else "resting"
        return f"{' '.join(map(str, self.counts()))} {motion} {self.losses} {self.fault}".rstrip()


def obey(machine: Machine, request: str) -> str:
    """Does what is asked and returns the answer."""
    word, *values = request.split()
    if word == "hello":
        return "ok simulated motors"
    if word == "where":
        return f"ok {machine.where()}"
    if word == "enable":
        machine.on, machine.fault = True, ""
    elif word == "stop":
        machine.stop()
    elif word == "move" and machine.on and not machine.moves():
        machine.move([int(value) for value in values[:3]], float(values[3]), float(values[4]))
    else:
        return f"no {request}: these motors have no switches, and move from rest when they are on"
    return "ok"


def say(text: str) -> None:
    print(text, flush=True)


def serve(machine: Machine, shafts: TextIO | None = None, answer: Callable[[Machine, str], str] = obey,
          write: Callable[[str], None] = say) -> None:
    """Answers lines until standard input ends, then brakes."""
    heard_s, told = time.monotonic(), list[int]()
    while True:
        if select.select([sys.stdin], [], [], 0.002 if machine.moves() else 0.05)[0]:
            line = sys.stdin.readline()
            if not line:
                break
            heard_s = time.monotonic()
            number, request = line.strip().split(maxsplit=1)
            write(f"{number} {answer(machine, request)}")
        if time.monotonic() - heard_s > SILENCE_S:
            machine.stop()
        if shafts and told != (counts := machine.counts()):
            shafts.write(("" if told else "at ") + " ".join(map(str, counts)) + "\n")
            shafts.flush()
            told = counts
    machine.stop()
    time.sleep(max(0.0, machine.since + machine.duration - time.monotonic()))


if __name__ == "__main__":
    serve(Machine(), open(sys.argv[1], "w", encoding="ascii") if len(sys.argv) > 1 else None)
