#!/usr/bin/env bash
# A tracker that somebody works by hand, none at all, a file that is not there, and a reflector that was bumped:
# tracker.sh BIN_DIR CELL_DIR.
source "$(dirname "$0")/common.sh"
cp "$2/cell/cell.yaml" "$2/cell/truth.yaml" .
printf '%s\n' id,plan,x_mm,y_mm,phi_deg t0,train,200,100,0 t1,train,-150,250,0 u0,pose,0,300,0 >plan.csv
with_source() { sed -E "s/^tracker: \{/tracker: {source: $1, /" cell.yaml >"$2.yaml"; }
with_source ask asked
with_source none none
with_source "file, path: nowhere.csv" file

record() { timeout 60 "$bin/planar-record" --plan plan.csv "$@"; }

# Three monuments, two places of which one is skipped, three monuments.
printf '\n\n\n1000,1,1\ns\n\n\n\n' | record --cell asked.yaml --out asked >asked.txt 2>asked.err
grep -q "left out without a reading: t1" asked.txt || fail "what was skipped is not named"
grep -q "^t0,.*,1000.00000,1.00000,1.00000$" asked/tracker.csv || fail "the typed reading is lost"
grep -q "^t1," asked/frames.csv && fail "a place that was skipped is kept"
grep -q "^u0," asked/frames.csv || fail "the pose is not recorded"

# A person at a terminal: what was typed before a question is no answer to it, and each place says how many are left.
mkfifo keys
script -qec "$bin/planar-record --cell asked.yaml --plan plan.csv --out typed" /dev/null <keys >screen.txt 2>&1 &
typed=$!
exec 4>keys
# answer PATTERN KEYS: types once the screen shows a further question like this.
answer() {
  for _ in $(seq 100); do
    if [ "$(grep -o "$1" screen.txt | wc -l)" -gt "${asked[$1]:-0}" ]; then break; fi
    sleep 0.1
  done
  asked[$1]=$((${asked[$1]:-0} + 1))
  sleep 0.3
  if grep -q "on 'datum3', measure" screen.txt && [ "$1" = "on 'datum1', measure" ] && [ "${asked[$1]}" -eq 1 ]; then
    fail "Enter that was typed before was taken for an answer: $(cat screen.txt)"
  fi
  printf '%s\n' "$2" >&4
}
declare -A asked
printf '\n\n\n\n' >&4
for monument in 1 2 3; do answer "on 'datum$monument', measure" ""; done
answer "back on the tool" ""
answer "on the tool at 't0'" "1000,1,1"
answer "on the tool at 't1'" ""
for monument in 1 2 3; do answer "on 'datum$monument', measure" ""; done
wait "$typed" || fail "$(cat screen.txt)"
exec 4>&-
grep -q "0 of 3, 2 places with a reading and 1 place without a reading left: t0" screen.txt || fail "$(cat screen.txt)"
grep -q "1 of 3, about .* left: t1" screen.txt || fail "$(cat screen.txt)"
grep -q "^t0,.*,1000.00000,1.00000,1.00000$" typed/tracker.csv || fail "$(cat typed/tracker.csv)"

expect 1 "nobody answers 'place the reflector on .*standard input" record --cell asked.yaml --out ended </dev/null
expect 1 "nobody answers 'place the reflector on .*standard input" record --cell asked.yaml --out closed <&-
expect 2 "2 rows of the plan ask for a tracker reading, 't0' of plan train first" record --cell none.yaml --out made
expect 1 "nowhere.csv: cannot be read .*tracker.path" record --cell file.yaml --out made
"$bin/planar-doctor" --cell file.yaml >out.txt 2>err.txt && fail "a missing file is well"
grep -q "faulty *tracker: .*nowhere.csv" out.txt || fail "the doctor does not name the file"

# A reflector that was bumped by 0.4 mm midway: nothing is written until a person accepts the step.
cp -r "$2/cell" calibrated
awk -F, -v OFS=, '/^train_/ { sub("train_", "", $1); if ($1 >= 20) $3 += 0.4; $1 = "train_" $1 } { print }' \
  "$2/recording/tracker.csv" >bumped.csv
pair() {
  "$bin/planar-pair-tracker" --cell calibrated/cell.yaml --lamps calibrated/lamps.csv --recording "$1" \
    --tracker bumped.csv --workplane-out w.yaml --tool-out t.yaml -o made "${@:2}"
}
expect 2 "from place 'train_[0-9]+' on, [0-9]+ of 40, .* mm at the end point: .* continue with --accept-step" pair "$2/recording"
expect 2 "accept-step" pair "$2/recording" --accept-step=maybe
pair "$2/recording" --accept-step >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "from place 'train_.*' on" err.txt || fail "an accepted step is not said: $(cat err.txt)"
grep -q "^train_39," made || fail "an accepted step costs pairs"
