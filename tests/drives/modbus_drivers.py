"""Three stepper drivers on one serial line, their telegrams framed and decoded by pymodbus:

modbus_drivers.py EXAMPLES PORT [--make leadshine|oriental] [--low-first] [--at COUNT,COUNT,COUNT] [--addresses A,B,C]
                  [--lose N] [--garble N] [--late N] [--stranger N] [--mute-moving A] [--alarm-moving A]
                  [--stall-moving A] [--restart-moving A] [--end-moving] [--hang-moving] [--after S] [--deaf-to-start] [--deaf-to-home]
                  [--single] [--ramps LEAST,MOST] [--window COUNTS] [--shafts PIPE]

It says "ready" once PORT is there. Of answers each N-th is lost, garbled, 0.15 s late, or another slave's. S seconds
(0.1) into its first move a driver of address A says nothing more, stops with an alarm, stops and says nothing of it, or
starts anew, off and counting from 0, or the adapter is gone or says nothing for 2 s. With --single they take single registers by function 0x06 alone.
Leadshine's refuse ramps outside --ramps. A way of up to --window counts is none to them. PIPE gets a line of counts
whenever a motor has turned.
"""
import argparse
import os
import select
import sys
import time
import tty

sys.path.insert(0, sys.argv[1])
from motion_program import Machine
from pymodbus.factory import ServerDecoder
from pymodbus.framer.rtu_framer import ModbusRtuFramer
from pymodbus.pdu import ModbusExceptions

ALARM = 0x0E0


class Driver:
    """One motor behind registers: what pymodbus' requests read and write."""

    def __init__(self, make, low_first, at, deaf_to_home, window):
        self.make, self.low_first, self.deaf_to_home, self.window = make, low_first, deaf_to_home, window
        self.machine, self.offset = Machine(), at
        self.words, self.armed, self.alarm, self.moved_s, self.searches = {}, None, 0, None, False

    def position(self):
        return self.offset + self.machine.counts()[0]

    def long_at(self, address):
        pair = [self.words.get(address + i, 0) for i in (0, 1)]
        high, low = reversed(pair) if self.low_first else pair
        return ((high << 16 | low) ^ 0x80000000) - 0x80000000

    def longs(self, value):
        words = [value >> 16 & 0xFFFF, value & 0xFFFF]
        return list(reversed(words)) if self.low_first else words

    def status(self):
        moving = self.machine.moves()
        homed = self.searches and not moving and self.position() == 0
        if self.make == "leadshine":
            return [(self.alarm != 0) | self.machine.on << 1 | moving << 2 | homed << 6]
        return self.longs(homed << 4 | (self.alarm != 0) << 7 | moving << 13)

    def live(self):
        """Registers that tell, by their first address."""
        if self.make == "leadshine":
            return {0x1014: self.longs(self.position()), 0x1003: self.status(), 0x2203: [self.alarm]}
        return {0x00CC: self.longs(self.position()), 0x007E: self.status(), 0x0080: self.longs(self.alarm)}

    def validate(self, _code, address, count):
        known = range(0x6000, 0x6300) if self.make == "leadshine" else range(0x0058, 0x0080)
        others = (0x1801, 0x000F) if self.make == "leadshine" else ()
        return address in self.live() or address in others or (address in known and address + count - 1 in known)

    def getValues(self, _code, address, count=1):  # pymodbus' name
        told = self.live().get(address, [self.words.get(address + i, 0) for i in range(count)])
        return (told + [0] * count)[:count]

    def setValues(self, _code, address, values):
        for i, value in enumerate(values):
            self.words[address + i] = value
        if self.make == "leadshine":
            if address == 0x000F:
                self.machine.on = values[0] == 1
            elif address == 0x1801 and values[0] == 0x1111:
                self.alarm = 0
            elif address == 0x6200:
                position, rpm, ms = self.long_at(0x6201), self.words[0x6203], self.words[0x6204]
                self.armed = position, rpm * 10000 / 60, 10000 * 1e6 / 60 / max(1, ms)
            elif address == 0x6002 and values[0] == 0x10:
                self.searches = False
                self.start()
            elif address == 0x6002 and values[0] == 0x40:
                self.machine.stop()
            elif address == 0x6002 and values[0] == 0x20:
                self.search()
        elif address == 0x0066:
            self.machine.on = True
            self.armed = self.long_at(0x5C), self.long_at(0x5E), self.long_at(0x60)
            self.searches = False
            self.start()
        elif address == 0x007C and self.long_at(0x7C) == 0x10:
            self.machine.on = True
            self.search()
        elif address == 0x007C and self.long_at(0x7C) == 0x20:
            self.machine.stop()
        elif address == 0x007C and self.long_at(0x7C) == 0x80:
            self.alarm = 0

    def refuses(self, request, ramps):
        """Returns whether it is a move with a ramp outside of these."""
        is_move = self.make == "leadshine" and request.function_code == 0x10 and request.address == 0x6200
        return is_move and not all(ramps[0] <= ramp <= ramps[1] for ramp in request.values[4:6])

    def search(self):
        if not self.deaf_to_home:
            self.armed, self.searches = (0, 5000.0, 50000.0), True
            self.start()

    def start(self):
        if self.armed is None or not self.machine.on or self.alarm or self.machine.moves():
            return
        position, speed, acceleration = self.armed
        way = position - self.position()
        if abs(way) <= self.window:
            return
        ramp = min(speed / acceleration, (abs(way) / acceleration) ** 0.5)
        self.machine.move([position - self.offset, 0, 0], abs(way) / (acceleration * ramp) + ramp, ramp)
        self.moved_s = self.moved_s or time.monotonic()

    def is_under_way(self, after_s):
        return self.moved_s is not None and time.monotonic() > self.moved_s + after_s


