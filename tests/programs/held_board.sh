#!/usr/bin/env bash
# Somebody holds and lays the calibration board of a served cell, guided by planar-record, leaves in
# the middle and continues: loopback_only.sh held_board.sh BIN_DIR.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/served.sh"

"$bin/planar-virtual-cell" -q draw --seed 5 -o cell >/dev/null
printf '%s\n' id,plan,x_mm,y_mm,phi_deg g1,grid,,, g2,grid,,, g3,grid,,, l1,plane_grid,,, \
  u1,pose,200,200,0 >plan.csv
serve --cell cell/cell.yaml --out live.yaml

record=("$bin/planar-record" --cell live.yaml --plan plan.csv --out recording --home)
expect 2 "asks for 4 views of the calibration board, which a person shows to the camera of live.yaml; say" \
  "${record[@]}"
[ ! -e recording ] || fail "a recording without its board was begun"

# begin LOG: records in the background; what it says stands in LOG.
begin() {
  log=$1
  "${record[@]}" --grid circles:11x11:50mm --display auto </dev/null >"$log" 2>&1 &
  recording=$!
}

# says PATTERN: waits until the program says it.
says() {
  for _ in $(seq 300); do
    if grep -q -- "$1" "$log"; then return; fi
    kill -0 "$recording" 2>/dev/null || break
    sleep 0.1
  done
  grep -q -- "$1" "$log" || fail "'$1' was not said: $(cat "$log" served.txt)"
}

rows() { grep -c "^$1" recording/frames.csv || true; }

begin first.txt
says "3 more views of the board of 11 x 11 dots: hold it still"
says "^planar-record: g1: move it into the upper left corner"
at_cell "board hold 0"
says "g1 is taken; 2 more views: "
at_cell "board hold 2"
says "g2 is taken; 1 more view: "
kill -INT "$recording"
status=0
wait "$recording" || status=$?
[ "$status" -eq 1 ] || fail "leaving ended with $status: $(cat first.txt)"
says "left at g3; start again to continue"
[ "$(rows g)" -eq 2 ] || fail "$(cat recording/frames.csv)"
[ -s recording/view.png ] || fail "nothing was drawn"

# The board is still where it was when g2 was taken, and that view is known again.
begin second.txt
says "1 more view of the board of 11 x 11 dots (2 are there)"
sleep 3
[ "$(rows g)" -eq 2 ] || fail "the same view was taken twice: $(cat second.txt)"
at_cell "board hold 4"
says "g3 is taken"
says "1 more lay of the board of 11 x 11 dots: lay it flat"
at_cell "board lay 0"
says "l1 is taken, the last of 1"
says "the arm will move 5 s after the board is gone"
sleep 3
[ "$(rows u)" -eq 0 ] || fail "the arm moved below the board: $(cat second.txt)"
at_cell "board remove"
wait "$recording" || fail "the recording ended with $?: $(cat second.txt)"
grep -q "^3 positions recorded (2 were there before)" second.txt || fail "$(cat second.txt)"

"$bin/planar-calibrate-camera" -q --grid circles:11x11:50mm --model pinhole -o camera.yaml recording \
  --json camera.json >/dev/null
grep -q '"images_used": 3' camera.json || fail "$(cat camera.json)"
