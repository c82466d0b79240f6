#!/usr/bin/env bash
# A drive that fails in the middle of a move stops the arm; once it is back and homed the loop goes on
# with the same target, and nothing is lost from the log.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/live_cell.sh"
camera=gige

# servo OUT OPTIONS...: to $targets; the fault comes in the first long move after command 1 to drive 1,
# which switches it on.
servo() {
  local out=$1
  shift
  hosted "$camera" --fault "$fault" --at-command 2 --fault-for 1 --json "$out.json" \
    ${score:+--score "$out" --targets "$targets"} -- \
    "$bin/planar-servo" --cell "cell/$camera.yaml" --targets "$targets" --out "$out" "$@" \
    2> >(tee "$out.err" >&2)
}

# Rows of a target in the log of a run.
steps_of() {
  grep -c "^$2," "$1/steps.csv"
}

calibrated_cell 5
# Near switches make short searches.
sed -i 's/joint_limits_deg: .*]],/joint_limits_deg: [[-200, 60], [20, 170], [-90, 270]],/' cell/cell.yaml
live_cell cell/cell.yaml "$camera" >"cell/$camera.yaml"
printf 'id,x_mm,y_mm\na,200,100\n' >one.csv
printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\n' >both.csv
targets=both.csv
for fault in drive-unplugged drive-power-cycle; do
  echo "$fault, homed at once"
  score=yes servo "$fault" --home
  [ "$(grep -c ',reached,' "$fault/results.csv")" -eq 2 ] || fail "$(cat "$fault/results.csv")"
  grep -q "[ab]: drive 2.*the arm stands and waits" "$fault.err" || fail "$fault: not noticed"
  grep -q "[ab]: the drives are ready again; going on" "$fault.err" || fail "$fault: did not go on"
  awk -v error="$(value "$fault.json" after_max_mm_truth)" 'BEGIN { exit !(error < 0.1) }' ||
    fail "$fault: $(cat "$fault.json")"

  echo "$fault, nobody may home"
  targets=one.csv fault=none score= servo "unhomed-$fault"
  logged=$(steps_of "unhomed-$fault" a)
  if score= servo "unhomed-$fault" --resume </dev/null; then fail "$fault: an unhomed arm moved on"; fi
  grep -q "lost their position:.* 2.*; home them with planar-jog, then go on with --resume" \
    "unhomed-$fault.err" || fail "$fault: homing was not asked for"
  grep -q '^a,.*,reached,' "unhomed-$fault/results.csv" || fail "$fault: the first result is lost"
  fault=none score= servo "unhomed-$fault" --resume
  [ "$(grep -c ',reached,' "unhomed-$fault/results.csv")" -eq 2 ] || fail "$fault: no resumption"
  [ "$(steps_of "unhomed-$fault" a)" -eq "$logged" ] && [ "$logged" -gt 0 ] ||
    fail "$fault: the log lost the steps of the first target"
done
