#!/bin/sh
# build_firmware.sh FIRMWARE_DIR BUILD_DIR: builds the simulators of Grbl and grblHAL from the archives
# in FIRMWARE_DIR, once. Their lines are GPL-3 and stay outside the project.
set -e
firmware=$1 build=$2
for archive in grbl-1.1h-sim grblhal-sim; do
  [ -e "$firmware/$archive.tar.xz" ] && continue
  echo "skipped: no firmware ($firmware/$archive.tar.xz)"
  exit 0
done
[ -x "$build/grbl_sim" ] && [ -x "$build/grblHAL_sim" ] && exit 0
mkdir -p "$build" && cd "$build"
tar xf "$firmware/grbl-1.1h-sim.tar.xz" && tar xf "$firmware/grblhal-sim.tar.xz"
# The simulator of Grbl runs the interrupts in a second thread. Where both threads save and restore the one status
# register at once, interrupts would stay off for good, and where both change flags, one would be lost. The register
# therefore no longer holds interrupts up, and flags change in one step, as they do with interrupts switched off.
sed -i 's/uint8_t ien = io.sreg&SEI;/uint8_t ien = SEI;/' grbl/grbl/grbl-sim/avr/interrupt.c
sed -i -E 's/(sys_rt_exec_[a-z_]+) \|= \(mask\);/__atomic_fetch_or(\&\1, mask, __ATOMIC_SEQ_CST);/
           s/(sys_rt_exec_[a-z_]+) &= ~\(mask\);/__atomic_fetch_and(\&\1, ~mask, __ATOMIC_SEQ_CST);/' grbl/grbl/system.c
make -s -C grbl/grbl/grbl-sim main FLAGS="-g -O2 -w -fcommon -Wl,-z,muldefs" >grbl.log 2>&1
cp grbl/grbl/grbl-sim/grbl_sim.exe grbl_sim
cmake -S grblhal -B hal -DCMAKE_BUILD_TYPE=Release >hal.log 2>&1
make -s -C hal grblHAL_sim >>hal.log 2>&1
cp hal/grblHAL_sim grblHAL_sim
