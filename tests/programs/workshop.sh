#!/usr/bin/env bash
# On the drifting cell in calib/workshop, fixed lamps keep the true error what it is without drift; without them
# the look at the cell stops the run before the drift costs anything.
# workshop.sh BIN_DIR [TARGETS]: a target takes four minutes of the cell's time; 126 are eight hours.
source "$(dirname "$0")/common.sh"
targets=${2:-30}

# Time passes in pauses: the arm settles for a minute after every move.
watched=$repository/calib/workshop
for kind in watched steady blind; do
  cp -r "$watched" $kind
  sed -i "s/settle_ms: 200/settle_ms: 60000/" $kind/cell.yaml
done
# Its truth without drift.
awk '/^drift:/ { print "drift: {px_per_h: [0, 0]}"; skip = 1; next } /^[a-z]/ { skip = 0 } !skip' \
  watched/truth.yaml >steady/truth.yaml
# Without what knows of the fixed lamps.
for file in cell workplane; do
  sed -i '/^reference_lamps:/,$d' blind/$file.yaml
done
awk -v n="$targets" 'BEGIN {
  print "id,x_mm,y_mm"
  for (i = 0; i < n; ++i) {
    r = sqrt(100 * 100 + (500 * 500 - 100 * 100) * (i + 0.5) / n); a = 2.4 * i
    printf "t%d,%.3f,%.3f\n", i, r * cos(a), r * sin(a)
  }
}' | sort -t, -k1,1 >targets.csv

mean_of() {
  "$bin/planar-servo" -q --cell "$1/cell.yaml" --targets targets.csv --out "$1/run" "${@:2}" \
    --json "$1.json" >/dev/null 2>&1 || true  # what drifts away from the map is not reached
  sed -nE 's/.*"after_mean_mm_truth": ([0-9.e-]+).*/\1/p' "$1.json"
}
with=$(mean_of watched)
without_drift=$(mean_of steady)
without_lamps=$(mean_of blind --accept-stale --no-health --keep-going)
hours=$(tail -n 1 watched/run/steps.csv | awk -F, '{ printf "%.1f", $3 / 3600 }')
echo "after $hours h: $with mm with fixed lamps, $without_lamps mm without," \
  "$without_drift mm where nothing drifts"
awk -v a="$with" -v b="$without_drift" 'BEGIN { exit !(a > 0 && b > 0 && a <= 1.2 * b) }' ||
  fail "with fixed lamps $with mm, without drift $without_drift mm"
expect 1 "the camera has shifted by 0.0[0-4]" "$bin/planar-servo" --cell blind/cell.yaml \
  --targets targets.csv --out blind/checked --accept-stale
awk -v a="$without_lamps" -v b="$without_drift" 'BEGIN { exit !(a > 3 * b) }' ||
  fail "the drift costs nothing: $without_lamps mm without fixed lamps"

# Its map at the end point does not tell the lens from the lamps, and the place of a work says so.
cat >work.csv <<'END'
id,x_mm,y_mm,kind,size_mm,z_mm
F1,5,5,dark_disc,6,0
F2,145,5,dark_disc,6,0
F3,145,95,dark_disc,6,0
F4,5,80,dark_disc,6,0
END
cp watched/truth.yaml bare.yaml
for at in 160,150,12 250,250,-45 100,-350,-20; do
  cp bare.yaml watched/truth.yaml
  "$bin/planar-virtual-cell" put --cell watched/cell.yaml --drawing work.csv --at $at >/dev/null
  "$bin/planar-find-work" -q --cell watched/cell.yaml --drawing work.csv -o work.yaml --json found.json
  python3 - $at <<'END' || fail "a work at $at is farther from there than three deviations: $(cat found.json)"
import json, math, sys
found, at = json.load(open("found.json")), [float(v) for v in sys.argv[1].split(",")]
assert math.dist(found["origin_mm"], at[:2]) < 3 * found["sigma_mm"], found
END
done
