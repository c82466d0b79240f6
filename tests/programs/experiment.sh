#!/usr/bin/env bash
# One experiment: killed while it records and while it moves, it continues by the same command; its --help shows
# what it prints.
source "$(dirname "$0")/common.sh"

cp -r "$repository/calib/small" cell
# With fewer dots ViSP, too, calibrates its camera in a second.
sed -i 's/columns: 11/columns: 7/; s/rows: 11/rows: 7/; s/pitch_mm: 25/pitch_mm: 40/' cell/truth.yaml
experiment=("$bin/planar-experiment" --cell cell/cell.yaml --grid circles:7x7:40mm --train 40
  --loop-only 5 --out DIR)

# killed_at FILE LINES: begins or continues, and is killed once the file has so many lines.
killed_at() {
  "${experiment[@]}" >/dev/null &
  for _ in $(seq 3000); do
    if [ -e "$1" ] && [ "$(wc -l <"$1")" -ge "$2" ]; then break; fi
    kill -0 $! 2>/dev/null || break
    sleep 0.1
  done
  kill -KILL $! || fail "the experiment ended before $1 had $2 lines"
  wait $! 2>/dev/null || true
}

killed_at DIR/recording/frames.csv 120
head -n 110 DIR/recording/frames.csv >recorded.csv
killed_at DIR/paper/run/results.csv 12
head -n 110 DIR/recording/frames.csv | cmp - recorded.csv || fail "positions were recorded again"
cp DIR/recording/frames.csv recorded.csv
cp DIR/ours/run/results.csv ours.csv
"${experiment[@]}" -q --json figures.json >quiet.txt 2>&1
[ ! -s quiet.txt ] || fail "with -q it says: $(cat quiet.txt)"
cmp DIR/recording/frames.csv recorded.csv || fail "a finished recording was changed"
cmp DIR/ours/run/results.csv ours.csv || fail "targets were moved to again"
grep -q '"targets": 20' figures.json || fail "$(cat figures.json)"
"${experiment[@]}" --json again.json >printed.txt
expect_sample printed.txt "$bin/planar-experiment"
# Results are kept with six decimals of a millimetre and three of a second, from which the figures follow
# once more.
paste figures.json again.json | awk '
  function figure(text) { return match(text, /-?[0-9.]+,?$/) ? substr(text, RSTART) + 0 : 0 }
  BEGIN { FS = "\t" }
  { first = $1; again = $2; off = figure($1) - figure($2) }
  { most = first ~ /seconds/ ? 1e-3 : 1e-4 }
  { sub(/-?[0-9.]+,?$/, "", first); sub(/-?[0-9.]+,?$/, "", again) }
  first != again || off > most || off < -most { print; differs = 1 }
  END { exit differs }' || fail "a finished experiment finds something else"
expect 2 "begun.json: was begun with .*: seed 1, now 2; give the same" \
  "${experiment[@]}" --seed 2
