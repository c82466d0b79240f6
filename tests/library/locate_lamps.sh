#!/usr/bin/env bash
# Both discs are found where they were drawn; the order is free, since nobody said which is first.
source "$(dirname "$0")/common.sh"

mapfile -t u < <(number 'center \(N,' | sort -g)
mapfile -t v < <(number 'center \([0-9.]+, N\)' | sort -g)
[ ${#u[@]} -eq 2 ] || { echo "FAILED: two centers are needed" >&2; exit 1; }
within "u of the left disc" 200.18 "${u[0]}" 200.195
within "v of the left disc" 150.68 "${v[0]}" 150.695
within "u of the right disc" 300.43 "${u[1]}" 300.445
within "v of the right disc" 179.93 "${v[1]}" 179.945
for diameter in $(number 'diameter N px'); do within "a diameter" 19.8 "$diameter" 20.2; done
