#!/usr/bin/env bash
# Targets as lines on standard input: one line of JSON each, at once; a bad line moves nothing.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .

# A dialogue: the next line is sent only when the last one has been answered.
mkfifo questions
: >answers
"$bin/planar-servo" --cell cell/cell.yaml --targets - --out run <questions >answers 2>err.txt &
servo=$!
exec 3>questions
ask() {
  local before
  before=$(wc -l <answers)
  echo "$1" >&3
  for _ in $(seq 600); do
    if [ "$(wc -l <answers)" -gt "$before" ]; then break; fi
    kill -0 "$servo" 2>/dev/null || fail "planar-servo ended early: $(cat err.txt)"
    sleep 0.1
  done
  tail -n 1 answers | grep -q -- "$2" || fail "'$1' was answered: $(tail -n 1 answers)"
}
ask "a,200,100" '^{"line":1,"target":"a",.*"status":"reached"'
steps=$(wc -l <run/steps.csv)
ask "b,abc,100" "^{\"line\":2,\"error\":\"standard input:2: x_mm is 'abc'; a finite number is needed\"}"
ask "b,0.2 m,100" "x_mm is '0.2 m'; a finite number is needed"
ask "a,200,100" "the id 'a' stands twice"
ask "far,900,0" '"target":"far",.*"status":"refused"'
[ "$(wc -l <run/steps.csv)" -eq "$steps" ] || fail "a bad line or a refused target moved the arm"
ask "b,-150,250,10" '"target":"b",.*"status":"reached"'
exec 3>&-
status=0
wait "$servo" || status=$?
[ "$status" -eq 1 ] || fail "a session with bad lines ended with $status"
grep -q "2 of 3 targets reached" err.txt || fail "no summary on standard error: $(cat err.txt)"
grep -q "^targets: 3" run/run.yaml || fail "no report of the session"
[ -e run/report.html ] || fail "no report.html"

# Whoever feeds the session was killed: a torn line moves nothing, and without 'end' the run did not end well.
status=0
printf 'A,200,100\nB,150,29' |
  "$bin/planar-servo" --cell cell/cell.yaml --targets - --out torn >answers 2>err.txt || status=$?
[ "$status" -eq 1 ] || fail "a torn line ended with $status"
grep -q '^{"line":2,"error":"standard input:2: the last line does not end' answers || fail "$(cat answers)"
grep -q "1 of 1 targets reached" err.txt || fail "a torn line was moved to: $(cat err.txt)"
require_end() { "$bin/planar-servo" --cell cell/cell.yaml --targets - --require-end --dry-run >answers 2>err.txt; }
printf 'A,200,100\nend\n' | require_end || fail "a stream that said its end failed: $(cat err.txt)"
status=0
printf 'A,200,100\n' | require_end || status=$?
[ "$status" -eq 1 ] || fail "a stream without its end ended with $status"
grep -q "standard input ended without the line 'end'" err.txt || fail "$(cat err.txt)"

# A reader who leaves ends the session at the first answer that nobody can read, not the program at once.
{
  status=0
  printf 'a,200,100\nb,-150,250\nc,100,300\n' |
    "$bin/planar-servo" --cell cell/cell.yaml --targets - --out left 2>left.err || status=$?
  echo "$status" >left.status
} | head -n 1 >left.answers
[ "$(cat left.status)" -eq 1 ] || fail "with nobody to read it ended with $(cat left.status): $(cat left.err)"
grep -q "the answers cannot be written" left.err || fail "$(cat left.err)"

# Standard streams that were closed are nobody else's: what is read there is not a device's.
mkfifo later
"$bin/planar-servo" --cell cell/cell.yaml --targets later --out closed <&- >&- 2>&- &
servo=$!
for stream in 0 1 2; do
  for _ in $(seq 100); do
    if [ "$(readlink "/proc/$servo/fd/$stream")" = /dev/null ]; then break; fi
    sleep 0.1
  done
  is=$(readlink "/proc/$servo/fd/$stream") || true
  [ "$is" = /dev/null ] || fail "the closed stream $stream became '$is'"
done
kill "$servo"

# A disc in metres protects nothing: said before anything moves.
sed 's/keep_out: \[\]/keep_out: [{x_mm: 0.2, y_mm: 0.1, radius_mm: 0.05}]/' cell/cell.yaml >cell/metres.yaml
printf 'a,200,100\n' | "$bin/planar-servo" --cell cell/metres.yaml --targets - --out disc >answers 2>err.txt
grep -q "metres.yaml: workspace.keep_out\[0\]: is at (0.2, 0.1) with the radius 0.05 mm; metres would be" err.txt ||
  fail "$(cat err.txt)"

# An id that would rename the terminal is shown, not obeyed.
printf 'id,x_mm,y_mm\na\033]0;b\007,900,0\n' >escape.csv
"$bin/planar-servo" --cell cell/cell.yaml --targets escape.csv --dry-run >plans 2>err.txt || true
printf 'a\033]0;b\007,9oo,0\n' | "$bin/planar-servo" --cell cell/cell.yaml --targets - --dry-run >>plans 2>>err.txt || true
printf 'id,x_mm,y_mm\na,\033[2J,0\n' >escape.csv
"$bin/planar-servo" --cell cell/cell.yaml --targets escape.csv --dry-run >>plans 2>>err.txt || true
if grep -q $'[\033\007]' plans err.txt; then fail "control characters were printed"; fi
grep -q 'a\\x1b\]0;b\\x07' plans || fail "$(cat plans)"
grep -q "x_mm is '\\\\x1b\[2J'" err.txt || fail "$(cat err.txt)"

# Planning only, and a header in other units: nothing moves.
printf 'id,x_mm,y_mm\na,200,100\n' |
  "$bin/planar-servo" --cell cell/cell.yaml --targets - --dry-run >plans 2>err.txt
grep -q '^{"line":2,"target":"a","status":"planned","theta_deg":\[' plans || fail "$(cat plans)"
printf 'id,x_mm,y_mm\na,0,450\nb,0,300\n' >targets.csv
"$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv --dry-run >plans 2>err.txt
if grep -q -- ' -0.0000 ' plans; then fail "a negative zero: $(cat plans)"; fi
printf 'a,200,100\n' | "$bin/planar-servo" --cell cell/cell.yaml --targets - --check >plans 2>err.txt
status=0
printf 'id,x_m,y_m\na,0.2,0.1\n' |
  "$bin/planar-servo" --cell cell/cell.yaml --targets - --out metres >answers 2>err.txt || status=$?
[ "$status" -eq 2 ] || fail "a header in metres ended with $status"
grep -q "lacks the columns x_mm, y_mm" answers || fail "$(cat answers)"
[ -z "$(ls metres)" ] || fail "a header in metres left $(ls metres)"
