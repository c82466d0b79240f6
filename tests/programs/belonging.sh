#!/usr/bin/env bash
# Files that were not made from one another are refused by name, with the step to redo, and nothing
# moves.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" "$2/recording" .
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
servo() { "$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv "$@"; }

servo --check >out.txt || fail "$(cat out.txt)"
"$bin/planar-doctor" --cell cell/cell.yaml >doctor.txt || fail "$(cat doctor.txt)"
grep -q "map.yaml: made by planar-fit-error-map .* from pairs.csv, lamps (cell.yaml), .*camera.yaml" doctor.txt ||
  fail "$(cat doctor.txt)"

# A tolerance that no arm keeps is questioned before anything moves.
sed 's/tolerance_mm: [0-9.]*/tolerance_mm: 0.0009/' cell/cell.yaml >cell/fine.yaml
"$bin/planar-servo" --cell cell/fine.yaml --targets targets.csv --check >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "fine.yaml: servo.tolerance_mm: is 0.0009; arms are usually positioned within 0.001 to 0.5 mm" err.txt ||
  fail "$(cat err.txt)"

# A weight of the map that somebody changed is refused by who reads it, until that person seals it.
cp cell/map.yaml good_map.yaml
awk -F'[][,]' '/^weights_m:/ { row = NR + 1 } NR == row { print "  - [" $2 + 0.001 "," $3 "]"; next } 1' good_map.yaml \
  >cell/map.yaml
if cmp -s good_map.yaml cell/map.yaml; then fail "no weight was changed"; fi
expect 2 "map.yaml: was changed after it had been written: .*; make it again, or, .* run planar-doctor --seal cell/map.yaml" \
  servo --out made
if "$bin/planar-doctor" --cell cell/cell.yaml >doctor.txt; then fail "the doctor is content"; fi
grep -q "map.yaml: was changed after it had been written" doctor.txt || fail "$(cat doctor.txt)"
"$bin/planar-doctor" --seal cell/map.yaml | grep -q "sealed cell/map.yaml" || fail "was not sealed"
servo --check >out.txt || fail "$(cat out.txt)"
"$bin/planar-doctor" --cell cell/cell.yaml >doctor.txt || fail "$(cat doctor.txt)"
grep -q "map.yaml: made by planar-fit-error-map .*, edited by hand 20" doctor.txt || fail "$(cat doctor.txt)"
"$bin/planar-doctor" --seal cell/map.yaml | grep -q "nothing is to be sealed" || fail "was sealed twice"
expect 2 "cell.yaml: is no calibration file" "$bin/planar-doctor" --seal cell/cell.yaml

# A map whose own fit speaks against it moves no arm, until a person accepts it.
sed 's/^  coverage_95: .*/  coverage_95: 0.3/' good_map.yaml >cell/map.yaml
if cmp -s good_map.yaml cell/map.yaml; then fail "the map has no coverage"; fi
"$bin/planar-doctor" -q --seal cell/map.yaml >/dev/null
for options in "--check" "--out made"; do
  # shellcheck disable=SC2086
  expect 2 "map.yaml: only 30 % of what [0-9]* places left out show .*; record more places .* --accept-map" servo $options
done
if "$bin/planar-doctor" --cell cell/cell.yaml >doctor.txt; then fail "the doctor is content"; fi
grep -q "map.yaml: only 30 % of what" doctor.txt || fail "$(cat doctor.txt)"
servo --accept-map --out accepted >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "accepted: .*only 30 % of what" err.txt || fail "$(cat err.txt)"
grep -q "^accepted_map: .*only 30 % of what" accepted/run.yaml || fail "$(cat accepted/run.yaml)"
cp good_map.yaml cell/map.yaml

# One of an earlier version, which has no checksum, is accepted with a notice.
sed -i '/^checksum:/d' cell/tool.yaml
servo --check >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "tool.yaml: has no checksum; a change to it goes unnoticed" err.txt || fail "$(cat err.txt)"

# A camera calibrated again, and the rest forgotten.
cp cell/camera.yaml good.yaml
sed -i 's/^rms_px: .*/rms_px: 0.1/' cell/camera.yaml
"$bin/planar-doctor" -q --seal cell/camera.yaml >/dev/null
for options in "--check" "--out made"; do
  # shellcheck disable=SC2086
  expect 2 "workplane.yaml: was made with camera.yaml [0-9a-f]{8}..., this one is [0-9a-f]{8}...; run planar-pair-tracker again" \
    servo $options
  grep -q "map.yaml: was made with camera.yaml" err.txt || fail "$(cat err.txt)"
done
expect 2 "lamps.csv: was made with camera.yaml .*; run planar-locate-lamps again" \
  "$bin/planar-pair-tracker" --cell cell/cell.yaml --lamps cell/lamps.csv --recording recording \
  --workplane-out made --tool-out made.tool -o made.pairs
if "$bin/planar-doctor" --cell cell/cell.yaml >doctor.txt; then fail "the doctor is content"; fi
grep -q "workplane.yaml: was made with camera.yaml" doctor.txt || fail "$(cat doctor.txt)"

# A map and pairs of another calibration.
sed '/^# role: camera$/{n;s/[0-9a-f]*$/0000000000000000000000000000000000000000000000000000000000000000/}' cell/pairs.csv >pairs.csv
expect 2 "map.yaml: was made with camera.yaml .*, that of pairs.csv is 00000000" \
  "$bin/planar-check-error-map" --plan train cell/map.yaml pairs.csv

# No plan goes on from the pairs of another calibration, until a person accepts it.
plan_after() { "$bin/planar-plan" --cell cell/cell.yaml --readings 5 --after "$@"; }
expect 2 "pairs.csv: was made with camera.yaml 00000000..., this one is .*; run planar-pair-tracker again" \
  plan_after pairs.csv -o made
plan_after pairs.csv --accept-stale -o next.csv >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "accepted: .*pairs.csv: was made with camera.yaml" err.txt || fail "$(cat err.txt)"

# Pairs that somebody has edited are told from those that were written.
sed -E '/^train_3,/s/,-?[0-9]/,9/' cell/pairs.csv >pairs.csv
"$bin/planar-fit-error-map" -o map.yaml pairs.csv >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "pairs.csv: its rows were changed after they had been written" err.txt || fail "$(cat err.txt)"
"$bin/planar-fit-error-map" -o map.yaml cell/pairs.csv >out.txt 2>err.txt || fail "$(cat err.txt)"
[ ! -s err.txt ] || fail "$(cat err.txt)"

# Whoever wants it all the same is told what they accept, and so is the run.
servo --accept-stale --out run >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "accepted: .*workplane.yaml: was made with camera.yaml" err.txt || fail "$(cat err.txt)"
grep -q "accepted_stale: .*workplane.yaml: was made with camera.yaml" run/run.yaml ||
  fail "$(cat run/run.yaml)"

# Lamps are located anew without the workplane that is no longer true.
"$bin/planar-locate-lamps" --cell cell/cell.yaml -o lamps.csv recording >out.txt 2>err.txt ||
  fail "$(cat err.txt)"
grep -q "until then lamps are located without the workplane" err.txt || fail "$(cat err.txt)"
cp good.yaml cell/camera.yaml

# Monuments that were measured again.
cp cell/cell.yaml good_cell.yaml
sed -i '/datum1/s/z_mm: [-0-9.]*/z_mm: 0.5/' cell/cell.yaml
expect 2 "workplane.yaml: was made with datum \(cell.yaml\) .*; run planar-pair-tracker again" servo --out made

# What no file was made from may change.
sed 's/settle_ms: 200/settle_ms: 210/' good_cell.yaml >cell/cell.yaml
servo --check >out.txt 2>&1 || fail "$(cat out.txt)"
