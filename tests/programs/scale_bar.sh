#!/usr/bin/env bash
# scale_bar.sh BIN_DIR CELL_DIR: lengths of a bar laid over the workspace are measured, and a wrong one is noticed.
source "$(dirname "$0")/common.sh"
cp -r "$2/cell" .
printf '%s\n' id,x_mm,y_mm,kind,size_mm A,0,0,bright_disc,5 B,300,0,bright_disc,5 >bar.csv
certify=("$bin/planar-certify" --cell cell/cell.yaml --by scale-bar --bar bar.csv)
cp cell/truth.yaml bare_truth.yaml
put() {
  "$bin/planar-virtual-cell" put --cell cell/cell.yaml --drawing bar.csv --at "$1" >/dev/null
}
n=0
for at in 100,150,0 -400,150,0 -150,-150,0 -150,-250,5 -420,-100,70 420,-150,85 -150,300,10; do
  cp bare_truth.yaml cell/truth.yaml
  put "$at"
  n=$((n + 1))
  echo "save place$n.png" | "$bin/planar-jog" --cell cell/cell.yaml >/dev/null
done
"${certify[@]}" --image place*.png --out lengths --json lengths.json >said.txt || fail "$(cat said.txt)"
grep -q "Over 7 places" lengths/scale_bar.html || fail "the page does not say how many places"
expect 2 "lengths/scale_bar.html: exists already" "${certify[@]}" --image place1.png --out lengths
python3 -c '
import json
told = json.load(open("lengths.json"))
assert told["places"] == 7 and told["largest_error_mm"] < 0.2, told
assert abs(told["lengths"][0]["middle_mm"][0] - 250) < 1, told' || fail "$(cat lengths.json)"

sed 's/300,0/299,0/' bar.csv >short.csv
status=0
"$bin/planar-certify" --cell cell/cell.yaml --by scale-bar --bar short.csv --image place*.png --out wrong >said.txt || status=$?
[ $status -eq 1 ] && grep -q "are within the stated" wrong/scale_bar.html || fail "a wrong bar ended with $status: $(cat said.txt)"
again=(place1.png place1.png place1.png place1.png place1.png place2.png place2.png)
expect 1 "2 places are too few" "${certify[@]}" --out again --image "${again[@]}"
cp bare_truth.yaml cell/truth.yaml
echo "save bare.png" | "$bin/planar-jog" --cell cell/cell.yaml >/dev/null
expect 1 "bare.png: .*found nowhere" "${certify[@]}" --out bare --image place1.png bare.png
put 100,150,0
status=0
"${certify[@]}" --out few </dev/null >said.txt || status=$?
[ $status -eq 1 ] && grep -q "too few" few/scale_bar.html || fail "one place ended with $status"
put 250,409.8,180
expect 1 "nobody knows which is the bar.s other end" "${certify[@]}" --out several
expect 2 "needs --by scale-bar" "$bin/planar-certify" --cell cell/cell.yaml --bar bar.csv --out made
expect 2 "needs --bar" "$bin/planar-certify" --cell cell/cell.yaml --by scale-bar --out made

# The same bar enters the calibration: pictures are taken into a folder, and the map says what fixed its scale.
cp bare_truth.yaml cell/truth.yaml
for at in 100,150,0 -400,150,0 -150,-250,85; do
  cp bare_truth.yaml cell/truth.yaml
  put "$at"
  "$bin/planar-record" -q --cell cell/cell.yaml --bar bar.csv --bar-places 3 --out bar </dev/null
done
[ -e bar/bar_02.png ] || fail "three calls took $(ls bar)"
cp bare_truth.yaml cell/truth.yaml
expect 1 "found nowhere" "$bin/planar-record" -q --cell cell/cell.yaml --bar bar.csv --bar-places 4 --out bar
fit=("$bin/planar-fit-error-map" -q --cell cell/cell.yaml --report none)
"${fit[@]}" --bar bar.csv --image bar/bar_*.png -o with_bar.yaml --json fit.json cell/pairs.csv
python3 - <<'END' || fail "the bar is no source: $(cat fit.json)"
import json
fit = json.load(open("fit.json"))
assert {"source": "bar", "amount": "3 places"}.items() <= fit["sources"][-1].items(), fit["sources"]
END
grep -q "role: bar" with_bar.yaml || fail "the map does not say that it was made with the bar"
expect 2 "give whole pictures" "${fit[@]}" --bar bar.csv -o made cell/pairs.csv
expect 2 "none of the 2 marks of the base is seen" "${fit[@]}" --marks bar.csv --image bar/bar_00.png -o made cell/pairs.csv
