#!/usr/bin/env bash
# Pairs as they come: repeated, in a line, mispaired, in metres, very many. Each gives a map or says why not.
source "$(dirname "$0")/common.sh"

header=id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm

# pairs N: N rows on a spiral with a smooth error and some noise of tracker and vision.
pairs() {
  awk -v n="$1" 'BEGIN {
    srand(7)
    for (i = 0; i < n; ++i) {
      r = 60 + 440 * i / n; a = 2.4 * i; x = r * cos(a); y = r * sin(a)
      ex = 0.3 * sin(x / 150) + 0.2 + 0.04 * (rand() - 0.5)
      ey = 0.25 * cos(y / 120) + 0.04 * (rand() - 0.5)
      printf "p%d,%.6f,%.6f,%.6f,%.6f\n", i, x, y, x - ex, y - ey
    }
  }'
}
pairs 200 >rows.csv

# table NAME: rows on standard input become NAME.csv.
table() { { echo "$header"; cat; } >"$1.csv"; }
fit() { "$bin/planar-fit-error-map" -o map.yaml --json map.json "$1.csv" >out.txt 2>err.txt; }
refused() { expect 2 "$2" "$bin/planar-fit-error-map" -o made "$1.csv"; }

# fitted NAME PATTERN...: there is a map, and the output has every pattern.
fitted() {
  local name=$1 pattern
  fit "$name" || fail "$name: $(cat err.txt)"
  ! grep -v "is written, but" err.txt || fail "$name wrote to standard error: $(cat err.txt)"
  if grep -Eq 'nan|inf' map.json map.yaml; then fail "$name: a figure is no number"; fi
  shift
  for pattern; do grep -Eq -- "$pattern" out.txt || fail "$name did not say '$pattern': $(cat out.txt)"; done
}

table good <rows.csv
fitted good "pairs used +200 \(0 rejected\)" "worth using"
cat rows.csv rows.csv | table duplicates
fitted duplicates "pairs used +400 \(0 rejected\)"
awk -F, -v OFS=, '{ print; $1 = "n" $1; $2 += 0.001; $4 += 0.001 + 0.02 * (NR % 3 - 1); print }' rows.csv |
  table near_duplicates
fitted near_duplicates "pairs used +400 \(0 rejected\)"
awk -F, -v OFS=, '{ ex = $2 - $4; ey = $3 - $5; $2 = 3 * NR - 300; $3 = 50; $4 = $2 - ex / 9; $5 = 50 - ey; print }' \
  rows.csv | table collinear
fitted collinear "pairs used +200"
head -n 3 rows.csv | table three
fitted three "pairs used +3" "NOT significant: do not use this map"
head -n 2 rows.csv | table two
refused two "2 pairs have 2 distinct positions; a map needs at least 3"
awk -F, -v OFS=, '{ $2 = 100; $3 = 100; $4 = 100.1; $5 = 99.9; print }' rows.csv | table one_place
refused one_place "have 1 distinct positions; a map needs at least 3"

sed '3s/,[^,]*/,nan/; 5s/[^,]*$/inf/; 7s/[^,]*$//; 8s/,[^,]*$//' rows.csv | table not_numbers
refused not_numbers "not_numbers.csv:4: x_vision_mm is 'nan'; a finite number is needed"
refused not_numbers "not_numbers.csv:6: y_tracker_mm is 'inf'"
refused not_numbers "not_numbers.csv:8: y_tracker_mm is ''"
refused not_numbers "not_numbers.csv:9: has 4 fields; the header has 5"

# mispaired FIRST LAST: the tracker's positions of these rows go round by one.
mispaired() {
  awk -F, -v OFS=, -v first="$1" -v last="$2" '
    { x[NR] = $4; y[NR] = $5; row[NR] = $1 OFS $2 OFS $3 }
    END {
      for (i = 1; i <= NR; ++i) {
        j = i < first || i > last ? i : i == last ? first : i + 1
        print row[i], x[j], y[j]
      }
    }' rows.csv
}
mispaired 40 41 | table two_mispaired
fitted two_mispaired "pairs used +198 \(2 rejected\)" "p39: .* mm from what the other pairs" "p40: "
mispaired 101 150 | table quarter_mispaired
refused quarter_mispaired "50 of 200 pairs disagree with the others, but at most 20 % may; are .* paired rightly"
mispaired 1 200 | table all_mispaired
refused all_mispaired "are x and y swapped, or rows paired wrongly"

metres='function m(v) { return v / 1000 }'
awk -F, -v OFS=, "$metres"' { print $1, m($2), m($3), m($4), m($5) }' rows.csv | table metres
refused metres "all positions lie within .* mm; they look like metres"
awk -F, -v OFS=, "$metres"' { print $1, $2, $3, m($4), m($5) }' rows.csv | table metres_of_tracker
refused metres_of_tracker "the narrower ones look like metres; write both in millimetres"
awk -F, -v OFS=, '{ print $1, $2, $3, $5, $4 }' rows.csv | table swapped
refused swapped "are x and y swapped"
fit good
expect 2 "are x and y swapped" "$bin/planar-check-error-map" map.yaml swapped.csv
expect 2 "look like metres" "$bin/planar-check-error-map" map.yaml metres.csv

