#!/usr/bin/env bash
# A served cell whose board is Grbl's own firmware, found sound and moved: served_firmware.sh BIN_DIR FIRMWARE_DIR,
# by loopback_only.sh.
firmware=$(realpath -m "$2")/grbl_sim
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/served.sh"
[ -x "$firmware" ] || {
  echo "skipped: no firmware of Grbl"
  exit 77
}

"$bin/planar-virtual-cell" -q draw --seed 5 -o cell >/dev/null
serving=("$bin/planar-virtual-cell" serve --cell cell/cell.yaml)
expect 2 "absent: is no program that can be run; name Grbl's simulator" "${serving[@]}" --grbl-firmware absent
expect 1 "/true has ended with status 0" "${serving[@]}" --grbl-firmware /bin/true
expect 1 "GrblHAL.*takes 20 ms for each byte.*name the simulator of Grbl 1.1" \
  "${serving[@]}" --grbl-firmware "${firmware%grbl_sim}grblHAL_sim"

serve --cell cell/cell.yaml --out cell/live.yaml --truth-log truth.csv --grbl-firmware "$firmware"
[ "$(grep -o "reference: taught" cell/live.yaml | wc -l)" -eq 3 ] || fail "$(cat cell/live.yaml)"
"$bin/planar-doctor" --cell cell/live.yaml >doctor.txt || fail "$(cat doctor.txt)"
grep -q "^well  *drives: Grbl 1.1" doctor.txt || fail "$(cat doctor.txt)"

# The arm moves as the firmware steps, a reset does not move it, and a hand brings it to its marks.
last() { tail -n 1 truth.csv | cut -d, -f2-; }
until_truth() {
  for _ in $(seq 100); do
    if "$@"; then return; fi
    sleep 0.1
  done
  fail "never: $*: $(cat truth.csv)"
}
moved() { [ "$(last)" != "$before" ]; }
first=$(last)
before=$first
printf '$J=G21G53G90X3Y-2Z1F3000\n' >cell/grbl
until_truth moved
sleep 1
before=$(last)
printf '\x18' >cell/grbl
sleep 0.5
if moved; then fail "a reset moves the arm: $(cat truth.csv)"; fi
at_cell "arm marks"
tail -n 1 served.txt | grep -q "the arm stands at its marks" || fail "$(cat served.txt)"
until_truth awk -F, -v first="$first" 'BEGIN { split(first, p, ",") } { x = $2; y = $3 }
  END { exit !((x - p[1]) ^ 2 + (y - p[2]) ^ 2 < 0.05 ^ 2) }' truth.csv

# Without its firmware the cell is served no longer.
kill "$(pgrep -P "$served")"
status=0
wait "$served" || status=$?
[ "$status" -eq 1 ] || fail "without firmware the server ends with $status"
grep -q "grbl_sim has ended by signal 15" served.err || fail "$(cat served.err)"
