#!/usr/bin/env bash
# Makes the calibrated cell that the scripts beside it copy: calibrated_cell.sh BIN_DIR CELL_DIR.
source "$(dirname "$0")/common.sh"

calibrated_cell
rm -rf "$2"
cp -r . "$2"
