#!/usr/bin/env bash
# vpServo brings the arm back to where it was taught, by the lamps alone.
source "$(dirname "$0")/common.sh"

within "the distance at first" 55 "$(number 'from N mm to')" 65
within "the distance at last" 0 "$(number 'mm to N mm')" 0.1
within "the angle at last" -0.1 "$(number 'and N deg')" 0.1
within "the frames" 20 "$(number 'in N frames')" 150
within "the lamps' error" 0 "$(number 'within N px')" 0.3
