#!/usr/bin/env bash
# A path: what is refused before anything moves, what is left behind, and that vision helps.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
printf 'x_mm,y_mm,via_x_mm,via_y_mm\n260,200,,\n220,200,240,220\n240,180,,\n' >path.csv
servo=("$bin/planar-servo" --cell cell/cell.yaml)

# Wrong usage, wrong rows, ways that lead nowhere.
expect 2 "--targets|--path" "${servo[@]}" --path path.csv --targets path.csv --out made
expect 2 "--speed-mm-s requires --path" "${servo[@]}" --targets path.csv --speed-mm-s 5 --out made
expect 2 "speed 0.05 mm/s: a path is followed at 1 to 50 mm/s" \
  "${servo[@]}" --path path.csv --speed-mm-s 10,0.05 --out made
expect 2 "--out is needed" "${servo[@]}" --path path.csv
expect 2 "absent.csv" "${servo[@]}" --path absent.csv --out made
printf 'x_mm,y_mm\n0.2,0.2\n0.3,0.2\n' >metres.csv
expect 2 "metres.csv: cannot be followed at 10 mm/s: 0.0 mm along the path" \
  "${servo[@]}" --path metres.csv --out made
printf 'x_mm,y_mm\n400,0\n700,0\n' >far.csv
expect 2 "far.csv: cannot be followed at 10 mm/s: 1[0-9][0-9].[0-9] mm along the path, at \(5" \
  "${servo[@]}" --path far.csv --out made
printf 'G21 G90\nG0 X260 Y200 Z5\nG28\n' >tools.nc
expect 2 "tools.nc:2: moves Z.*" "${servo[@]}" --path tools.nc --out made
printf 'G21 G90 F6000\nG0 X260 Y200\nG1 X220\n' >fast.nc
expect 2 "fast.nc: its feed is 100 mm/s; .* name a speed with --speed-mm-s" "${servo[@]}" --path fast.nc --out made
printf '0\nSECTION\n2\nENTITIES\n0\nPOINT\n8\n0\n10\n260\n20\n200\n0\nENDSEC\n0\nEOF\n' >holes.dxf
expect 2 "holes.dxf: its header names no unit" "${servo[@]}" --targets holes.dxf --check
expect 2 "holes.dxf: has no way to follow" "${servo[@]}" --path holes.dxf --drawing-unit mm --out made
expect 2 "holes.dxf: nothing is drawn on a layer 'A'; there are 0" "${servo[@]}" --targets holes.dxf --layers A --check
expect 2 "--report draws what --check or --dry-run find" "${servo[@]}" --path fast.nc --report plan.html
[ ! -e made ] || fail "a refused path left a folder"

# Programs and drawings of others, drawn before anything moves.
printf '(an arc)\nG21 G90\nN1 G0 X260 Y200 F1200\nN2 G3 X220 Y200 I-20\n' >part.nc
"${servo[@]}" --path part.nc --check --report plan.html >checked.txt
grep -q "^part.nc: 62.8 mm" checked.txt && grep -q "^at 20 mm/s: " checked.txt || fail "$(cat checked.txt)"
grep -q "The path is 62.8 mm long" plan.html || fail "the page of a path"
"${servo[@]}" --targets holes.dxf --drawing-unit mm --check --report plan.html | grep -q "1 of 1 targets can be reached" ||
  fail "the points of a drawing"
grep -q "<td[^>]*>260.000</td>" plan.html || fail "the page of targets"
{
  head -n 12 holes.dxf
  printf '0\nLINE\n8\n0\n10\n%s\n20\n200\n11\n%s\n21\n200\n' 260 250 240 230
  printf '0\nENDSEC\n0\nEOF\n'
} >plate.dxf
"${servo[@]}" --path plate.dxf --drawing-unit mm --check 2>said.txt >checked.txt || fail "$(cat said.txt)"
grep -q "plate.dxf: its 2 parts do not meet: .* 10.0 mm" said.txt || fail "a gap in a path is not said: $(cat said.txt)"
"${servo[@]}" --targets plate.dxf --drawing-unit mm --check 2>said.txt >checked.txt || fail "$(cat said.txt)"
if grep "do not meet" said.txt; then fail "targets had to meet"; fi
cp part.nc kept.nc
expect 2 "kept.nc: is a file of another program" "${servo[@]}" --path part.nc --check --report kept.nc
cmp part.nc kept.nc || fail "a page replaced a program"
"${servo[@]}" --targets part.nc --dry-run | grep -q "^N2" || fail "the targets of a program"

"${servo[@]}" --path path.csv --speed-mm-s 10,50 --check >checked.txt
grep -q "^at 50 mm/s: .* s; motor [123] needs [0-9]* % of its speed" checked.txt ||
  fail "$(cat checked.txt)"

"${servo[@]}" --path path.csv --speed-mm-s 20 --compare --out both --json both.json >both.txt
for file in path_looks.csv path_results.csv run.yaml report.html; do
  [ -s "both/$file" ] || fail "no $file"
done
grep -q "path.csv: .* mm; deviation from the path, mm" both.txt || fail "$(cat both.txt)"
grep -q "^status_by_arm_at_20_mm_s: reached" both/run.yaml || fail "$(cat both/run.yaml)"
for panel in "By vision, in truth" "By the arm alone, as seen" "deviation drawn [0-9]* times its size"; do
  grep -q "$panel" both/report.html || fail "the page has no '$panel'"
done
# The arm alone comes first, then vision.
read -r alone seen < <(grep -o '"deviation_mean_mm_truth": [0-9.e-]*' both.json | cut -d' ' -f2 | paste -s -d' ')
awk -v seen="$seen" -v alone="$alone" 'BEGIN { exit !(seen > 0 && seen < 0.5 * alone) }' ||
  fail "vision does not help: $(cat both.txt)"
"${servo[@]}" --path path.csv --speed-mm-s 50 --no-vision --out alone >alone.txt
if grep -q "vision" alone/path_results.csv; then fail "$(cat alone.txt)"; fi
expect 2 "--no-vision excludes --compare" \
  "${servo[@]}" --path path.csv --no-vision --compare --out made
expect 2 "path_looks.csv: holds a run already" "${servo[@]}" --path path.csv --out both
sha256sum both/* >before.txt
printf 'id,x_mm,y_mm\na,260,200\n' >targets.csv
expect 2 "path_looks.csv: the folder holds the run of a path; name another folder" \
  "${servo[@]}" --targets targets.csv --out both
sha256sum --check --quiet before.txt || fail "a refused run changed the path's folder"
[ "$(ls both | wc -l)" -eq "$(wc -l <before.txt)" ] || fail "a refused run added to the path's: $(ls both)"
