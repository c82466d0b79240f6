#!/usr/bin/env bash
# A calibrated cell gets a certificate; one that was broken off is continued by the same command.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
size=(--cycles 3 --targets 12)
certify=("$bin/planar-certify" --cell cell/cell.yaml "${size[@]}")

"${certify[@]}" --out DIR --json figures.json >certified.txt || fail "$(cat certified.txt)"
expect_sample certified.txt "$bin/planar-certify"
cmp figures.json DIR/certificate.json || fail "--json is not certificate.json"
# Three cycles at five poses, at three poses from four sides, and the targets.
[ "$(grep -c '^[cvw][0-9]' DIR/cycles.csv)" -eq 63 ] || fail "$(cat DIR/cycles.csv)"
# The first pose and every direction have a place from which they begin.
[ "$(grep -c '^[cv][0-9.P+xy-]*\.from,' DIR/results.csv)" -eq 37 ] || fail "$(cut -d, -f1 DIR/results.csv)"
grep -q '"judge": "truth"' figures.json || fail "$(cat figures.json)"
sha=$(sha256sum cell/cell.yaml | cut -c1-64)
grep -q "$sha" figures.json || fail "the cell file's hash is missing: $(cat figures.json)"
for word in "<h1>Accuracy of the cell cell/cell.yaml" "<b>Good:</b> all 63 moves" "@page{size:A4" "${sha:0:16}" \
  ">signature<" ">field: error map<" "<svg"; do
  grep -qF "$word" DIR/certificate.html || fail "the page lacks $word"
done
if grep -Eq 'src=|href=|<script' DIR/certificate.html; then fail "the page needs something from outside"; fi

# The accuracy at P1 is that of its cycles in the table.
awk -F, '$2 == "pose" && $3 == "P1" { n += 1; x += $11; y += $12 } END { printf "%.5f\n", sqrt(x * x + y * y) / n }' \
  DIR/cycles.csv >by_hand.txt
sed -nE 's/.*"ap_mm": ([0-9.e-]+).*/\1/p' figures.json | head -n 1 | awk '{ printf "%.5f\n", $1 }' |
  diff - by_hand.txt || fail "AP is not that of the table"

# A finished certificate stays as it is.
cp -r DIR first
"${certify[@]}" --out DIR --json again.json >again.txt
diff certified.txt again.txt || fail "a finished certificate was made again"
"${certify[@]}" -q --out DIR >quiet.txt 2>&1
[ ! -s quiet.txt ] || fail "with -q it says: $(cat quiet.txt)"
diff -r first DIR || fail "a finished certificate changed"

# Broken off in the middle of a line, the same command continues where it ended.
cp -r first broken
head -n 30 first/cycles.csv >broken/cycles.csv
printf 'v01.P4+x,direc' >>broken/cycles.csv
rm broken/certificate.*
"${certify[@]}" --out broken >gone_on.txt || fail "$(cat gone_on.txt)"
cut -d, -f1 first/cycles.csv | diff - <(cut -d, -f1 broken/cycles.csv) || fail "other moves were made"
head -n 30 first/cycles.csv | diff - <(head -n 30 broken/cycles.csv) || fail "a judged move was made again"
[ -s broken/certificate.html ] || fail "no page after going on"

# Killed twice, a long one continues each time, and no move is in it twice.
long=("$bin/planar-certify" -q --cell cell/cell.yaml --out killed --cycles 1000 --targets 1)
rows() { cat killed/cycles.csv 2>/dev/null | grep -c '^[cv][0-9]' || true; }
before=0
for _ in 1 2; do
  "${long[@]}" >/dev/null 2>killed.err &
  for _ in $(seq 600); do
    if [ "$(rows)" -gt $((before + 20)) ]; then break; fi
    sleep 0.1
  done
  kill -KILL $! || fail "ended by itself: $(cat killed.err)"
  wait $! 2>/dev/null || true
  [ "$(rows)" -gt $((before + 20)) ] || fail "no further moves: $(cat killed.err)"
  before=$(rows)
done
[ -z "$(cut -d, -f1 killed/cycles.csv | sort | uniq -d)" ] || fail "a move was made twice"

# Only the same certificate is continued.
certify_as() { "$bin/planar-certify" --cell cell/cell.yaml "$@"; }
expect 2 "cycles.csv: was begun with other --cycles or --targets" certify_as --cycles 4 --targets 12 --out DIR
sed 's/settle_ms: 200/settle_ms: 210/' cell/cell.yaml >cell/other.yaml
expect 2 "before the cell file was changed" \
  "$bin/planar-certify" --cell cell/other.yaml "${size[@]}" --out DIR
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
"$bin/planar-servo" -q --cell cell/cell.yaml --targets targets.csv --out run >/dev/null
expect 2 "results.csv: belongs to no certificate; name another folder" "${certify[@]}" --out run

# Wrong input is refused before anything moves.
expect 2 "--cycles: Value 0 not in range" certify_as --cycles 0 --out made
expect 2 "--targets: Value -1 not in range" certify_as --targets -1 --out made
expect 2 "--cycles: .*3mm" certify_as --cycles 3mm --out made
expect 2 "^planar-certify: --cell is required; not understood: --cel" "$bin/planar-certify" --cel cell/cell.yaml --out made
mv cell/map.yaml map.yaml
expect 2 "map.yaml: does not exist yet; make it with planar-fit-error-map" "${certify[@]}" --out made
mv map.yaml cell/map.yaml
sed -i 's/^rms_px: .*/rms_px: 0.1/' cell/camera.yaml
"$bin/planar-doctor" -q --seal cell/camera.yaml >/dev/null
expect 2 "workplane.yaml: was made with camera.yaml" "${certify[@]}" --out made
expect 2 "results.csv: the run was begun with camera.yaml .* now it would continue with" \
  "${certify[@]}" --accept-stale --out DIR
"${certify[@]}" --accept-stale --out stale >/dev/null 2>err.txt || fail "$(cat err.txt)"
[ "$(grep -c "accepted: .*workplane.yaml" err.txt)" -eq 1 ] || fail "$(cat err.txt)"
grep -q "<b>To be mended:</b>.*workplane.yaml: was made with camera.yaml" stale/certificate.html || fail "the page hides it"

# A real cell that nobody can judge.
cp "$2/cell/camera.yaml" cell/camera.yaml
awk '/^virtual:/ || /^tracker:/ { next }
  /source: virtual,/ { sub(/source: virtual,/, "source: aravis, exposure_us: 10000, gain_db: 0, pixel_format: Mono8, trigger: software,") }
  /kind: virtual,/ { n += 1
    sub(/kind: virtual,/, "kind: tic, serial: \"0041000" n "\", command_timeout_ms: 1000, home: {reference: reverse_switch, at_deg: -500},")
    sub(/max_speed_deg_s: [0-9]+/, "max_speed_deg_s: " (n == 3 ? 36 : 18)) }
  { print }
  END { print "tracker: {source: none, sigma_mm: 0.01, sigma_mm_per_m: 0.0}" }' cell/cell.yaml >cell/real.yaml
expect 2 "real.yaml: nobody can judge this cell, .* tracker.source is none; set up the tracker" \
  "$bin/planar-certify" --cell cell/real.yaml --out made
