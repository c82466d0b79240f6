#!/usr/bin/env bash
# A served cell whose arm follows what moves it: the example of a motion program, and drivers on Modbus. Targets are
# reached, joints that are exchanged are named, and a person's stop and a program that dies are survived:
# loopback_only.sh served_links.sh BIN_DIR.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/served.sh"

cp -r "$repository/calib/workshop" cell
serve --cell cell/cell.yaml --out cell/live.yaml --shafts
grep -q "^drives *follow counts from .*/shafts$" served.txt || fail "$(cat served.txt)"
cp "$repository/examples/python/motion_program.py" cell
printf 'id,x_mm,y_mm\nA,150,200\nB,-100,250\n' >targets.csv
servo=("$bin/planar-servo" -q --cell cell/live.yaml --targets targets.csv)

reached() { # reached FOLDER: both targets, as the loop itself sees it
  [ "$(grep -c ',reached,' "$1/results.csv")" -eq 2 ] || fail "$(cat "$1/results.csv")"
}
"$bin/planar-doctor" --cell cell/live.yaml >doctor.txt || fail "$(cat doctor.txt)"
grep -q "^well  *drives: simulated motors, at 0, 0, 0 counts, off" doctor.txt || fail "$(cat doctor.txt)"
expect 1 "start with --at-marks" "${servo[@]}" --no-health --out made
"${servo[@]}" --at-marks --out by_command
reached by_command

# One that exchanges the counts of two joints: the check says so, and no target is driven.
at_cell "arm marks"
sed -i 's/int(value) for value in values\[:3\]/int(values[i]) for i in (1, 0, 2)/
        s/map(str, self.counts())/str(self.counts()[i]) for i in (1, 0, 2)/' cell/motion_program.py
[ "$(grep -c "for i in (1, 0, 2)" cell/motion_program.py)" -eq 2 ] || fail "no counts were exchanged"
expect 1 "the drives of joints 1 and 2 are exchanged" "${servo[@]}" --at-marks --out made
cp "$repository/examples/python/motion_program.py" cell

# A program that dies in mid-move: the run ends and says how.
at_cell "arm marks"
sed -i 's/\[python3, motion_program.py/[sh, -c, "python3 motion_program.py \\"$1\\" \& sleep 4; kill -KILL $!; wait $!", sh/' cell/live.yaml
status=0
"${servo[@]}" --no-health --at-marks --out died >/dev/null 2>died.err || status=$?
[ $status -eq 1 ] && grep -Eq "has ended with status|closed its output" died.err || fail "status $status: $(cat died.err)"

# Drivers on Modbus.
if ! /usr/bin/python3 -c "import pymodbus" 2>/dev/null; then
  echo "without python3-pymodbus nothing speaks Modbus"
  exit 0
fi
at_cell "arm marks"
mkfifo hold
/usr/bin/python3 -B "$repository/tests/drives/modbus_drivers.py" "$repository/examples/python" "$PWD/line" \
  --shafts "$PWD/cell/shafts" <hold >ready.txt 2>drivers.err &
exec 5>hold
for _ in $(seq 100); do grep -q ready ready.txt && break; sleep 0.1; done
python3 - "$PWD/line" <<'END'
import re, sys
text = open("cell/live.yaml").read()
addresses = iter("123")
text = re.sub(r"program: \[.*?\](?=[,}\n])|program: .*", lambda _: f"port: {sys.argv[1]}, baud: 115200, parity: none, "
              f"registers: leadshine-rs.yaml, address: {next(addresses)}", text)
open("cell/live.yaml", "w").write(text.replace("kind: command", "kind: modbus"))
END
"$bin/planar-doctor" --cell cell/live.yaml >doctor.txt || fail "$(cat doctor.txt cell/live.yaml)"
grep -q "^well  *drives: Leadshine .* all three answer" doctor.txt || fail "$(cat doctor.txt)"
"${servo[@]}" --no-health --at-marks --out by_modbus 2>modbus.err || fail "$(cat modbus.err drivers.err)"
reached by_modbus
exec 5>&-
