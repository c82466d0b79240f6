#!/usr/bin/env bash
# Somebody lays a bar of certified length in a served cell, guided by planar-record: loopback_only.sh held_bar.sh BIN_DIR.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/served.sh"

cp -r "$repository/calib/workshop" cell
printf '%s\n' id,x_mm,y_mm,kind,size_mm A,0,0,bright_disc,5 B,200,0,bright_disc,5 >bar.csv
"$bin/planar-virtual-cell" put --cell cell/cell.yaml --drawing bar.csv --at 900,900,0 >/dev/null
serve --cell cell/cell.yaml --out cell/live.yaml
mkfifo keys
"$bin/planar-record" --cell cell/live.yaml --bar bar.csv --bar-places 2 --out bar <keys >said.txt 2>&1 &
recording=$!
exec 4>keys

# lay X Y TURN SAID: lays the bar, presses Enter and waits until planar-record says that.
lay() {
  at_cell "work $1 $2 $3"
  echo >&4
  for _ in $(seq 100); do
    if grep -q -- "$4" said.txt; then return; fi
    kill -0 "$recording" 2>/dev/null || break
    sleep 0.1
  done
  grep -q -- "$4" said.txt || fail "'$4' was not said: $(cat said.txt served.txt)"
}

lay 900 900 0 "found nowhere"
lay 150 150 0 "the bar is seen with its middle at (250"
lay -300 100 90 "the bar is seen with its middle at (-300"
wait "$recording" || fail "$(cat said.txt)"
[ -e bar/bar_01.png ] && [ ! -e bar/bar_02.png ] || fail "taken: $(ls bar)"
