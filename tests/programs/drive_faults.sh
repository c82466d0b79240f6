#!/usr/bin/env bash
# A drive that fails in the middle of a move stops the arm; once it is back and homed the loop continues
# with the same target, and nothing is lost from the log.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/live_cell.sh"

# servo TARGETS OPTIONS... [-- OPTIONS OF THE HOST...]
servo() {
  local options=(--targets "$1")
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do
    options+=("$1")
    shift
  done
  hosted gige "${@:2}" -- "$bin/planar-servo" --cell cell/gige.yaml --no-health --out run "${options[@]}" \
    2>said.txt </dev/null
}

# How many steps of the target a are in the log.
steps_of_a() {
  grep -c "^a," run/steps.csv
}

cp -r "$2/cell" .
# A home and switches that make searches short.
sed -i -e 's/joint_limits_deg: .*]], home_deg: .*]/joint_limits_deg: [[-105, 60], [90, 170], [-60, 270]], home_deg: [-60, 50, 20]/' \
  cell/cell.yaml
sed -i -e 's/home_deg: .*/home_deg: [-60, 50, 20]/' cell/truth.yaml
live_twins
printf 'id,x_mm,y_mm\na,200,100\n' >one.csv
printf 'id,x_mm,y_mm\na,200,100\nb,200,60\n' >two.csv

echo "homed at once"
servo one.csv --home -- --fault drive-unplugged,drive-power-cycle --score run --targets one.csv \
  --json figures.json || fail "$(cat said.txt)"
cat said.txt
grep -q '^a,.*,reached,' run/results.csv || fail "$(cat run/results.csv)"
[ "$(grep -c "a: drive 2.*the arm stands and waits" said.txt)" -eq 2 ] || fail "not noticed"
[ "$(grep -c "a: the drives are ready again; resuming" said.txt)" -eq 2 ] || fail "did not go on"
[ "$(grep -c '"fault": "drive-' figures.json)" -eq 2 ] || fail "$(cat figures.json)"
awk -v error="$(value figures.json after_max_mm_truth)" 'BEGIN { exit !(error < 0.1) }' ||
  fail "$(cat figures.json)"

logged=$(steps_of_a)
for fault in drive-unplugged drive-power-cycle; do
  echo "$fault, nobody may home"
  if servo two.csv --resume -- --fault $fault; then fail "$fault: an unhomed arm moved on"; fi
  cat said.txt
  grep -q "b: drive 2.*the arm stands and waits" said.txt || fail "$fault: not noticed"
  grep -q "lost their position:.* 2.*; start with --home, .*; add --resume to continue a run" \
    said.txt || fail "$fault: homing was not asked for"
  grep -q '^a,.*,reached,' run/results.csv || fail "$fault: the first result is lost"
  if grep -q '^b,' run/results.csv; then fail "$fault: an unhomed arm has a result"; fi
done
servo two.csv --resume || fail "$(cat said.txt)"
[ "$(grep -c ',reached,' run/results.csv)" -eq 2 ] || fail "no resumption: $(cat run/results.csv)"
[ "$(steps_of_a)" -eq "$logged" ] && [ "$logged" -gt 0 ] || fail "the log lost the steps of a"
