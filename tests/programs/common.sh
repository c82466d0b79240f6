# Sourced by the scripts beside it, which are called NAME.sh BIN_DIR [CELL_DIR ...]: a folder of its own,
# and a small plan that calibrates a cell.
set -euo pipefail
bin=$(cd "$1" && pwd)
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# expect STATUS PATTERN COMMAND...: the command's exit status and what it says on standard error.
expect() {
  local wanted=$1 pattern=$2 status=0
  shift 2
  "$@" >out.txt 2>err.txt || status=$?
  [ "$status" -eq "$wanted" ] || fail "$* ended with $status instead of $wanted: $(cat err.txt)"
  grep -Eq -- "$pattern" err.txt || fail "$* did not say '$pattern' but: $(cat err.txt)"
  [ ! -e made ] || fail "$* left output behind"
}

# on_screen TEXT: waits until screen.txt, a terminal's, shows it.
on_screen() {
  for _ in $(seq 300); do
    if grep -q -- "$1" screen.txt; then
      sleep 0.2 # keys that come before the next line of state are forgotten
      return
    fi
    sleep 0.1
  done
  fail "no '$1' on the screen: $(cat screen.txt)"
}

# Six board views, a board on the plane, a sweep of joint 3 and 40 training positions on a spiral.
small_plan() {
  echo "id,plan,x_mm,y_mm,phi_deg"
  for i in 1 2 3 4 5 6; do echo "grid_$i,grid,,,"; done
  echo "plane_1,plane_grid,,,"
  awk 'BEGIN {
    for (i = 0; i < 12; ++i) printf "sweep_%d,sweep3,0,300,%g\n", i, 30 * i - 180
    for (i = 0; i < 40; ++i) {
      r = 80 + 10 * i; a = 2.4 * i
      printf "train_%d,train,%.3f,%.3f,0\n", i, r * cos(a), r * sin(a)
    }
  }'
}

# made_up_pairs [ROW]: 200 pairs of a smooth error with noise; in this row the tracker is 3 mm off.
made_up_pairs() {
  awk -v off="${1:--1}" 'BEGIN {
    srand(1)
    print "id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm"
    for (i = 0; i < 200; ++i) {
      r = 60 + 2.4 * i; a = 2.4 * i; x = r * cos(a); y = r * sin(a)
      ex = 0.1 * sin(x / 90) * cos(y / 120) + 0.02 * (rand() - 0.5)
      ey = 0.08 * cos(x / 100) + 0.02 * (rand() - 0.5)
      if (i == off) ex += 3
      printf "p%d,%.4f,%.4f,%.4f,%.4f\n", i, x, y, x - ex, y - ey
    }
  }'
}

# From a recording to everything that the servo needs: calibrate CELL RECORDING OUT.
calibrate() {
  local cell=$1 recording=$2 out=$3
  "$bin/planar-calibrate-camera" --grid circles:11x11:50mm --model plumb_bob \
    -o "$out/camera.yaml" "$recording" --json "$out/camera.json"
  "$bin/planar-locate-lamps" --cell "$cell" -o "$out/lamps.csv" "$recording" \
    --json "$out/lamps.json"
  "$bin/planar-pair-tracker" --cell "$cell" --lamps "$out/lamps.csv" --recording "$recording" \
    --workplane-out "$out/workplane.yaml" --tool-out "$out/tool.yaml" \
    --grid circles:11x11:50mm --board-thickness-mm -5.5 --lays-out "$out/lays.csv" \
    --health-out "$out/health.yaml" -o "$out/pairs.csv" \
    --json "$out/pairs.json"
  "$bin/planar-fit-error-map" -o "$out/map.yaml" "$out/pairs.csv" --json "$out/map.json"
  "$bin/planar-check-error-map" --plan train "$out/map.yaml" "$out/pairs.csv" \
    --json "$out/check.json"
}

# In this folder: a drawn cell, its recording, and cell/ calibrated from it.
calibrated_cell() {
  "$bin/planar-virtual-cell" -q draw --seed 5 -o cell >/dev/null
  small_plan >plan.csv
  "$bin/planar-record" -q --cell cell/cell.yaml --plan plan.csv --out recording >/dev/null
  calibrate cell/cell.yaml recording cell >calibrated.txt
}

# What outputs of the same kind have in common: a number is N, a run of blanks is one blank.
masked() {
  sed -E 's/-?[0-9]+(\.[0-9]+)?/N/g; s/[[:space:]]+/ /g; s/^ //; s/ $//' "$@"
}

# expect_sample OUTPUT COMMAND...: each line of the sample in the command's --help is, but for its
# numbers, a line of the file OUTPUT.
expect_sample() {
  local output=$1
  shift
  "$@" --help | awk '/^(Options|Positionals):$/ { on = 0 } on && NF; /^Sample of the output:$/ { on = 1 }' |
    masked >sample.txt
  [ -s sample.txt ] || fail "$*: --help has no sample"
  masked "$output" >output.txt
  grep -vxFf output.txt sample.txt >never.txt || return 0
  fail "$*: --help shows what was not printed: $(cat never.txt output.txt)"
}
