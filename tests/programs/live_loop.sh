#!/usr/bin/env bash
# The loop over GigE Vision or USB3 Vision and Pololu Tics ends as near to the targets as in process.
source "$(dirname "$0")/common.sh"
source "$repository/tests/programs/live_cell.sh"
camera=$3

cp -r "$2/cell" .
live_twins
printf 'id,x_mm,y_mm\na,420,100\nb,330,270\nc,270,310\nd,350,200\n' >targets.csv
"$bin/planar-servo" -q --cell cell/cell.yaml --targets targets.csv --out in_process \
  --json in_process.json >/dev/null
hosted "$camera" --score live --targets targets.csv --json live.json -- \
  "$bin/planar-servo" --cell "cell/$camera.yaml" --targets targets.csv --no-health --out live

[ "$(grep -c ',reached,' live/results.csv)" -eq 4 ] || fail "$(cat live/results.csv)"
# Each mean of four true errors scatters by 0.002 mm from the tracker's and the frames' noise.
awk -v live="$(value live.json after_mean_mm_truth)" \
    -v own="$(value in_process.json after_mean_mm_truth)" \
    'BEGIN { exit !(live > 0 && own > 0 && live - own < 0.008 && own - live < 0.008) }' ||
  fail "true mean errors: $(cat live.json in_process.json)"
if grep -q "truth\|virtual" live/run.yaml; then fail "the live run knows of a simulation"; fi

hosted "$camera" -- "$bin/planar-doctor" --cell "cell/$camera.yaml" >doctor.txt ||
  fail "$(cat doctor.txt)"
[ "$(grep -c '^well *\(drive [123]\|camera\):' doctor.txt)" -eq 4 ] || fail "$(cat doctor.txt)"
# How many of 26 MB come whole depends on the machine.
grep -q "frames: [1-9][0-9]* whole frames in 2 s" doctor.txt ||
  fail "$(cat doctor.txt)"
if [ "$camera" = gige ]; then
  sed -i "s#cell/gige.yaml#cell.yaml#" doctor.txt
  expect_sample doctor.txt "$bin/planar-doctor"
fi
