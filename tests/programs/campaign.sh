#!/usr/bin/env bash
# A campaign's figures are the same whoever found them: one process, several, the ranks of mpirun, or the same
# command again after some were killed.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
campaign=("$bin/planar-experiment" --cell cell/cell.yaml --train 40 --loop-only 5 --seed 501 --seeds 2)
export ASAN_OPTIONS=detect_leaks=0  # of mpirun's libraries
ranks=(mpirun --allow-run-as-root --oversubscribe -n 3 "${campaign[@]}")

# until_recording FOLDER: waits until a cell of the campaign is being recorded.
until_recording() {
  for _ in $(seq 3000); do
    if compgen -G "$1/seed_*/recording/images/*_0.pgm" >/dev/null; then return; fi
    sleep 0.1
  done
  fail "no cell of $1 was recorded in five minutes"
}

"${campaign[@]}" --jobs 1 --out one --json one.json >one.txt
grep -q "^ *seed 502 " one.txt || fail "$(cat one.txt)"
[ "$(ls one)" = "$(printf 'figures.json\nreport.html\nrows.jsonl')" ] || fail "left over: $(ls one)"

# Killed with all its processes, a campaign leaves nobody at work and continues by the same command.
"${campaign[@]}" --jobs 2 --out shared >/dev/null &
until_recording shared
kill -KILL $!
wait $! 2>/dev/null || true
if command -v mpirun >/dev/null; then
  "${ranks[@]}" --out shared >/dev/null 2>killed.err &
  mpirun=$!
  rank=
  for _ in $(seq 600); do
    rank=$(pgrep -P "$mpirun" | tail -n 1) || true
    if [ -n "$rank" ]; then break; fi
    sleep 0.1
  done
  kill -KILL "$rank"
  if wait "$mpirun"; then fail "a rank was killed, and mpirun ended well"; fi
  "${ranks[@]}" --out shared --json shared.json >shared.txt
  expect 2 "--jobs does not go with mpirun" "${ranks[@]}" --out made --jobs 2
else
  "${campaign[@]}" --jobs 2 --out shared --json shared.json >shared.txt
fi
cmp one.json shared.json || fail "the figures depend on who found them"
diff one.txt <(sed 's#shared/#one/#' shared.txt) || fail "the table depends on who found it"
[ ! -e shared/seed_501 ] && [ ! -e shared/seed_502 ] || fail "a cell stayed: $(ls shared)"

# What is there is not run again, and only the same campaign is continued.
"${campaign[@]}" --out one --json again.json >/dev/null
cmp one.json again.json || fail "a finished campaign changed"
expect 2 "rows.jsonl: was begun with another cell or other options: lays 1, now 2; give the same" \
  "${campaign[@]}" --out one --lays 2
expect 2 "rows.jsonl: was begun with another cell or other options: like paper, now rough; give the same" \
  "${campaign[@]}" --out one --like rough
expect 2 "--like requires --seeds" "$bin/planar-experiment" --cell cell/cell.yaml --out made --like rough
# An experiment that cannot begin leaves its cell behind, which is of the kind that was asked for.
sed 's/joint_limits_deg: .* home_deg/joint_limits_deg: [[-1, 1], [59, 61], [-1, 1]], home_deg/' cell/cell.yaml >cell/stiff.yaml
expect 2 "motor 1 would turn to .* its limits are" \
  "$bin/planar-experiment" --cell cell/stiff.yaml --out rough --seeds 1 --jobs 1 --like rough
grep -q "^outliers:" rough/seed_1/truth.yaml || fail "no rough cell was drawn: $(cat rough/seed_1/truth.yaml)"
expect 2 "holds a recording or a campaign already" \
  "$bin/planar-experiment" --cell cell/cell.yaml --out one
expect 2 "states links of 150 and 100 mm and a sensor of .*; the cells that --seeds draws have links of about 300" \
  "$bin/planar-experiment" --cell "$repository/calib/small/cell.yaml" --out made --seeds 2
expect 2 "--jobs" "${campaign[@]}" --out made --jobs 0
expect 2 "--seed 4294967295: the last of 2 seeds would be beyond 4294967295" \
  "$bin/planar-experiment" --cell cell/cell.yaml --out made --seed 4294967295 --seeds 2
expect 2 "mpirun shares the cells of --seeds" \
  env PMI_RANK=0 "$bin/planar-experiment" --cell cell/cell.yaml --out made
