#!/usr/bin/env bash
# A camera that fails in the middle of a move stops the arm; when it is back the loop goes on.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/live_cell.sh"
camera=$2
shift 2

calibrated_cell 5
printf 'id,x_mm,y_mm\na,200,100\nb,150,200\n' >targets.csv
for fault in "$@"; do
  echo "$camera: $fault"
  # Command 1 switches the drives on, command 2 begins the first, long move.
  hosted "$camera" --fault "$fault" --at-command 2 --fault-for 2 --score "$fault" \
    --targets targets.csv --json "$fault.json" -- \
    "$bin/planar-servo" --cell "cell/$camera.yaml" --targets targets.csv --out "$fault" \
    2> >(tee "$fault.err" >&2)
  [ "$(grep -c ',reached,' "$fault/results.csv")" -eq 2 ] || fail "$(cat "$fault/results.csv")"
  grep -q "the arm stands and waits" "$fault.err" || fail "$fault: the arm did not stop"
  grep -q "the camera delivers again" "$fault.err" || fail "$fault: the loop did not go on"
  awk -v error="$(value "$fault.json" after_max_mm_truth)" 'BEGIN { exit !(error < 0.1) }' ||
    fail "$fault: $(cat "$fault.json")"
done
