#!/usr/bin/env bash
# With everything recorded and the truth deleted, every other program gives byte-identical output,
# but for `created:` lines and times.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" "$2/calibrated.txt" .
ln -s "$2/recording" recording
mv calibrated.txt with.txt
mkdir with && mv cell/*.json cell/{camera,workplane,tool,map}.yaml cell/*.csv with/

rm cell/truth.yaml
calibrate cell/cell.yaml recording cell >without.txt
mkdir without && mv cell/*.json cell/{camera,workplane,tool,map}.yaml cell/*.csv without/

for folder in with without; do
  sed -i '/^created:/d' $folder/*.yaml
  sed -i '/fit_seconds\|ms_per_image/d' $folder/*.json
done
sed -i '/ms per image/d' with.txt without.txt
diff -r with without || fail "the output depends on the truth"
diff with.txt without.txt || fail "what is printed depends on the truth"

# The virtual devices are the ones that need it, and say so.
cp without/* cell/
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
status=0
"$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv --out run >/dev/null 2>servo.err ||
  status=$?
[ "$status" -eq 2 ] || fail "planar-servo without a truth ended with $status"
grep -q "truth.yaml: cannot be read" servo.err || fail "planar-servo did not name the truth file"
[ ! -e run ] || fail "planar-servo left a run behind"
