#!/usr/bin/env bash
# bench/devices/latency.sh BIN_DIR [gige|usb]
# Measures the time from an exposure to the pulses that correct for it, with a GigE Vision and a USB3
# Vision camera and with Pololu Tics, all emulated below the real libraries, both with the region that
# follows the lamps and with full frames. It takes three minutes.
source "$(dirname "$0")/../../tests/programs/common.sh"
source "$repository/tests/programs/live_cell.sh"

calibrated_cell
live_twins
# The loop makes many small corrections, each from one frame.
awk 'BEGIN { print "id,x_mm,y_mm"; for (i = 0; i < 20; ++i)
     printf "t%d,%.3f,%.3f\n", i, 200 + 40 * cos(2.4 * i), 150 + 40 * sin(2.4 * i) }' >targets.csv
for camera in ${2:-gige usb}; do
  for region in 512 5120; do
    sed -e "s/follow_region_px: 512/follow_region_px: $region/" -e 's/gain: 1.0/gain: 0.3/' \
      -e 's/max_iterations: 12/max_iterations: 30/' -e 's/settle_ms: 200/settle_ms: 0/' \
      -e 's/frames_per_measurement: 3/frames_per_measurement: 1/' -e 's/approach: one_side/approach: direct/' \
      "cell/$camera.yaml" >"cell/$camera$region.yaml"
    # A target whose error grows by noise fails, but its corrections count all the same.
    hosted "$camera" --score "$camera$region" --targets targets.csv -- \
      "$bin/planar-servo" --cell "cell/$camera$region.yaml" --targets targets.csv \
      --out "$camera$region" >said.txt || true
    grep -q "^from exposure" said.txt || fail "$(cat said.txt)"
    sed -n "s/^from exposure/$camera, region of $region px: &/p" said.txt
  done
done
