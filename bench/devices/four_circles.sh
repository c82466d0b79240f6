#!/usr/bin/env bash
# bench/devices/four_circles.sh BIN_DIR [OUT]
# Closes the loop over the paper's four circles with a GigE Vision and a USB3 Vision camera and with
# Pololu Tics, all emulated below the real libraries, and with the same cell in process. It takes ten
# minutes; FAST=N takes every N-th of the 100 targets.
source "$(dirname "$0")/../../tests/programs/common.sh"
source "$repository/tests/programs/live_cell.sh"
out=${2:-$PWD/four_circles}
[ $# -lt 2 ] || { mkdir -p "$2"; out=$(cd "$2" && pwd); }

mkdir cell && cp "$repository"/calib/paper/*.yaml cell/
"$bin/planar-experiment" --cell cell/cell.yaml --out in_process >in_process.txt
cp in_process/ours/*.yaml cell/
for camera in gige usb; do live_cell cell/cell.yaml $camera >cell/$camera.yaml; done
# The lens drifts on, so the live runs begin at the time at which the run in process began.
age=$(awk -F, '/^#/ { next } !n { for (i = 1; i <= NF; i++) column[$i] = i; n = 1; next }
               { print $column["t_s"]; exit }' in_process/ours/run/steps.csv)
grep -v '^#' in_process/ours/run/results.csv | cut -d, -f1-3 | sed '1s/target/id/' |
  awk -v every="${FAST:-1}" 'NR == 1 || (NR - 2) % every == 0' >targets.csv

grep "against the truth" in_process.txt | tail -n 1 | sed 's/^/in process: /'
for camera in gige usb; do
  hosted $camera --age "$age" --score $camera --targets targets.csv --json $camera.json -- \
    "$bin/planar-servo" --cell cell/$camera.yaml --targets targets.csv --out $camera |
    sed "s/^/$camera: /"
done
mkdir -p "$out" && cp -r in_process.txt ./*.json gige usb "$out/"
