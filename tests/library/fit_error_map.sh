#!/usr/bin/env bash
# The map removes nearly all of the error where it was never taught.
source "$(dirname "$0")/common.sh"

within "the places inside" 400 "$(number '^N places inside')" 500
within "the error before" 150 "$(number 'error N um before')" 400
within "the error after" 0.1 "$(number 'before, N um after')" 8
