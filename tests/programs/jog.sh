#!/usr/bin/env bash
# A cell moved by hand: what is taught can be servoed to; what is mistyped moves nothing.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" "$2/plan.csv" .

jog() { "$bin/planar-jog" --cell cell/cell.yaml "$@" >out.txt 2>err.txt; }
printf '%s\n' enable home 'joint 2 15' 'joint 2 15' 'x -20' 'y 5' look 'teach a' 'joint 1 10' 'teach b' |
  jog --teach taught.csv || fail "$(cat err.txt)"
grep -q "% of the lit pixels saturated: good" out.txt || fail "no meter: $(cat out.txt)"
grep -q "taught a at .* as seen" out.txt || fail "$(cat out.txt)"
if grep -q $'\033' out.txt err.txt; then fail "lines of a terminal were drawn into a file"; fi
"$bin/planar-servo" --cell cell/cell.yaml --targets taught.csv --out run >servo.txt ||
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
"$bin/planar-servo" --cell cell/cell.yaml --targets empty.csv --dry-run >plans.txt || fail "$(cat plans.txt)"

status=0
echo enable | jog --teach plan.csv || status=$?
[ "$status" -eq 2 ] || fail "teaching into another table ended with $status"

# Back to what was taught, however far; a frame is saved under the first free name; and the lens' figures.
printf '%s\n' enable 'go b' find focus save save 'go c' | jog --teach taught.csv && fail "went to a place nobody taught"
grep -q "moved to b, .* mm, by the links of the cell file: joints" out.txt || fail "$(cat out.txt)"
grep -q "^edges .* px wide .*, best " out.txt || fail "$(cat out.txt)"
grep -q "no place 'c' is taught; there are a, b" err.txt || fail "$(cat err.txt)"
head -c 4 frame_2.png | grep -q PNG || fail "frame_2.png is no PNG"

if ! command -v script >/dev/null; then
  echo "script is not installed: a terminal was not tried"
  exit 0
fi
mkfifo keys
script -qec "$bin/planar-jog --cell cell/cell.yaml --teach taught.csv" /dev/null <keys >screen.txt 2>&1 &
jog=$!
exec 3>keys
on_screen "quit .* end the program"
printf 'enable\n' >&3
on_screen "the drives are on"
printf 'go b\n' >&3
on_screen "Enter stops the arm.*moved to b, .* by the links"
printf 'focus\n' >&3
on_screen "Enter ends this"
printf '\nquit\n' >&3
wait "$jog" || fail "$(cat screen.txt)"
exec 3>&-
