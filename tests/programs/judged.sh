#!/usr/bin/env bash
# The paper's experiment on a served cell, judged by its tracker: refused without one, begun, continued from a
# recording of planar-record, killed in the loop and continued. What it judged is compared with the log of the
# truth, which nothing else reads: loopback_only.sh judged.sh BIN_DIR.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/served.sh"

"$bin/planar-virtual-cell" -q draw --seed 7 -o cell >/dev/null
serve --cell cell/cell.yaml --out live.yaml --truth-log truth.csv

sed 's/^tracker: .*/tracker: {source: none, sigma_mm: 0.01, sigma_mm_per_m: 0}/' live.yaml >untracked.yaml
expect 2 "untracked.yaml: nobody can judge this cell, .*tracker.source is none; .* name its source" \
  "$bin/planar-experiment" --cell untracked.yaml --out made
expect 2 "live.yaml: --train 0 is for virtual cells" \
  "$bin/planar-experiment" --cell live.yaml --out made --train 0 --board-thickness-mm 0
expect 2 "live.yaml: is no virtual cell; --seeds" \
  "$bin/planar-experiment" --cell live.yaml --out made --seeds 2
[ "$(wc -l <truth.csv)" -eq 3 ] || fail "the arm moved: $(cat truth.csv)"

# On a busy machine camera or drives may stop the experiment; the same command continues.
# A map of twelve places is no good one.
experiment=("$bin/planar-experiment" --cell live.yaml --train 12 --accept-map --loop-only 1 --home --out DIR)
worked() {
  until operated said.err bash -c 'echo $$ >pid; exec "$@"' sh "${experiment[@]}" "$@" >said.txt; do
    grep -q "start again to \(continue\|go on\)\|have not arrived\|does not answer" said.err || return 1
  done
}

# killed_at FILE PATTERN COUNT: a person works with the experiment, which is killed once so many lines of the file
# match.
killed_at() {
  worked &
  local working=$!
  for _ in $(seq 6000); do
    if [ "$(grep -c "$2" "$1" 2>/dev/null || true)" -ge "$3" ] 2>/dev/null; then break; fi
    kill -0 "$working" 2>/dev/null || fail "the experiment ended before $1 had $3 lines of '$2': $(cat said.err)"
    sleep 0.2
  done
  kill -KILL "$(cat pid)" || true
  wait "$working" 2>/dev/null || true
}

# Once it is begun, most of its plan is recorded in process, where no time passes: a served cell is left with one
# view of the board and two places.
killed_at DIR/plan.csv "^train_" 1
at_cell "reflector tool"
grep -v "^grid_13\|^test_00[23]" DIR/plan.csv >most.csv
rm -rf DIR/recording
"$bin/planar-record" -q --cell cell/cell.yaml --plan most.csv --out DIR/recording >/dev/null
views_shown=20
killed_at DIR/ours/run/results.csv "^c" 2
[ "$(grep -c "^grid_13\|^test_00[23]" DIR/recording/frames.csv)" -eq 7 ] || fail "$(cat said.err)"
cp DIR/recording/tracker.csv recorded.csv
cp DIR/ours/run/results.csv ours.csv
worked --json figures.json || fail "$(cat said.err)"
cmp DIR/recording/tracker.csv recorded.csv || fail "a complete recording was changed"
head -n "$(wc -l <ours.csv)" DIR/ours/run/results.csv | cmp - ours.csv || fail "targets were moved to again"
[ "$(grep -c "^datum" DIR/judge.csv)" -ge 6 ] || fail "the monuments were not read anew: $(cat DIR/judge.csv)"
grep -q "^judged by the cell's tracker: 4 of 4 targets with our chain, 4 of 4" said.txt || fail "$(cat said.txt)"
for figure in '"judged": 4' '"not_judged": \[\]' '"sigma_mm_truth": 0.00' '"after_rms_net_mm_truth": 0' \
  '"reflector_offset_sigma_mm": 0.0'; do
  grep -q "$figure" figures.json || fail "no $figure in $(cat figures.json)"
done

# What the tracker judged lies where the truth had the end point, but for its noise, its bias and what the arm's sag
# tilts the reflector: bounds of 0.04 mm for a target and 0.02 mm for the mean of four.
for run in ours/run paper/run paper/run_without_map; do
  awk -F, -v run="$run" '
    function column(name) { for (c = 1; c <= NF; ++c) if ($c == name) return c; print "no column " name; exit 1 }
    FNR == 1 { ++file; head = 0 }
    /^#/ { next }
    !head { head = 1
      if (file == 1) { next }
      if (file == 2) { look = column("t_s"); next }
      x = column("x_mm"); dx = column("after_truth_dx_mm"); dy = column("after_truth_dy_mm"); next }
    file == 1 { t[n] = $1; tx[n] = $2; ty[n++] = $3; next }
    file == 2 { seen[$1] = $look; next }
    { for (i = 0; i < n && t[i] <= seen[$1]; ++i) last = i
      ex = tx[last] - $x; ey = ty[last] - $(x + 1)
      off = sqrt(($dx - ex) ^ 2 + ($dy - ey) ^ 2)
      if (off > 0.04) { print run, $1, "judged", $dx, $dy, "true", ex, ey; bad = 1 }
      judged += sqrt($dx ^ 2 + $dy ^ 2) / 4; truth += sqrt(ex ^ 2 + ey ^ 2) / 4; ++targets }
    END {
      print run, "mean judged", judged, "true", truth
      exit !(targets == 4 && !bad && judged - truth < 0.02 && truth - judged < 0.02)
    }' truth.csv "DIR/$run/steps.csv" "DIR/$run/results.csv" >>compared.txt || fail "$(cat compared.txt)"
done

# With the files of our chain the tracker judges planar-servo, too, where that is asked for.
cp DIR/ours/{camera,workplane,tool,map,health,arm}.yaml .
echo "arm_found: arm.yaml" | tee -a live.yaml >>untracked.yaml

# Opened anew, a board with Grbl has lost its position.
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
expect 1 "lost their position: 1 2 3; start with --home" "$bin/planar-check-cell" --cell live.yaml
expect 1 "lost their position: 1 2 3; start with --home, .*; add --resume to continue a run" \
  "$bin/planar-servo" --cell live.yaml --targets targets.csv --accept-map --out made
"$bin/planar-check-cell" --cell live.yaml --home >said.txt || fail "$(cat said.txt)"
grep -q "as it was at its calibration" said.txt || fail "$(cat said.txt)"

expect 2 "untracked.yaml: nobody can judge this cell" \
  "$bin/planar-servo" --cell untracked.yaml --targets targets.csv --out made --judged
operated said.err "$bin/planar-servo" --cell live.yaml --targets targets.csv --out run --home --accept-map --judged --json run.json \
  >said.txt || fail "$(cat said.err)"
grep -q "^the tracker is uncertain by 0.0" said.txt || fail "$(cat said.txt)"
grep -q '"judged": 1' run.json || fail "$(cat run.json)"
[ "$(grep -c "^datum" run/judge.csv)" -ge 3 ] || fail "the monuments were not read: $(cat run/judge.csv)"
