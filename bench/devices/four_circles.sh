#!/usr/bin/env bash
# The paper's four circles over GigE Vision and USB3 Vision with Pololu Tics, emulated below the real
# libraries, beside the same run in process: bench/devices/four_circles.sh BIN_DIR [OUT]. Takes ten
# minutes; FAST=N takes every N-th of the 100 targets.
source "$(dirname "$0")/../../tests/programs/common.sh"
source "$repository/tests/programs/live_cell.sh"
out=${2:-$PWD/four_circles}
[ $# -lt 2 ] || { mkdir -p "$2"; out=$(cd "$2" && pwd); }

mkdir cell && cp "$repository"/calib/paper/*.yaml cell/
"$bin/planar-experiment" -q --cell cell/cell.yaml --out in_process >in_process.txt
cp in_process/ours/*.yaml cell/
for camera in gige usb; do live_cell cell/cell.yaml $camera >cell/$camera.yaml; done
# The lens goes on drifting: the live runs begin when the run in process did.
age=$(awk -F, '/^#/ { next } !n { for (i = 1; i <= NF; i++) column[$i] = i; n = 1; next }
               { print $column["t_s"]; exit }' in_process/ours/run/steps.csv)
grep -v '^#' in_process/ours/run/results.csv | cut -d, -f1-3 | sed '1s/target/id/' |
  awk -v every="${FAST:-1}" 'NR == 1 || (NR - 2) % every == 0' >targets.csv

grep "against the truth" in_process.txt | tail -n 1 | sed 's/^/in process: /'
for camera in gige usb; do
  hosted $camera --age "$age" --score $camera --targets targets.csv --json $camera.json -- \
    "$bin/planar-servo" -q --cell cell/$camera.yaml --targets targets.csv --out $camera |
    sed "s/^/$camera: /"
done
mkdir -p "$out" && cp -r in_process.txt ./*.json gige usb "$out/"
