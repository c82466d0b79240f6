#!/usr/bin/env bash
# Every target is reached, and by its own view within the tolerance of the cell.
source "$(dirname "$0")/common.sh"

[ "$(grep -c ': reached after' <<<"$printed")" -eq 3 ] || { echo "FAILED: not all reached" >&2; exit 1; }
for away in $(number 'N mm away'); do within "the distance by its own view" 0 "$away" 0.02; done
for truth in $(number 'N mm in truth'); do within "the true distance" 0 "$truth" 0.1; done
