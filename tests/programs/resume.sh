#!/usr/bin/env bash
# An interrupted recording and an interrupted run are gone on with; a finished run is not overwritten.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" "$2/plan.csv" .
head -n 9 plan.csv >begin.csv
"$bin/planar-record" -q --cell cell/cell.yaml --plan begin.csv --out recording >/dev/null
"$bin/planar-record" -q --cell cell/cell.yaml --plan plan.csv --out recording >second.txt
grep -q "51 positions recorded (8 were there before)" second.txt || fail "$(cat second.txt)"
ids=$(tail -n +3 recording/frames.csv | cut -d, -f1 | sort -u | wc -l)
[ "$ids" -eq 59 ] || fail "$ids ids recorded instead of 59"

# A wrong grid is found out late, and told view by view.
expect 2 "grid_1_0.pgm: no grid of 5 x 5 dots found" "$bin/planar-experiment" \
  --cell cell/cell.yaml --out . --grid circles:5x5:50mm --predict

calibrate cell/cell.yaml recording cell >/dev/null
printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\n' >one.csv
printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\nc,-200,-150\n' >all.csv
servo() { "$bin/planar-servo" -q --cell cell/cell.yaml --targets "$@"; }
servo one.csv --out run >/dev/null
if servo all.csv --out run >/dev/null 2>again.err; then fail "a finished run was overwritten"; fi
grep -q "holds a run already; name another folder or add --resume" again.err || fail "$(cat again.err)"
status=0
servo all.csv --out rnu --resume 2>again.err || status=$?
[ "$status" -eq 2 ] || fail "a mistyped folder was resumed with $status"
grep -q "rnu: holds no run to go on with; name the folder of one, or leave out --resume" again.err ||
  fail "$(cat again.err)"
[ ! -e rnu ] || fail "a mistyped folder was made"
servo all.csv --out run --resume >/dev/null
cut -d, -f1,4 run/results.csv | tail -n +3 >reached.txt
printf 'a,reached\nb,reached\nc,reached\n' | diff - reached.txt || fail "not all targets were reached"
grep -q "^targets: 3" run/run.yaml || fail "the report of a resumed run leaves targets out"
