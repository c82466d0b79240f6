#!/usr/bin/env bash
# planar next: the commands that it names, one after the other, lead a fresh cell to its certificate; whatever is
# missing or no longer valid after that, it names again.
source "$(dirname "$0")/common.sh"
export PATH=$bin:$PATH

planar virtual-cell -q draw --seed 7 -o cell >/dev/null
cd cell

# next_step: the name of the step that is next, and its command in `command`.
next_step() {
  planar next --cell cell.yaml --json next.json >next.txt || fail "$(cat next.txt)"
  command=$(awk 'on { sub(/^ +/, ""); print; exit } /^next / { on = 1 }' next.txt)
  awk -F '  +' '/^next / { print $2 }' next.txt
}

# walk LAST: does step by step what is next until this one is done or nothing is left.
walk() {
  local last=$1 step=
  steps=
  for _ in $(seq 15); do
    next_step >step.txt
    [ "$step" != "$last" ] || break
    step=$(cat step.txt)
    [ -n "$step" ] || break
    steps+="$step, "
    # As it stands there, but with fewer places, views of the board, cycles and targets, with one model of the lens
    # (first_cell.sh looks for the best) and with the board's thickness.
    command=${command/--readings 200/--readings 60}
    command=${command/--unattended 1000 --lays 12/--unattended 60 --lays 4}
    command=${command/--model auto/--model plumb_bob}
    command=${command/-mm T/-mm -5.4}
    [[ $command != planar-certify* ]] || command+=" --cycles 2 --targets 4"
    eval "$command" >said.txt 2>err.txt || fail "$command: $(cat said.txt err.txt)"
    [ "$step" != plan ] || sed -Ei '/^grid_(0[6-9]|1)/d' plan.csv
  done
}
walk certificate
[ "$steps" = "plan, recording, camera, lamps, pairs, error map, found arm, targets, positioning, certificate, " ] ||
  fail "the steps were $steps$(cat next.txt)"
grep -qx 'nothing is left to do' next.txt || fail "$(cat next.txt)"
[ "$(grep -c '^done' next.txt)" -eq 11 ] || fail "$(cat next.txt)"

# expect_next STEP PATTERN: the step, and what is said of it or its command.
expect_next() {
  next_step >step.txt
  [ "$(cat step.txt)" = "$1" ] || fail "next is not $1: $(cat next.txt)"
  awk '/^next / { on = 2 } on-- > 0' next.txt | grep -Eq -- "$2" || fail "next says not '$2': $(cat next.txt)"
}
without() {
  local file=$1
  shift
  mv "$file" aside
  expect_next "$@"
  mv aside "$file"
}
without camera.yaml camera "planar-calibrate-camera .* -o camera.yaml recording"
without tool.yaml pairs "tool.yaml does not exist yet"
without health.yaml pairs "--health-out health.yaml"
without map.yaml "error map" "planar-fit-error-map --cell cell.yaml --arm-out arm.yaml -o map.yaml pairs.csv"
without run positioning "planar-servo --cell cell.yaml --targets targets.csv --out run$"
without certificate certificate "planar-certify --cell cell.yaml --out certificate"

# What was made from the recording needs it no longer, unless it is to be made again.
mv recording gone
mv lamps.csv gone.csv
next_step >step.txt
[ ! -s step.txt ] || fail "$(cat next.txt)"
without tool.yaml recording "planar-record --cell cell.yaml --plan plan.csv --out recording"
mv gone recording
without tool.yaml lamps "planar-locate-lamps --cell cell.yaml -o lamps.csv recording"
mv gone.csv lamps.csv

# A recording that has grown, a plan that was added, a value that was changed, a file that was edited.
cp recording/frames.csv frames_before.csv
tail -n 1 recording/frames.csv | sed 's/^[^,]*/extra/' >>recording/frames.csv
expect_next lamps "lamps.csv: was made with frames.csv .* run planar-locate-lamps again"
mv frames_before.csv recording/frames.csv
printf 'id,plan,x_mm,y_mm\nmore_1,train,200,100\n' >plan_2.csv
expect_next recording "1 rows of plan_2.csv are not recorded yet"
grep -q -- "--plan plan_2.csv --out recording" next.txt || fail "$(cat next.txt)"
rm plan_2.csv
cp cell.yaml cell_before.yaml
sed -i 's/separation_mm: 40.0/separation_mm: 40.1/' cell.yaml
expect_next lamps "was made with lamps \(cell.yaml\)"
mv cell_before.yaml cell.yaml
cp map.yaml map_before.yaml
sed -E -i '0,/_mm: [0-9.e-]+$/s//_mm: 0.5/' map.yaml
! cmp -s map.yaml map_before.yaml || fail "the map was not edited"
expect_next "error map" "map.yaml: "
mv map_before.yaml map.yaml

# A new map asks for a new run and a new certificate, beside the old ones.
eval "planar-fit-error-map --method rbf -o map.yaml pairs.csv" >said.txt 2>&1 || fail "$(cat said.txt)"
expect_next positioning "--out run_2"
grep -q "certificate_2" next.json || fail "$(cat next.json)"

# Without a tracker: by lays of the board and poses that only the camera watches.
cd ..
planar virtual-cell -q draw --seed 8 -o alone >/dev/null
cd alone
sed -i '/^tracker:/d; /^datum:/d; /^  - {id: datum/d' cell.yaml
sed -i '/^workspace:/i tracker: {source: none}\ndatum: []' cell.yaml
walk "error map"
[ "$steps" = "plan, recording, camera, lamps, pairs, error map, " ] || fail "the steps were $steps$(cat next.txt)"
grep -q "as a whole" said.txt || fail "$(cat said.txt)"

cd ..
expect 2 "absent.yaml: cannot be read" planar next --cell absent.yaml
expect 2 "^planar-next: --cell is required" planar next
expect 2 "grid 'dots' is not circles:" planar next --cell cell/cell.yaml --grid dots
