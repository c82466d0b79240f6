#!/usr/bin/env bash
# The view of a run or a recording: a picture file where it is asked for.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\n' >targets.csv
servo() { "$bin/planar-servo" -q --cell cell/cell.yaml --targets "$@" 2>err.txt >out.txt; }

servo targets.csv --out plain || fail "$(cat err.txt)"
[ ! -e plain/view.png ] || fail "a picture that nobody asked for"
servo targets.csv --out drawn --display auto || fail "$(cat err.txt)"
[ -s drawn/view.png ] || fail "no picture of a run"
printf 'id,plan,x_mm,y_mm,phi_deg\na,pose,200,100,0\ng,grid,,,\n' >plan.csv
for display in none auto; do
  "$bin/planar-record" -q --cell cell/cell.yaml --plan plan.csv --out "recording_$display" --display $display >out.txt
done
[ ! -e recording_none/view.png ] || fail "a map that nobody asked for"
[ -s recording_auto/view.png ] || fail "no map of a recording"
