#!/usr/bin/env bash
# A camera that fails in the middle of a move stops the arm; when it is back the loop continues.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/live_cell.sh"
camera=$3

# What planar-servo says of a fault.
complaint() {
  case $1 in
    packet-loss | truncated) echo "parts of its frames are missing" ;;
    frozen) echo "it repeats one picture" ;;
    dead) echo "the camera has sent no good frame\|the camera is lost" ;;
  esac
}

cp -r "$2/cell" .
live_twins
faults=packet-loss,frozen,dead
[ "$camera" = gige ] || faults=truncated,frozen,dead
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
hosted "$camera" --fault $faults --score run --targets targets.csv --json figures.json -- \
  "$bin/planar-servo" --cell "cell/$camera.yaml" --targets targets.csv --no-health --out run 2>said.txt \
  >summary.txt || fail "$(cat said.txt)"
cat summary.txt said.txt

grep -q '^a,.*,reached,' run/results.csv || fail "$(cat run/results.csv)"
grep "the arm stands and waits" said.txt >stops.txt || fail "the arm did not stop"
[ "$(wc -l <stops.txt)" -ge 3 ] || fail "the arm did not stop for each fault"
[ "$(grep -c "the camera delivers again" said.txt)" -eq "$(wc -l <stops.txt)" ] ||
  fail "the loop did not go on after each fault"
for fault in ${faults//,/ }; do
  grep -q "\"$fault\"" figures.json || fail "$fault did not come: $(cat figures.json)"
  grep -q "$(complaint "$fault")" stops.txt || fail "$fault: it was not said what is wrong"
done
# What was torn or repeated was counted and not measured; the camera that died was found again.
grep -q "^camera: .* [1-9][0-9]* with parts missing, [1-9][0-9]* repeated; .* [1-9][0-9]* time" \
  summary.txt || fail "$(cat summary.txt)"
awk -v error="$(value figures.json after_max_mm_truth)" 'BEGIN { exit !(error < 0.1) }' ||
  fail "$(cat figures.json)"
