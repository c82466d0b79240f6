#!/usr/bin/env bash
# The sample in each program's --help is what the program prints, but for the numbers. live_loop.sh,
# whose cell has devices, checks that of planar-doctor, experiment.sh that of planar-experiment, and certificate.sh that
# of planar-certify. Drawn cells state the tolerance of their kind.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" "$2/recording" .

"$bin/planar" >listed.txt
expect_sample listed.txt "$bin/planar"
"$bin/planar-virtual-cell" draw --seed 7 -o cells/7 >drawn.txt
expect_sample drawn.txt "$bin/planar-virtual-cell"
(cd cells/7 && "$bin/planar-next" --cell cell.yaml --json ../../next.json) >next.txt
expect_sample next.txt "$bin/planar-next"
expect_sample drawn.txt "$bin/planar-virtual-cell" draw
cmp cells/7/cell.yaml "$repository/calib/paper/cell.yaml" || fail "a drawn cell has not the paper's cell file"
for kind in paper:0.005 ordinary:0.010 cheap:0.030; do
  "$bin/planar-virtual-cell" -q draw --seed 7 --like "${kind%:*}" -o "${kind%:*}" >/dev/null
  grep -q "tolerance_mm: ${kind#*:}," "${kind%:*}/cell.yaml" || fail "cells like ${kind%:*} state another tolerance"
done
echo "board hold 0" | timeout -s INT 5 "$repository/tests/support/loopback_only.sh" "$bin/planar-virtual-cell" serve \
  --cell cell/cell.yaml --out live.yaml >served.txt 2>err.txt || true
if [ -s served.txt ]; then
  sed -i "s#$work/cell/#/home/me/#; s#cell/cell.yaml#cell.yaml#" served.txt
  expect_sample served.txt "$bin/planar-virtual-cell" serve
fi

printf 'id,plan,x_mm,y_mm\nt1,train,200,100\n' >plan.csv
"$bin/planar-record" --cell cell/cell.yaml --plan plan.csv --out RECORDING --json record.json >recorded.txt
expect_sample recorded.txt "$bin/planar-record"

"$bin/planar-calibrate-camera" --grid circles:11x11:50mm -o camera.yaml recording --json camera.json >camera.txt
expect_sample camera.txt "$bin/planar-calibrate-camera"

"$bin/planar-locate-lamps" --cell cell/cell.yaml -o lamps.csv recording --json lamps.json >lamps.txt
expect_sample lamps.txt "$bin/planar-locate-lamps"

# One reading of the tracker is wrong by 5 mm; later one pair is by 3 mm.
awk -F, -v OFS=, '$1 == "train_17" { $3 += 5 } 1' recording/tracker.csv >tracker.csv
mv tracker.csv recording/tracker.csv
"$bin/planar-pair-tracker" --cell cell/cell.yaml --lamps lamps.csv --recording recording \
  --workplane-out workplane.yaml --tool-out tool.yaml -o paired.csv --json paired.json >paired.txt
expect_sample paired.txt "$bin/planar-pair-tracker"

"$bin/planar-calibrate-arm" --cell cell/cell.yaml -o arm.yaml paired.csv --json arm.json >arm.txt
expect_sample arm.txt "$bin/planar-calibrate-arm"
cp -r cell paired_cell
cp workplane.yaml tool.yaml paired_cell
rm -f paired_cell/health.yaml
"$bin/planar-plan" --cell paired_cell/cell.yaml --readings 8 --after paired.csv -o next.csv >next.txt
expect_sample next.txt "$bin/planar-plan"
"$bin/planar-fit-error-map" --cell paired_cell/cell.yaml --arm-out paired_cell/arm.yaml \
  -o paired_cell/map.yaml paired.csv --json field.json >field.txt
grep -q "^places left out " field.txt || fail "$(cat field.txt)"

made_up_pairs 17 >pairs.csv
"$bin/planar-fit-error-map" -o map.yaml pairs.csv --json fitted.json >fitted.txt
expect_sample fitted.txt "$bin/planar-fit-error-map"
"$bin/planar-check-error-map" map.yaml pairs.csv --json checked.json >checked.txt
expect_sample checked.txt "$bin/planar-check-error-map"
"$bin/planar-export-map" --format grid-csv -o grid.csv map.yaml --json exported.json >exported.txt
expect_sample exported.txt "$bin/planar-export-map"

printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\n' >targets.csv
echo "arm_found: arm.yaml" >>paired_cell/cell.yaml
"$bin/planar-servo" --cell paired_cell/cell.yaml --targets targets.csv --no-health --out aimed \
  >aimed.txt || fail "$(cat aimed.txt)"
grep -q "against the truth: the arm alone 0\.0[01]" aimed.txt || fail "$(cat aimed.txt)"
"$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv --out DIR --json servo.json >servo.txt
expect_sample servo.txt "$bin/planar-servo"
printf '%s\n' enable home 'joint 2 10' where 'teach A' |
  "$bin/planar-jog" --cell cell/cell.yaml --teach taught.csv >jog.txt
expect_sample jog.txt "$bin/planar-jog"

"$bin/planar-board" circles:11x11:15mm --page A4 -o board.pdf --json board.json >board.txt
expect_sample board.txt "$bin/planar-board"
"$bin/planar-board" tool --cell cell/cell.yaml -o mount.svg --json mount.json >mount.txt
grep -q "^lamps  *8 and 8 mm wide, 40 mm apart$" mount.txt || fail "$(cat mount.txt)"

# With -q they print nothing, and write their files.
quiet() {
  local program=$1
  shift
  "$bin/$program" -q "$@" >quiet.txt 2>&1 || fail "$program -q: $(cat quiet.txt)"
  [ ! -s quiet.txt ] || fail "$program -q says: $(cat quiet.txt)"
}
quiet planar-board circles:11x11:15mm -o quiet.svg --json quiet.json
for file in quiet.svg quiet.json; do [ -s "$file" ] || fail "planar-board -q has not written $file"; done
quiet planar-virtual-cell draw --seed 7 -o quiet_cell
quiet planar-record --cell cell/cell.yaml --plan plan.csv --out quiet_recording
quiet planar-calibrate-camera --grid circles:11x11:50mm -o quiet.yaml recording/images/grid_[1-4]_0.pgm
quiet planar-locate-lamps --cell cell/cell.yaml -o quiet_lamps.csv RECORDING
quiet planar-pair-tracker --cell cell/cell.yaml --lamps lamps.csv --recording recording \
  --workplane-out workplane.yaml --tool-out tool.yaml -o quiet_pairs.csv \
  --grid circles:11x11:50mm --lays-out quiet_lays.csv
quiet planar-calibrate-arm --cell cell/cell.yaml -o quiet_arm.yaml paired.csv
quiet planar-plan --cell cell/cell.yaml --readings 12 -o quiet_plan.csv
quiet planar-fit-error-map -o quiet_map.yaml pairs.csv
quiet planar-fit-error-map --cell paired_cell/cell.yaml -o quiet_field.yaml paired.csv
quiet planar-check-error-map map.yaml pairs.csv
quiet planar-export-map --format numpy -o quiet.npy map.yaml
quiet planar-doctor --cell paired_cell/cell.yaml
quiet planar-doctor --new quiet_cell.yaml --drives virtual
quiet planar-doctor --seal map.yaml
quiet planar-next --cell cell/cell.yaml
quiet planar-check-cell --cell cell/cell.yaml
for how in --dry-run --check "--out quiet_run"; do
  # shellcheck disable=SC2086
  quiet planar-servo --cell cell/cell.yaml --targets targets.csv $how
done
printf '%s\n' enable home where 'teach A' | quiet planar-jog --cell cell/cell.yaml --teach quiet_taught.csv

# Every key that these wrote is in the glossary of outputs.md.
grep -ohE '"[A-Za-z0-9_]+":' ./*.json | sed -E 's/[":]//g; s/_(own_view|truth|tracker)$//; s/_[0-9](_|$)/_N\1/g' | sort -u >keys.txt
sed -n '/^## Keys of/,/^## Pages/p' "$repository/doc/outputs.md" | grep -oE '`[A-Za-z0-9_]+`' | tr -d '`' | sort -u >glossary.txt
[ "$(grep -c . keys.txt)" -gt 100 ] || fail "few keys: $(cat keys.txt)"
missing=$(comm -23 keys.txt glossary.txt | tr '\n' ' ')
[ -z "$missing" ] || fail "doc/outputs.md does not say what these keys mean: $missing"
