#!/usr/bin/env bash
# A lamp that went out stops the servo with a reason, and nothing moves after it.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .

sed -i '0,/peak_level: .*/s//peak_level: 0/' cell/truth.yaml
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
expect 1 "the lamps are not seen: the whole frame does not show two of them" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv --out before
[ ! -s before/steps.csv ] || [ "$(grep -c '^a,' before/steps.csv)" -eq 0 ] || fail "a target was tried"
status=0
"$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv --no-health --out run >/dev/null 2>err.txt ||
  status=$?
[ "$status" -eq 1 ] || fail "a servo without a lamp ended with $status"
grep -q "a: lost_lamp: the tool was not measured: one_lamp" err.txt || fail "$(cat err.txt)"
[ "$(grep -c '^a,' run/steps.csv)" -eq 1 ] || fail "the arm moved on after a lamp was lost"
