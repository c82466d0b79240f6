# Sourced after common.sh: cells whose camera and drives device_host serves.
host=$bin/../tests/device_host/device_host
loopback_only=$repository/tests/support/loopback_only.sh

[ -x "$host" ] || {
  echo "skipped: device_host was not built: umockdev is not installed"
  exit 77
}
if [[ $(ldd "$host") == *libasan* ]]; then
  echo "skipped: umockdev's preloaded library and the address sanitizer's exclude each other"
  exit 77
fi

# live_cell VIRTUAL_CELL CAMERA [TRIGGER]: the same cell with a real camera (gige or usb) and real
# drives, as its owner would write it. A Tic makes 50,000 pulses a second at most. The home switches
# lie 1 deg below the joints' limits.
live_cell() {
  local where="id: HOSTED1"
  [ "$2" = usb ] || where="address: 127.0.0.1, id: HOSTED1, packet_size: 9000"
  local settings="exposure_us: 10000, gain_db: 0, pixel_format: Mono8, trigger: ${3:-software}"
  awk -v camera="source: aravis, $where, $settings," '
    /^virtual:/ { next }
    /joint_limits_deg:/ { split($0, limits, /[][, ]+/) }
    /source: virtual,/ { sub(/source: virtual,/, camera) }
    /kind: virtual,/ {
      n += 1
      home = "{reference: reverse_switch, at_deg: " (limits[2 * n + 1] - 1) "},"
      sub(/kind: virtual,/, "kind: tic, serial: \"0041000" n "\", command_timeout_ms: 1000, " \
                            "home: " home)
    }
    /max_speed_deg_s:/ { sub(/max_speed_deg_s: [0-9]+/, "max_speed_deg_s: " (n == 3 ? 36 : 18)) }
    { print }' "$1"
}

# hosted CAMERA OPTIONS... -- COMMAND...: runs a command against the cell in cell/ as real devices.
hosted() {
  local camera=$1
  shift
  {
    "$loopback_only" "$host" --cell cell/cell.yaml --camera "$camera" "$@" 2>&1 >&9 |
      sed -u '/uevent_sender/d' >&2
  } 9>&1
}

# live_twins: the calibrated cell in cell/ as cells with real devices.
live_twins() {
  live_cell cell/cell.yaml gige >cell/gige.yaml
  live_cell cell/cell.yaml usb >cell/usb.yaml
}

# value FILE KEY: a number of a JSON file.
value() {
  sed -n "s/^ *\"$2\": \([-0-9.e]*\),*$/\1/p" "$1"
}
