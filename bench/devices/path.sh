#!/usr/bin/env bash
# bench/devices/path.sh BIN_DIR
# Follows a path of 91 mm at 20 mm/s with a GigE Vision camera and Pololu Tics, emulated below the real libraries, and
# with the same cell in process, each with and without vision. It takes half a minute. On the
# wire time is real: the machine must have nothing else to do, or pictures are lost.
source "$(dirname "$0")/../../tests/programs/common.sh"
source "$repository/tests/programs/live_cell.sh"

calibrated_cell
live_twins
printf 'x_mm,y_mm,via_x_mm,via_y_mm\n260,200,,\n220,200,240,220\n240,180,,\n' >path.csv
follow=("$bin/planar-servo" --path path.csv --speed-mm-s 20 --compare --no-health)
echo "in process"
"${follow[@]}" --cell cell/cell.yaml --out in_process
echo "on the wire"
hosted gige -- "${follow[@]}" --cell cell/gige.yaml --out live
