# Sourced after common.sh: cells whose camera and drives device_host serves.
host=$bin/device_host
quiet_loopback=$(dirname "${BASH_SOURCE[0]}")/../support/loopback_only.sh

[ -x "$host" ] || { echo "skipped: device_host was not built: umockdev is missing"; exit 77; }

# live_cell VIRTUAL_CELL CAMERA [TRIGGER]: the same cell with a real camera (gige or usb) and real
# drives, as its owner would write it. A Tic makes 50,000 pulses a second at most.
live_cell() {
  local where="id: HOSTED1"
  [ "$2" = usb ] || where="address: 127.0.0.1, id: HOSTED1, packet_size: 9000"
  local settings="exposure_us: 10000, gain_db: 0, pixel_format: Mono8, trigger: ${3:-software}"
  awk -v camera="source: aravis, $where, $settings," '
    /^virtual:/ { next }
    /source: virtual,/ { sub(/source: virtual,/, camera) }
    /kind: virtual,/ {
      n += 1
      sub(/kind: virtual,/, "kind: tic, serial: \"0041000" n "\", command_timeout_ms: 1000, " \
                            "home: {reference: taught, at_deg: 0},")
    }
    /max_speed_deg_s:/ { sub(/max_speed_deg_s: [0-9]+/, "max_speed_deg_s: " (n == 3 ? 36 : 18)) }
    { print }' "$1"
}
