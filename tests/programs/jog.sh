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

# A command in a pipe that is mistyped or refused is told, and nothing behind it is done: it was meant for elsewhere.
cp taught.csv before.csv
for wrong in 'joint 2 5,0' 'x 10 mm' 'jonit 2 5' 'x 900' 'teach a'; do
  status=0
  printf '%s\n' enable where "$wrong" 'joint 2 5' 'teach Z' quit | jog --teach taught.csv || status=$?
  [ "$status" -eq 1 ] || fail "'$wrong' ended with $status"
  [ "$(grep -c 'no command after this one is done' err.txt)" -eq 1 ] || fail "'$wrong' was not told: $(cat err.txt)"
  [ "$(wc -l <err.txt)" -eq 1 ] || fail "after '$wrong' more was said: $(cat err.txt)"
  [ "$(grep -c 'end point' out.txt)" -eq 1 ] || fail "something was done after '$wrong': $(cat out.txt)"
  cmp -s taught.csv before.csv || fail "a place was taught after '$wrong'"
done
printf '%s\n' enable quit 'x 900' | jog || fail "a command behind quit was done: $(cat err.txt)"

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
# Who types sees what is refused, also where the answers go into a pipe: it is no failure.
printf '%s\n' 'jonit 2 5' where quit |
  script -qec "bash -o pipefail -c '$bin/planar-jog --cell cell/cell.yaml | cat'" /dev/null >screen.txt ||
  fail "$(cat screen.txt)"
grep -q "end point" screen.txt || fail "$(cat screen.txt)"
mkfifo keys
script -qec "$bin/planar-jog --cell cell/cell.yaml --teach taught.csv" /dev/null <keys >screen.txt 2>&1 &
jog=$!
exec 3>keys
on_screen "quit .* end the program"
printf 'enable\n' >&3
on_screen "the drives are on"
printf 'jonit 2 5\n' >&3
on_screen "there is no command 'jonit'"
printf 'go b\n' >&3
on_screen "Enter stops the arm.*moved to b, .* by the links"
printf 'focus\n' >&3
on_screen "Enter ends this"
printf '\nquit\n' >&3
wait "$jog" || fail "$(cat screen.txt)"
exec 3>&-
