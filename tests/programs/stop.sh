#!/usr/bin/env bash
# Whoever presses Enter at planar-jog, Ctrl-C or Ctrl-\, or closes the terminal, stops the arm where it is: it knows its position and continues from there.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/live_cell.sh"

cp -r "$2/cell" .
live_twins
printf 'id,x_mm,y_mm\na,420,100\n' >targets.csv

resume=()
servo() {
  hosted gige --json figures.json "$@" -- "$bin/planar-servo" --cell cell/gige.yaml \
    --targets targets.csv --no-health --out run "${resume[@]}" 2>said.txt </dev/null
}
for fault in interrupt quit hang-up; do
  status=0
  servo --fault $fault || status=$?
  cat said.txt
  [ "$status" -eq 1 ] || fail "$fault: the run ended with $status"
  grep -q "the arm was stopped as asked" said.txt || fail "$fault: $(cat said.txt)"
  grep -q "\"fault\": \"$fault\"" figures.json || fail "no $fault: $(cat figures.json)"
  if grep -q '^a,' run/results.csv; then fail "$fault: the target has a result"; fi
  resume=(--resume)
done
# A row that was torn by a crash is no row.
printf 'a,200.0' >>run/results.csv
servo || fail "$(cat said.txt)"
grep -q '^a,.*,reached,' run/results.csv || fail "$(cat run/results.csv)"

if ! command -v script >/dev/null; then
  echo "script is not installed: a terminal was not tried"
  exit 0
fi
# 15 deg take three seconds; a slow camera's frames come in time on a busy machine, too.
sed -i -E 's/max_speed_deg_s: 18/max_speed_deg_s: 5/; s/frame_rate_hz: [0-9.]+/frame_rate_hz: 4/' cell/gige.yaml
mkfifo keys
hosted gige -- script -qec "$bin/planar-jog --cell cell/gige.yaml" /dev/null <keys >screen.txt 2>&1 &
jog=$!
exec 3>keys
on_screen "quit .* end the program"
printf 'enable\n' >&3
on_screen "know where they stand"
printf 'joint 1 -15\n' >&3
sleep 0.7
printf '\n' >&3
on_screen "stopped as asked; joints -[0-9]"
printf 'joint 1 -1\n' >&3
on_screen "^joints -[0-9]"
printf 'quit\n' >&3
wait "$jog" || fail "$(cat screen.txt)"
exec 3>&-
cat screen.txt
awk '/stopped as asked/ { sub(/.*joints /, ""); stopped = $1 }
     /^joints/ { after = $2 }
     END { exit !(stopped < -0.1 && stopped > -14.9 && after < stopped - 0.9 && after > stopped - 1.1) }' \
  screen.txt || fail "the arm was not stopped on its way, or lost its position"
