#!/usr/bin/env bash
# A cell that has changed since its calibration is named and does not move on; one that has not passes.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
cp cell/truth.yaml sound.yaml
printf 'id,x_mm,y_mm\na,200,100\nb,-150,260\n' >targets.csv
check() { "$bin/planar-check-cell" --cell cell/cell.yaml --json check.json; }
servo() { "$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv "$@"; }

# spoilt KEY AWK: the truth with numbers of the list KEY changed by an awk program on $1, $2, ...
spoilt() {
  awk -v key="$1:" '$1 == key { print; found = 1; exit } END { exit !found }' sound.yaml >/dev/null ||
    fail "truth.yaml has no $1"
  sed -nE "s/^( *$1: \[)([^]]*)(\].*)$/\2/p" sound.yaml | head -1 >numbers.txt
  changed=$(awk -F', *' -v OFS=', ' "{ $2; print }" numbers.txt)
  sed -E "0,/^( *$1: \[)[^]]*\]/s//\1$changed]/" sound.yaml >cell/truth.yaml
}

check >out.txt || fail "$(cat out.txt)"
grep -q "as it was at its calibration" out.txt || fail "$(cat out.txt)"
grep -q '"healthy": *true' check.json || fail "$(cat check.json)"

# The arm strayed by 2 mm at one place of the calibration; nothing has moved since.
cp cell/health.yaml sound_health.yaml
awk '/lamp[12]_mm/ && n++ < 2 { sub(/\[/, ""); sub(/,/, ""); $2 += 2; print "    " $1 " [" $2 ", " $3; next } 1' \
  sound_health.yaml >cell/health.yaml
cmp -s cell/health.yaml sound_health.yaml && fail "the place was not changed"
"$bin/planar-doctor" -q --seal cell/health.yaml >/dev/null
check >out.txt 2>err.txt || fail "$(cat out.txt err.txt)"
grep -q "is not where it was, by 2.00. mm: the arm strayed there" err.txt || fail "$(cat err.txt)"
cp sound_health.yaml cell/health.yaml

# A nudge of the camera by half a millimetre.
spoilt translation_mm '$1 += 0.5'
status=0
check >out.txt || status=$?
[ $status -eq 1 ] || fail "check-cell ended with $status"
grep -Eq "the camera has shifted by 0\.(49[0-9]*|5|50[0-9]*) mm; what still holds: .*; what to do: " out.txt ||
  fail "$(cat out.txt)"
grep -q '"cause": *"the camera has shifted"' check.json || fail "$(cat check.json)"
expect 1 "the cell is not well: the camera has shifted" servo --out made
servo --no-health --out insisted >out.txt 2>err.txt || true
grep -q "health is not checked (--no-health)" err.txt || fail "$(cat err.txt)"

# A motor that was wired the other way, and one whose gear is another.
spoilt directions '$1 = -1'
expect 1 "the direction of joint 1 is reversed" servo --out made
spoilt gear_ratios '$2 = 101'
expect 1 "the gear ratio of joint 2 is wrong" servo --out made

# Somebody who insists drives into the guard: the cell is in doubt and no second target is tried.
spoilt translation_mm '$1 += 20'
status=0
servo --no-health --out doubted >out.txt 2>err.txt || status=$?
[ $status -eq 1 ] || fail "a doubted run ended with $status"
grep -q "a: held: the tool is seen at .* from where it was commanded" err.txt || fail "$(cat err.txt)"
grep -q "no further target was tried" err.txt || fail "$(cat err.txt)"
grep -q "^b," doubted/results.csv && fail "a second target was tried"
servo --no-health --keep-going --out going >out.txt 2>err.txt || true
grep -q "^b,.*,held," going/results.csv || fail "$(cat going/results.csv)"
printf 'a,200,100\nb,-150,260\n' |
  "$bin/planar-servo" --cell cell/cell.yaml --targets - --no-health --out stream >out.txt 2>err.txt || true
grep -q '"line":2,.*"status":"refused","reason":"the run has ended at a: held' out.txt || fail "$(cat out.txt)"

# A camera that drifts by 2.4 mm an hour: what was reached since the first look is doubted at the end, and visited again.
cp sound.yaml cell/truth.yaml
sed -i 's/^\( *px_per_h:\).*/\1 [10, 0]/' cell/truth.yaml
grep -q 'px_per_h: \[10, 0\]' cell/truth.yaml || printf 'drift:\n  px_per_h: [10, 0]\n' >>cell/truth.yaml
awk 'BEGIN { print "id,x_mm,y_mm"; for (i = 0; i < 40; ++i) printf "t%d,%.3f,%.3f\n", i, 250 * cos(2.4 * i), 250 * sin(2.4 * i) }' \
  >many.csv
status=0
"$bin/planar-servo" --cell cell/cell.yaml --targets many.csv --out drifted >out.txt 2>err.txt || status=$?
[ $status -eq 1 ] || fail "a run under a camera that drifts ended with $status: $(cat out.txt err.txt)"
grep -q "targets doubted: 40," err.txt || fail "$(cat err.txt)"
grep -q "the camera has shifted" err.txt || fail "$(cat err.txt)"
[ "$(grep -c ',doubted,' drifted/results.csv)" -eq 40 ] || fail "$(cat drifted/results.csv)"
[ -s drifted/report.html ] || fail "no report of a doubted run"
cp sound.yaml cell/truth.yaml
"$bin/planar-servo" --cell cell/cell.yaml --targets many.csv --out drifted --resume >out.txt 2>err.txt || fail "$(cat err.txt)"
[ "$(grep -c ',reached,' drifted/results.csv)" -eq 40 ] || fail "$(cat drifted/results.csv)"

# Nothing was kept: said, and the run continues without it.
cp sound.yaml cell/truth.yaml
rm cell/health.yaml
expect 2 "names no health file that exists" check
servo --out unknown >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "nobody can say what has moved since the calibration" err.txt || fail "$(cat err.txt)"