# An error fixed in the tool's frame, with the tool in any direction.
{ echo "$header,phi_deg"; awk -F, -v OFS=, '
  { phi = NR * NR * 137 % 360; a = phi * atan2(0, -1) / 180
    print $1, $2, $3, $4 - 0.1 * cos(a), $5 - 0.1 * sin(a), phi }' rows.csv; } >turned.csv
fitted turned "in the tool's frame +0\.(09|10).* -?0\.00.* mm, used"
"$bin/planar-check-error-map" map.yaml turned.csv >out.txt || fail "turned pairs cannot be checked"
expect 2 "good.csv: the map depends on the tool's direction; pairs need a column phi_deg" \
  "$bin/planar-check-error-map" map.yaml good.csv

# Four readings within 3 mm at each of 100 places, with an error that a place shares.
awk -F, -v OFS=, 'NR % 2 {
  srand(NR); sx = 0.06 * (rand() - 0.5); sy = 0.06 * (rand() - 0.5)
  for (i = 0; i < 4; ++i) {
    x = $2 + 2 * int(i / 2); y = $3 + 2 * (i % 2); ox = 0.01 * (rand() - 0.5); oy = 0.01 * (rand() - 0.5)
    print $1 "_" i, x, y, x - ($2 - $4) - sx - ox, y - ($3 - $5) - sy - oy, $1
  }
}' rows.csv >at_places.csv
{ echo "$header,place"; cat at_places.csv; } >places_named.csv
fitted places_named "places +100, as named" "noise +0.0[12].* of a place, 0.00[23].* of a reading" "in a gap"
cut -d, -f1-5 at_places.csv | table places_found
fitted places_found "places +(9[5-9]|100), found from the pairs" "pairs used +400"
sed 's/[^,]*$/hall/; 1s/.*/'"$header"',place/' places_named.csv >one_hall.csv
refused one_hall "400 pairs have 1 distinct places; a map needs at least 3"
sed 's/_[0-9],\(.*\),p2$/_9,\1,p198/; 3s/p0$/p198/' places_named.csv >wide_place.csv
refused wide_place "place 'p198': its .* pairs lie up to .* mm apart, where .* mm is allowed"

sed 's/x_tracker_mm/x_traker_mm/' good.csv >typo.csv
refused typo "lacks the column x_tracker_mm; needed are .*; it has id,.* x_traker_mm"
expect 2 "absent/map.yaml: cannot be written: there is no folder 'absent'" \
  "$bin/planar-fit-error-map" -o absent/map.yaml good.csv
tr ',' '|' <good.csv >bars.csv
refused bars "it has id|x_vision_mm|"

expect 2 "./out.yaml: two outputs have this name" \
  "$bin/planar-fit-error-map" --cell cell.yaml -o out.yaml --arm-out ./out.yaml good.csv

# same_with_threads NAME: the map does not depend on how many there are.
same_with_threads() {
  for threads in 1 2 3; do
    OMP_NUM_THREADS=$threads "$bin/planar-fit-error-map" -o map.yaml "$1.csv" >out.txt
    grep -v '^created:' map.yaml >"threads_$threads.yaml"
  done
  cmp threads_1.yaml threads_2.yaml || fail "$1: with two threads there is another map"
  cmp threads_1.yaml threads_3.yaml || fail "$1: with three threads there is another map"
}
same_with_threads good
pairs 1200 | table sparse
same_with_threads sparse

# A scan that takes longer than the second after which a bar is drawn: the bar is for a terminal, and not
# for a log or a quiet run.
pairs 12000 | table scan
fitted scan "pairs used +12000" "method +sparse"
terminal() { script -qec "$bin/planar-fit-error-map $1 -o map.yaml scan.csv" /dev/null; }
terminal "" >terminal.txt
grep -q '[a-z] \[=* *\] ' terminal.txt || fail "no progress on a terminal"
terminal -q >terminal.txt
[ ! -s terminal.txt ] || fail "a quiet run says: $(cat terminal.txt)"

# A recording of few places, with a field that they do not resolve, as it was made: all of it is used.
cp "$repository"/tests/programs/few_places/* .
few=("$bin/planar-fit-error-map" --cell cell.yaml --arm-out arm.yaml -o map.yaml)
"${few[@]}" pairs.csv >few.txt
grep -q "readings used *42, .* (0 left out)" few.txt || fail "$(cat few.txt)"

# Readings of a reflector that slipped at more than every fifth place: the map is written, and nothing uses it
# unless told to.
awk -F, -v OFS=, '!/^#/ { if (++n % 5 == 0 || n % 20 == 2) { $4 += 2; $15 += 2 }; print }' pairs.csv >slipped.csv
expect 0 "map.yaml is written, but .* % of its poses contradict the others" "${few[@]}" slipped.csv
export=("$bin/planar-export-map" --format grid-csv --cell cell.yaml --phi-deg 0 map.yaml)
expect 2 "poses contradict the others" "${export[@]}" -o made
expect 0 "accepted: .* poses contradict the others" "${export[@]}" --accept-map -o grid.csv
