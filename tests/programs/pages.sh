#!/usr/bin/env bash
# Pages: on a terminal beside the output, elsewhere only when asked for, and never in place of another file.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
ln -s "$2/recording" .
grid=(--grid circles:11x11:50mm)
views=(recording/images/grid_[1-4]_0.pgm)
calibrate_camera() { "$bin/planar-calibrate-camera" "${grid[@]}" -o camera.yaml "$@" "${views[@]}"; }

calibrate_camera >printed.txt
[ ! -e camera.html ] || fail "a page without a terminal, which nobody asked for"
script -qec "$bin/planar-calibrate-camera ${grid[*]} -o camera.yaml ${views[*]}" /dev/null >terminal.txt
grep -q "^<!DOCTYPE html>" camera.html || fail "no page on a terminal: $(cat terminal.txt)"
grep -q "camera.html" terminal.txt || fail "the page is not named: $(cat terminal.txt)"
mv camera.html first.html
script -qec "$bin/planar-calibrate-camera --report none ${grid[*]} -o camera.yaml ${views[*]}" /dev/null >terminal.txt
[ ! -e camera.html ] || fail "--report none made a page"

# The page has the figures that are printed, is the same again, and replaces an earlier one.
calibrate_camera --report first.html >again.txt 2>err.txt
cmp -s printed.txt again.txt || fail "a page changes what is printed"
calibrate_camera --report second.html 2>/dev/null >/dev/null
cmp -s first.html second.html || fail "two runs make different pages"
rms=$(sed -n 's/^residuals *\([0-9.]*\) px rms.*/\1/p' printed.txt)
grep -q "<td>$rms px rms" first.html || fail "the page lacks the rms $rms"

# What is no page stays; the name says that it is one.
expect 2 "camera.yaml: .*|--report is 'camera.yaml'; a name that ends in .html" calibrate_camera --report camera.yaml
echo "<html>mine</html>" >mine.html
expect 2 "mine.html: is a file of another program or of a person, which this output would replace" calibrate_camera --report mine.html
grep -q "mine" mine.html || fail "a page of somebody else was replaced"
expect 2 "there is no folder 'absent'" calibrate_camera --report absent/page.html
expect 2 "map.html: is the name of the page as well" "$bin/planar-fit-error-map" --report map.html \
  -o map.html cell/pairs.csv

# The other programs.
"$bin/planar-locate-lamps" -q --cell cell/cell.yaml --report lamps.html -o lamps.csv recording >/dev/null
"$bin/planar-pair-tracker" -q --cell cell/cell.yaml --lamps lamps.csv --recording recording \
  --workplane-out cell/workplane.yaml --tool-out cell/tool.yaml --report pairs.html -o pairs.csv >/dev/null
"$bin/planar-fit-error-map" -q --report map.html -o map.yaml pairs.csv >/dev/null
"$bin/planar-fit-error-map" -q --cell cell/cell.yaml --report field.html -o field.yaml pairs.csv >/dev/null
"$bin/planar-calibrate-arm" -q --cell cell/cell.yaml --report arm.html -o arm.yaml pairs.csv >/dev/null
for page in first lamps pairs map field arm; do
  grep -Eq '<b>(Good|To be mended):</b>' "$page.html" || fail "$page.html has no verdict"
  grep -q '<svg' "$page.html" || fail "$page.html has no figure"
  if grep -Eq 'src=|href=|<script' "$page.html"; then fail "$page.html needs something from outside"; fi
done
