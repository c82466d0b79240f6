#!/usr/bin/env bash
# Walks doc/first_cell.md: its commands, as they stand there but with fewer readings, lead from nothing to targets that
# are reached.
source "$(dirname "$0")/common.sh"

awk '/^```sh$/ { on = 1; next } /^```$/ { on = 0 } on' "$repository/doc/first_cell.md" |
  sed 's/--readings 160/--readings 60/' >walk.sh
[ "$(grep -c '^planar-' walk.sh)" -ge 10 ] || fail "the page has few commands: $(cat walk.sh)"
PATH=$bin:$PATH bash -eu walk.sh >said.txt 2>err.txt || fail "$(tail -n 5 said.txt err.txt)"
grep -Eq '^([0-9]+) of \1 targets reached' said.txt || fail "$(grep reached said.txt)"
