#!/usr/bin/env bash
# A served cell is found sound, homed and recorded over its protocols, and the tracker's readings lie where the
# truth has the tool: loopback_only.sh served_cell.sh BIN_DIR.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/served.sh"

"$bin/planar-virtual-cell" -q draw --seed 5 -o cell >/dev/null
cp cell/cell.yaml kept.yaml
expect 2 "kept.yaml: holds something else already" \
  "$bin/planar-virtual-cell" serve --cell cell/cell.yaml --out made --truth-log kept.yaml
cmp cell/cell.yaml kept.yaml || fail "a cell file was added to"
[ ! -e made ] || fail "a cell that is not served has a cell file"
serve --cell cell/cell.yaml --out cell/live.yaml --truth-log truth.csv --tracker-clock=37,50
if grep -qi "truth\|virtual\|simul" cell/live.yaml; then fail "$(cat cell/live.yaml)"; fi
at_cell "bord hold 1"
tail -n 1 served.txt | grep -q "not understood: 'bord hold 1'; there are 'board hold N'" || fail "$(cat served.txt)"

# The cell file is written once, and it is sound.
expect 2 "live.yaml: exists already" \
  "$bin/planar-virtual-cell" serve --cell cell/cell.yaml --out cell/live.yaml
expect 2 "there is no folder 'absent'" \
  "$bin/planar-virtual-cell" serve --cell cell/cell.yaml --out absent/live.yaml
expect 2 "live.yaml: is no virtual cell" "$bin/planar-virtual-cell" serve --cell cell/live.yaml --out made
expect 2 "another program writes there" "$bin/planar-virtual-cell" serve --cell cell/cell.yaml --out made
"$bin/planar-virtual-cell" -q draw --seed 6 -o other >/dev/null
expect 1 "another camera has its port 3956" \
  "$bin/planar-virtual-cell" serve --cell other/cell.yaml --tracker file --out made
[ -e cell/grbl ] || fail "a second server took the first one's serial port away"
"$bin/planar-doctor" --cell cell/live.yaml >doctor.txt || fail "$(cat doctor.txt)"
for what in drives camera tracker; do
  grep -q "^well  *$what: " doctor.txt || fail "$what: $(cat doctor.txt)"
done

# Without homing nothing moves. With it three places are recorded, the monuments before and after.
printf 'id,plan,x_mm,y_mm,phi_deg\nt0,train,420,100,0\nt1,train,300,-250,0\nt2,train,350,200,0\n' >plan.csv
record() { timeout 120 "$bin/planar-record" -q --cell cell/live.yaml --plan plan.csv --out recording "$@"; }
status=0
operated unhomed.err record || status=$?
[ "$status" -eq 1 ] || fail "without homing the status is $status"
grep -q "lost their position: 1 2 3; start with --home" unhomed.err || fail "$(cat unhomed.err)"
[ "$(wc -l <truth.csv)" -eq 3 ] || fail "without homing the arm moved: $(cat truth.csv)"
operated recorded.err record --home >recorded.txt || fail "$(cat recorded.err)"
[ "$(grep -o '^t[0-9]' recording/frames.csv | uniq | wc -l)" -eq 3 ] || fail "$(cat recorded.txt)"

# The tool is not turned, so between two places the reflector moves as far as the end point; the reflector's arm
# of 15 mm turns by a few tenths of a degree. The tracker's clock is 37 s ahead of the truth's.
awk -F, '
  function far(a, b, c) { return sqrt(a * a + b * b + c * c) }
  NR == FNR { if ($1 + 0 > 0) { t[n] = $1; x[n] = $2; y[n++] = $3 } next }
  /^t[0-9]/ {
    last = -1
    for (i = 0; i < n; ++i) if (t[i] < $2 - 37) last = i
    if (last < 0) exit 1
    if (read++ > 0) {
      off = far($3 - rx, $4 - ry, $5 - rz) - far(x[last] - tx, y[last] - ty, 0)
      if (off > 0.2 || off < -0.2) { print $1, off; exit 1 }
    }
    rx = $3; ry = $4; rz = $5; tx = x[last]; ty = y[last]
  }
  END { if (read != 3) exit 1 }' truth.csv recording/tracker.csv >off.txt ||
  fail "$(cat off.txt truth.csv recording/tracker.csv)"