class Line:
    def __init__(self, options):
        self.options, self.answers = options, 0
        self.drivers = {address: Driver(options.make, options.low_first, at, options.deaf_to_home, options.window)
                        for address, at in zip(options.addresses, options.at)}
        self.framer = ModbusRtuFramer(ServerDecoder())
        self.inner, outer = os.openpty()
        tty.setraw(outer)
        if os.path.islink(options.port):
            os.unlink(options.port)
        os.symlink(os.ttyname(outer), options.port)
        self.shafts = open(options.shafts, "w", encoding="ascii") if options.shafts else None

    def spoil(self):
        """Lets drivers fail in mid-move."""
        options = self.options
        for address, driver in self.drivers.items():
            if not driver.is_under_way(options.after):
                continue
            if address == options.alarm_moving:
                driver.alarm = ALARM
                options.alarm_moving = None
                driver.machine.stop()
            if address == options.stall_moving:
                options.stall_moving = None
                driver.machine.stop()
            if address == options.restart_moving:
                options.restart_moving = None
                driver.machine = Machine()
            if options.end_moving:
                sys.exit()
            if options.hang_moving:
                options.hang_moving = False
                time.sleep(2.0)

    def obey(self, request):
        address = request.unit_id
        if address == 0:
            if not self.options.deaf_to_start:
                for driver in self.drivers.values():
                    request.execute(driver)
            return
        if self.options.single and request.function_code == 0x10 and request.count == 1:
            return
        driver = self.drivers.get(address)
        if driver is None or (address == self.options.mute_moving and driver.is_under_way(self.options.after)):
            return
        refuses = driver.refuses(request, self.options.ramps)
        answer = request.doException(ModbusExceptions.IllegalValue) if refuses else request.execute(driver)
        answer.unit_id = address
        self.say(self.framer.buildPacket(answer))

    def say(self, telegram):
        self.answers += 1
        due = lambda every: every and self.answers % every == 0
        if due(self.options.lose):
            return
        if due(self.options.garble):
            telegram = bytes([telegram[0], telegram[1] ^ 0x10]) + telegram[2:]
        if due(self.options.stranger):
            telegram = bytes([9]) + telegram[1:]
        if due(self.options.late):
            time.sleep(0.15)
        os.write(self.inner, telegram)

    def serve(self):
        print("ready", flush=True)
        told = None
        while True:
            ready = select.select([self.inner, sys.stdin], [], [], 0.002)[0]
            if sys.stdin in ready and not sys.stdin.readline():
                return
            self.spoil()
            if self.inner in ready:
                try:
                    self.framer.processIncomingPacket(os.read(self.inner, 4096), self.obey, [0, *self.drivers, *range(1, 248)])
                except OSError:
                    pass  # nobody has the port open
            counts = [driver.position() - at for driver, at in zip(self.drivers.values(), self.options.at)]
            if self.shafts and counts != told:
                self.shafts.write(" ".join(map(str, counts if told else ["at", *counts])) + "\n")
                self.shafts.flush()
                told = counts


def numbers(text):
    return [int(number) for number in text.split(",")]


parser = argparse.ArgumentParser()
parser.add_argument("examples")
parser.add_argument("port")
parser.add_argument("--make", default="leadshine")
parser.add_argument("--at", type=numbers, default=[0, 0, 0])
parser.add_argument("--addresses", type=numbers, default=[1, 2, 3])
for name in ("lose", "garble", "late", "stranger", "mute-moving", "alarm-moving", "stall-moving", "restart-moving"):
    parser.add_argument(f"--{name}", type=int)
for name in ("low-first", "deaf-to-start", "deaf-to-home", "end-moving", "hang-moving", "single"):
    parser.add_argument(f"--{name}", action="store_true")
parser.add_argument("--after", type=float, default=0.1)
parser.add_argument("--ramps", type=numbers, default=[0, 0xFFFF])
parser.add_argument("--window", type=int, default=0)
parser.add_argument("--shafts")
Line(parser.parse_args()).serve()
