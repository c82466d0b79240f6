#!/usr/bin/env bash
# The view of a run: a picture without a display, a window with one, and a window lost on the way.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\n' >targets.csv
servo() { "$bin/planar-servo" -q --cell cell/cell.yaml --targets "$@" 2>err.txt >out.txt; }

unset DISPLAY
servo targets.csv --out plain || fail "$(cat err.txt)"
[ ! -e plain/view.png ] || fail "a picture that nobody asked for"
servo targets.csv --out headless --display auto || fail "$(cat err.txt)"
[ -s headless/view.png ] || fail "no picture without a display"
status=0
servo targets.csv --out window --display x || status=$?
[ "$status" -eq 2 ] || fail "--display x without a display ended with $status"
grep -q "no X server answers at DISPLAY ''" err.txt || fail "$(cat err.txt)"
[ ! -e window ] || fail "a run without its display was begun"

printf 'id,plan,x_mm,y_mm,phi_deg\na,pose,200,100,0\ng,grid,,,\n' >plan.csv
for display in none auto; do
  "$bin/planar-record" -q --cell cell/cell.yaml --plan plan.csv --out "recording_$display" --display $display >out.txt
done
[ ! -e recording_none/view.png ] || fail "a map that nobody asked for"
[ -s recording_auto/view.png ] || fail "no map of a recording"

if ! command -v Xvfb >/dev/null; then
  echo "Xvfb is not installed: windows were not tried"
  exit 0
fi
mkfifo number
Xvfb -displayfd 3 -screen 0 1280x800x24 3>number >/dev/null 2>&1 &
server=$!
read -r display <number
export DISPLAY=:$display
servo targets.csv --out window --display x || fail "$(cat err.txt)"
cmp -s window/view.png headless/view.png || fail "the window shows something else than the picture"

# The server dies while the arm is on its way from target to target; the run does not.
mkfifo questions
"$bin/planar-servo" --cell cell/cell.yaml --targets - --out lost --display x \
  <questions >answers 2>err.txt &
servo=$!
exec 4>questions
echo "a,200,100" >&4
for _ in $(seq 600); do
  if [ -s answers ] && [ -s lost/view.png ]; then break; fi
  sleep 0.1
done
kill "$server"
wait "$server" || true
echo "b,-150,250" >&4
exec 4>&-
wait "$servo" || fail "the run ended with the display: $(cat err.txt)"
cmp -s lost/view.png headless/view.png || fail "the picture file did not go on without the window"
