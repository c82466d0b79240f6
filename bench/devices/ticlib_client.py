"""umockdev-wrapper build/release/bin/host_tics 1 bench/.venv/bin/python bench/devices/ticlib_client.py

Moves an emulated Tic by somebody else's driver (ticlib, from PyPI). This shows that the emulation
speaks the Tic's protocol and not only that of our own driver.
"""

import sys
import time

from ticlib import TicUSB

tic = TicUSB()
print("supply in mV", tic.get_vin_voltage(), "errors", tic.get_error_status())
tic.halt_and_set_position(0)
tic.energize()
tic.exit_safe_start()
tic.set_max_speed(20_000_000)
tic.set_max_acceleration(2_000_000)
tic.set_max_deceleration(2_000_000)
for target in (500, -200, 0):
    tic.set_target_position(target)
    start = time.monotonic()
    while tic.get_current_position() != target and time.monotonic() - start < 3.0:
        tic.reset_command_timeout()
        time.sleep(0.01)
    print(f"at {tic.get_current_position()} of {target} after {time.monotonic() - start:.2f} s")
    if tic.get_current_position() != target:
        sys.exit(1)
tic.deenergize()
