#!/usr/bin/env bash
# An error map for other programs: what is written, what they read of it, what is refused. PROJ's cct and NumPy
# read it where they are installed; else the test counts as skipped.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
made_up_pairs >pairs.csv
"$bin/planar-fit-error-map" -o map.yaml pairs.csv >fitted.txt

export_map() { "$bin/planar-export-map" "$@"; }
export_map --format grid-csv -o grid.csv map.yaml --json figures.json >exported.txt
for format in numpy opencv-remap; do
  export_map --format $format -o "grid.$format" map.yaml >"$format.txt"
  grep -q "^interpolation .* [0-9]\.[0-9] % of the deviation there at most" "$format.txt" || fail "$(cat "$format.txt")"
done
export_map --format numpy -o grid.numpy map.yaml >again.txt || fail "an earlier grid cannot be written anew"
grep -q "^nodes *compensated places; seen = compensated + error" opencv-remap.txt || fail "$(cat opencv-remap.txt)"
sum=$(grep -v -e ^created: -e ^checksum: -e ^edited_by_hand: map.yaml | sha256sum | cut -c1-64)
for file in grid.*; do grep -aq "$sum" "$file" || fail "$file does not say from which map it was made"; done

# Back as pairs: the same map, within a tenth of what it states.
"$bin/planar-fit-error-map" -o back.yaml grid.csv >back.txt
export_map --format grid-csv --step-mm 7 -o fine.csv map.yaml >out.txt
"$bin/planar-check-error-map" back.yaml fine.csv --json check.json >check.txt
figure() { sed -n "s/.*\"$1\": *\([-0-9.e]*\).*/\1/p" "$2"; }
awk -v max="$(figure max_mm check.json)" -v sigma="$(figure sigma_min_mm figures.json)" \
  'BEGIN { exit !(max > 0 && max < 0.1 * sigma) }' || fail "a map comes back from its grid with $(cat check.txt)"

# A field at the lamps needs its cell and, where it matters, the tool's direction.
"$bin/planar-fit-error-map" --cell cell/cell.yaml -o field.yaml cell/pairs.csv >out.txt
expect 2 "field.yaml: is a field at the lamps; name the cell that has them with --cell" \
  export_map --format numpy -o made field.yaml
export_map --format numpy --cell cell/cell.yaml --phi-deg 30 --accept-map -o field.npy field.yaml >out.txt
grep -q "^direction *tool at 30.0 deg" out.txt || fail "$(cat out.txt)"

expect 2 "made.npz: names an archive of arrays.*; name it .npy" export_map --format numpy -o made.npz map.yaml
expect 2 "--format: magic not in" export_map --format magic -o made map.yaml
expect 2 "map.yaml: is an input of this program" export_map --format numpy -o map.yaml map.yaml
echo 2,2 >theirs.txt
expect 2 "theirs.txt: is a file of another program or of a person" export_map --format numpy -o theirs.txt map.yaml
expect 2 "a step of 200 mm costs up to .* of the map's deviation there; at most 0.1 is allowed" \
  export_map --format numpy --step-mm 200 -o made map.yaml
expect 2 "a grid of 0.01 mm over its valid region has .* nodes; at most 100000 are written" \
  export_map --format numpy --step-mm 0.01 -o made map.yaml
expect 2 "--step-mm: is '-1'; a number from 0.001 to 1000 is needed" export_map --format numpy --step-mm -1 -o made map.yaml
expect 2 "--step-mm: is 'nan'; a number from 0.001 to 1000 is needed" export_map --format numpy --step-mm nan -o made map.yaml
expect 2 "--phi-deg: is 'nan'; a number from -360 to 360 is needed" export_map --format numpy --phi-deg nan -o made map.yaml
expect 2 "pairs.csv: is not a map" export_map --format numpy -o made pairs.csv
sed 's/worth_using: true/worth_using: false/; /^checksum/d' map.yaml >doubtful.yaml
expect 2 "doubtful.yaml: its fit says not to use it.*--accept-map" export_map --format numpy -o made doubtful.yaml
printf 'x_mm,y_mm,dx_mm,dy_mm\n0,0,nan,0\n' >nan.csv
expect 2 "nan.csv:2: dx_mm is 'nan'; a finite number is needed" "$bin/planar-fit-error-map" -o made nan.csv

if ! command -v cct >/dev/null || ! /usr/bin/python3 -c 'import numpy' 2>/dev/null; then
  echo "skipped: no cct of proj-bin, or no python3-numpy"
  exit 77
fi

# PROJ compensates places within the valid region as the map does, and refuses others.
/usr/bin/python3 -B "$repository/examples/python/tinshift_of_map.py" grid.numpy grid.json
grep -q "$sum" grid.json || fail "grid.json does not say from which map it was made"
awk -F, '$1 != "x_mm" && !/^#/ && $1 * $1 + $2 * $2 < 400 * 400 { print $1, $2, 0 }' fine.csv >seen.txt
awk -F, '$1 != "x_mm" && !/^#/ && $1 * $1 + $2 * $2 < 400 * 400 { printf "%.7f %.7f %s\n", $1 - $3, $2 - $4, $5 }' fine.csv >compensated.txt
cct -d 6 +proj=tinshift "+file=$work/grid.json" seen.txt >cct.txt || fail "cct: $(head -n 3 cct.txt)"
worst=$(paste -d' ' cct.txt compensated.txt | awk '
  { w1 = ($1 - $5) / $7; w2 = ($2 - $6) / $7
    if (w1 < 0) w1 = -w1; if (w2 < 0) w2 = -w2; if (w1 > w) w = w1; if (w2 > w) w = w2 }
  END { print (NR > 1000 ? w : 99) }')
awk -v w="$worst" 'BEGIN { exit !(w > 0 && w < 0.1) }' || fail "cct errs by $worst of the deviation: $(head -n 3 cct.txt)"
echo "4000 0 0" | cct +proj=tinshift "+file=$work/grid.json" 2>&1 | grep -q ERROR || fail "cct goes beyond"

# NumPy has the values of the table.
export_map --format numpy --step-mm 7 -o fine.npy map.yaml >out.txt
/usr/bin/python3 - <<'PYTHON' || fail "NumPy reads other values"
import numpy
grid = numpy.load("fine.npy")
rows = [row for row in open("fine.csv") if not row.startswith("#")]
table = numpy.genfromtxt(rows, delimiter=",", names=True)
assert grid.ndim == 2 and grid.size == table.size
for name in ("x_mm", "y_mm", "dx_mm", "dy_mm", "sigma_mm", "valid"):
    assert numpy.abs(grid[name].ravel() - table[name]).max() < 1e-6, name
assert (numpy.diff(grid["x_mm"], axis=1) > 6.99).all()
PYTHON
