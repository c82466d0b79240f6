#!/usr/bin/env bash
# tools.sh BIN_DIR CELL_DIR: a tool's tip off joint 3's axis is taught at a mark, goes to targets, and is missed when bent.
source "$(dirname "$0")/common.sh"
cp -r "$2/cell" .
teach=("$bin/planar-teach-tool" --cell cell/cell.yaml)

# poses OFFSET_X DIRECTION...: a tip at (30 + OFFSET_X, -4) mm is at the mark (250, 120) mm, to some micrometres.
poses() {
  local offset=$1
  shift
  printf '%s\n' "$@" | awk -v tx="$((30 + offset))" -v ty=-4 'BEGIN { print "id,x_mm,y_mm,phi_deg" } {
    a = $1 * 3.14159265358979 / 180
    printf "T%d,%.4f,%.4f,%g\n", NR, 250 - tx * cos(a) + ty * sin(a) + 0.004 * (NR % 3 - 1),
      120 - tx * sin(a) - ty * cos(a) + 0.003 * (NR % 2), $1
  }'
}
poses 0 0 90 180 270 >taught.csv
"${teach[@]}" -o cell/needle.yaml --poses taught.csv --json taught.json >printed.txt
expect_sample printed.txt "${teach[@]}"
python3 - <<'END' || fail "the tip is not where it was: $(cat taught.json)"
import json, math
taught = json.load(open("taught.json"))
assert math.dist(taught["p_TE_mm"], (30, -4)) < 0.01 and math.dist(taught["mark_mm"], (250, 120)) < 0.01, taught
END

# Its tip goes to targets, at different directions, while P goes elsewhere.
sed 's/^lamps: {/tools: {needle: needle.yaml}\nlamps: {/' cell/cell.yaml >cell/tools.yaml
printf 'id,x_mm,y_mm,phi_deg,tool\nA,200,100,0,needle\nB,200,100,135,needle\nC,200,100,0,\n' >targets.csv
"$bin/planar-servo" -q --no-health --cell cell/tools.yaml --targets targets.csv --out run
python3 - <<'END' || fail "a tip missed its target: $(cat run/results.csv)"
import csv
rows = list(csv.DictReader(line for line in open("run/results.csv") if line[0] != "#"))
assert all(float(row["after_truth_mm"]) < 0.1 and row["status"] == "reached" for row in rows), rows
steps = list(csv.DictReader(line for line in open("run/steps.csv") if line[0] != "#"))
last = {step["target"]: step for step in steps}
assert abs(float(last["A"]["x_believed_mm"]) - 170) < 0.5 and abs(float(last["C"]["x_believed_mm"]) - 200) < 0.1, last
END
grep -q "name: needle.yaml, sha256: .*, role: tool_tip" run/run.yaml || fail "the run does not name its tool: $(cat run/run.yaml)"
grep -q "^  frames_complete: [1-9][0-9]*$" run/run.yaml || fail "the figures lack what was counted: $(cat run/run.yaml)"
"$bin/planar-servo" -q --no-health --cell cell/tools.yaml --tool needle --targets - --out streamed <<<"S,200,100" >answers.txt
grep -q '"status":"reached"' answers.txt || fail "$(cat answers.txt)"

# One pose at the mark says whether the tip still is there.
poses 0 45 >again.csv
"${teach[@]}" --check cell/needle.yaml --poses again.csv >/dev/null
poses 1 45 >bent.csv
status=0
"${teach[@]}" --check cell/needle.yaml --poses bent.csv >out.txt || status=$?
[ $status -eq 1 ] && grep -q "no longer where" out.txt || fail "a bent tip ended with $status: $(cat out.txt)"

printf '%s\n' enable 'x 900' 'teach A' >refused.txt
expect 1 "a command failed, so the poses" "${teach[@]}" -o made <refused.txt
made=("${teach[@]}" -o made --poses)
poses 0 0 10 180 >two.csv
expect 2 "2 directions.*three are the least" "${made[@]}" two.csv
sed '3s/,[0-9.]*,/,230.0,/' taught.csv >slipped.csv
expect 1 "miss one mark by" "${made[@]}" slipped.csv
expect 2 "names no tool 'drill'; known are needle" \
  "$bin/planar-servo" -q --cell cell/tools.yaml --tool drill --targets targets.csv --out made
expect 2 "no tool 'needle'" "$bin/planar-servo" -q --cell cell/cell.yaml --tool needle --targets targets.csv --out made

# A lit disc at the tip gives its place by pictures at three directions, without a mark; a wrong height is told.
cp -r "$2/cell" lit
sed -i 's/^\( *\)reflector_mm:\(.*\)$/\1reflector_mm:\2\n\1tip_mm: [42, -15, -12]\n\1tip_diameter_mm: 6/' lit/truth.yaml
grep -q tip_mm lit/truth.yaml || fail "the truth has no tip: $(grep -n -A4 tool lit/truth.yaml)"
{
  echo enable
  for pose in 1 2 3; do
    printf 'teach at%s\nsave at%s.png\n' $pose $pose
    for _ in 1 2 3 4 5 6 7; do echo joint 3 15; done
  done
} >lines.txt
"$bin/planar-jog" --cell lit/cell.yaml --teach seen.csv <lines.txt >said.txt
seen=("$bin/planar-teach-tool" --cell lit/cell.yaml --seen bright_disc --poses seen.csv --image at1.png at2.png at3.png)
"${seen[@]}" --size-mm 6 --height-mm -12 -o lit/disc.yaml --json disc.json >said.txt 2>&1 || fail "$(cat said.txt)"
python3 - <<'END' || fail "the seen tip is not where it is: $(cat disc.json)"
import json, math
taught = json.load(open("disc.json"))
assert math.dist(taught["p_TE_mm"], (42, -15)) < 0.06, taught
END
expect 1 "as if it lay -[34][.]" "${seen[@]}" --size-mm 6 --height-mm -8 -o made
expect 1 "nothing of this kind and size but the lamps" "${seen[@]}" --height-mm -12 --size-mm 12 -o made
expect 2 "2 pictures for 3 poses" "$bin/planar-teach-tool" --cell lit/cell.yaml --seen bright_disc --size-mm 6 --height-mm -12 \
  --poses seen.csv --image at1.png at2.png -o made
