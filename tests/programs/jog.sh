#!/usr/bin/env bash
# A cell moved by hand: what is taught can be servoed to; what is mistyped moves nothing.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" "$2/plan.csv" .

jog() { "$bin/planar-jog" -q --cell cell/cell.yaml "$@" >out.txt 2>err.txt; }
printf '%s\n' enable home 'joint 2 15' 'joint 2 15' 'x -20' 'y 5' look 'teach a' 'joint 1 10' 'teach b' |
  jog --teach taught.csv || fail "$(cat err.txt)"
grep -q "% of the lit pixels saturated: good" out.txt || fail "no meter: $(cat out.txt)"
grep -q "taught a at .* as seen" out.txt || fail "$(cat out.txt)"
"$bin/planar-servo" -q --cell cell/cell.yaml --targets taught.csv --out run >servo.txt ||
  fail "what was taught was not reached"
grep -q "2 of 2 targets reached" servo.txt || fail "$(cat servo.txt)"

# Typing errors: told, counted, and the arm stays; the session goes on to the last line.
cp taught.csv before.csv
status=0
printf '%s\n' enable where 'joint 2 5,0' 'x 10 mm' 'jonit 2 5' 'x 900' 'teach a' where quit 'x 5' |
  jog --teach taught.csv || status=$?
[ "$status" -eq 1 ] || fail "a session with typing errors ended with $status"
[ "$(wc -l <err.txt)" -eq 5 ] || fail "not every error was told: $(cat err.txt)"
[ "$(sort out.txt | uniq -c | awk '$1 == 2' | grep -c 'end point')" -eq 1 ] || fail "$(cat out.txt)"
cmp -s taught.csv before.csv || fail "a refused place was taught"

# A last command without its end may lack digits: refused.
status=0
printf 'enable\njoint 2 5\njoint 2 1' | jog || status=$?
[ "$status" -eq 1 ] || fail "a torn command ended with $status"
grep -q "'joint 2 1' does not end with a newline" err.txt || fail "$(cat err.txt)"
[ "$(grep -c '^joints' out.txt)" -eq 1 ] || fail "a torn command moved: $(cat out.txt)"

# Nothing taught, nothing written; an empty table is one without targets.
echo enable | jog --teach none.csv || fail "$(cat err.txt)"
[ ! -e none.csv ] || fail "a session that taught nothing left $(cat none.csv)"
: >empty.csv
printf '%s\n' enable 'joint 2 15' 'teach a' ' quit  now' | jog --teach empty.csv || fail "$(cat err.txt)"
"$bin/planar-servo" -q --cell cell/cell.yaml --targets empty.csv --dry-run >plans.txt || fail "$(cat plans.txt)"

status=0
echo enable | jog --teach plan.csv || status=$?
[ "$status" -eq 2 ] || fail "teaching into another table ended with $status"
