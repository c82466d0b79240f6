#!/usr/bin/env bash
# Somebody lays a bar of certified length in a served cell, and planar-record takes a picture of each of its places:
# loopback_only.sh held_bar.sh BIN_DIR.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/served.sh"

cp -r "$repository/calib/workshop" cell
printf '%s\n' id,x_mm,y_mm,kind,size_mm A,0,0,bright_disc,5 B,200,0,bright_disc,5 >bar.csv
"$bin/planar-virtual-cell" put --cell cell/cell.yaml --drawing bar.csv --at 900,900,0 >/dev/null
serve --cell cell/cell.yaml --out cell/live.yaml
record=("$bin/planar-record" --cell cell/live.yaml --bar bar.csv --bar-places 2 --out bar)
expect 1 "found nowhere" "${record[@]}" </dev/null

# lay X Y TURN SAID: lays the bar, and planar-record says that of its picture.
lay() {
  at_cell "work $1 $2 $3"
  "${record[@]}" </dev/null >said.txt 2>&1 || fail "$(cat said.txt served.txt)"
  grep -q -- "$4" said.txt || fail "'$4' was not said: $(cat said.txt served.txt)"
}
lay 150 150 0 "the bar is seen with its middle near (25[0-9.]*, 1[45]"
expect 1 "the bar lies where it lay before" "${record[@]}" </dev/null
lay -300 100 90 "the bar is seen with its middle near (-[23][0-9.]*, [12][0-9]"
[ -e bar/bar_01.png ] && [ ! -e bar/bar_02.png ] || fail "taken: $(ls bar)"

# One that a person has deleted is taken anew, and the other stays.
sha256sum bar/bar_01.png >kept.txt
rm bar/bar_00.png
lay 150 150 0 "the bar is seen with its middle near (25[0-9.]*, 1[45]"
sha256sum --quiet -c kept.txt || fail "a picture was replaced"
[ -e bar/bar_00.png ] || fail "taken: $(ls bar)"
