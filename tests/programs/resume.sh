#!/usr/bin/env bash
# An interrupted recording and an interrupted run are continued; a finished run is not overwritten.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
sed '/^grid_[3-6]/d' "$2/plan.csv" >plan.csv
head -n 5 plan.csv >begin.csv
"$bin/planar-record" -q --cell cell/cell.yaml --plan begin.csv --out recording >/dev/null
"$bin/planar-record" --cell cell/cell.yaml --plan plan.csv --out recording >second.txt
grep -q "51 positions recorded (4 were there before)" second.txt || fail "$(cat second.txt)"
ids=$(tail -n +3 recording/frames.csv | cut -d, -f1 | sort -u | wc -l)
[ "$ids" -eq 55 ] || fail "$ids ids recorded instead of 55"
"$bin/planar-locate-lamps" -q --cell cell/cell.yaml -o lamps.csv recording
"$bin/planar-pair-tracker" -q --cell cell/cell.yaml --lamps lamps.csv --recording recording \
  --workplane-out workplane.yaml --tool-out tool.yaml -o pairs.csv
[ "$(grep -c ^train_ pairs.csv)" -eq 40 ] || fail "not every place that was recorded has its pair"

# A wrong grid is found out late, and told view by view.
expect 2 "grid_1_0.pgm: no grid of 5 x 5 dots found" "$bin/planar-experiment" \
  --cell cell/cell.yaml --out . --grid circles:5x5:50mm --predict

printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\n' >one.csv
printf 'id,x_mm,y_mm\na,200,100\nb,-150,250\nc,-200,-150\n' >all.csv
servo() { "$bin/planar-servo" -q --cell cell/cell.yaml --targets "$@"; }
servo one.csv --out run >/dev/null
if servo all.csv --out run >/dev/null 2>again.err; then fail "a finished run was overwritten"; fi
grep -q "holds a run already; name another folder or add --resume" again.err || fail "$(cat again.err)"
status=0
servo all.csv --out rnu --resume 2>again.err || status=$?
[ "$status" -eq 2 ] || fail "a mistyped folder was resumed with $status"
grep -q "rnu: holds no run to resume; name the folder of one, or leave out --resume" again.err ||
  fail "$(cat again.err)"
[ ! -e rnu ] || fail "a mistyped folder was made"
servo all.csv --out run --resume >/dev/null
grep -v '^#' run/results.csv | cut -d, -f1,4 | tail -n +2 >reached.txt
printf 'a,reached\nb,reached\nc,reached\n' | diff - reached.txt || fail "not all targets were reached"
grep -q "^targets: 3" run/run.yaml || fail "the report of a resumed run leaves targets out"

# Only the same run is continued: the same files, and every target where it was.
sed 's/^b,-150/b,-151/' all.csv >moved.csv
cp run/run.yaml run.yaml
cp run/results.csv results.csv
expect 2 "target 'b' is at \(-151.000, 250.000\) mm now; .* has a result of it at \(-150.000, 250.000\) mm; name another folder" \
  servo moved.csv --out run --resume
expect 2 "was begun with camera.yaml .*map.yaml .*; now it would continue with .*; use the same files" \
  servo all.csv --out run --resume --no-error-map
printf 'id,x_mm,y_mm,phi_deg\na,200,100,10\n' >turned.csv
expect 2 "target 'a' has the direction 10.000000 degrees now; .* has a result of it at 0.000000 degrees; name another folder" \
  servo turned.csv --out run --resume
cp cell/cell.yaml sound.yaml
sed -i 's/gain: 1.0/gain: 0.5/' cell/cell.yaml
expect 2 "was begun with the servo settings .*gain: 1, .*; now it would continue with .*gain: 0.5, .*; use the same settings" \
  servo all.csv --out run --resume
cp sound.yaml cell/cell.yaml
mkdir killed
cp run/steps.csv killed
servo one.csv --out killed --resume >/dev/null
[ "$(grep -c reached killed/results.csv)" -eq 2 ] || fail "a run killed before its first result did not go on"
servo all.csv --out run --resume >/dev/null
diff run.yaml run/run.yaml || fail "a finished run lost its account"
diff results.csv run/results.csv || fail "a finished run was moved again"
printf 'id,x_mm,y_mm\n"#1",200,100\n' >mark.csv
servo mark.csv --out mark >/dev/null
servo mark.csv --out mark --resume >/dev/null
[ "$(grep -c '#1' mark/results.csv)" -eq 1 ] || fail "an id that begins with # ran twice"
exec 9<run
flock 9
expect 2 "run: another program writes there now" servo all.csv --out run --resume
exec 9<&-

# Nothing is written through a link, and what is not ours stays as it is.
mkdir linked noted reported
printf 'no line end' | tee mine.txt noted/steps.csv >reported/run.yaml
ln -s ../mine.txt linked/steps.csv
expect 2 "linked/steps.csv: is a link, through which nothing is written" servo one.csv --out linked
expect 2 "noted/steps.csv: holds something else already" servo one.csv --out noted
expect 2 "--centre: vpdot2 may see lamps elsewhere than lamps.method auto" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets one.csv --out noted --centre vpdot2
expect 2 "reported/run.yaml: is a file of another program or of a person" servo one.csv --out reported
cp one.csv mine.csv
expect 2 "mine.csv: is a file of another program or of a person, which this output would replace" \
  "$bin/planar-plan" --cell cell/cell.yaml --readings 12 -o mine.csv
cmp -s one.csv mine.csv || fail "targets were replaced"
echo '{"mine": 1}' >mine.json
expect 2 "mine.json: is a file of another program or of a person" servo one.csv --check --json mine.json
for file in mine.txt noted/steps.csv reported/run.yaml; do
  [ "$(cat "$file")" = "no line end" ] || fail "$file was changed"
done
servo one.csv --check --json ours.json >/dev/null
servo one.csv --check --json ours.json >/dev/null
grep -q '"format": "planar-servo/figures/1"' ours.json || fail "$(cat ours.json)"

# No output replaces what people write, and none is counted that is not there.
cp cell/cell.yaml before.yaml
expect 2 "cell.yaml: is a file of planar-servo/cell, which this output would replace" \
  "$bin/planar-fit-error-map" -o cell/cell.yaml cell/pairs.csv
expect 2 "truth.yaml: is a file of planar-servo/truth" \
  "$bin/planar-locate-lamps" --cell cell/cell.yaml -o cell/truth.yaml recording
diff before.yaml cell/cell.yaml || fail "a cell was replaced"
status=0
(
  ulimit -f 64
  "$bin/planar-record" -q --cell cell/cell.yaml --plan begin.csv --out full >/dev/null 2>full.err
) || status=$?
[ "$status" -eq 1 ] || fail "a file that may grow no further ended with $status"
grep -q "images/grid_1_0.pgm: cannot be written; .*disk is not full" full.err || fail "$(cat full.err)"
if grep -q grid_1 full/frames.csv; then fail "an image that is not there was counted"; fi
[ -z "$(ls full/images)" ] || fail "half an image stayed: $(ls full/images)"
expect 1 "standard output cannot be written" bash -c \
  "'$bin/planar-servo' --cell cell/cell.yaml --targets all.csv --check >/dev/full"
if "$bin/planar-servo" --help >/dev/full; then fail "a lost --help counts as told"; fi
