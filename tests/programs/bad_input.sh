#!/usr/bin/env bash
# Wrong usage and input: exit status 2, a message that names what is wrong, no output left.
source "$(dirname "$0")/common.sh"

"$bin/planar-virtual-cell" -q draw --seed 3 -o cell >/dev/null
cp cell/cell.yaml cell_before.yaml
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
printf 'id,plan,x_mm,y_mm\nt1,train,200,100\n' >plan.csv
pairs_header=id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm

for program in "$bin"/planar-*; do
  expect 2 "^$(basename "$program"): (.+ (is|are) required|needs a subcommand: .+); --help" "$program"
  grep -q "Usage: $(basename "$program")" <("$program" --help) || fail "help of $program"
  grep -q "$(basename "$program") [0-9]" <("$program" --version) || fail "version of $program"
  expect 2 "^$(basename "$program"): .*not understood: --nonsense; --help" "$program" --nonsense
done

# planar knows every program, becomes the one that is named, and names what it may have meant.
"$bin/planar" >listed.txt
for program in "$bin"/planar-*; do
  grep -q "^$(basename "$program" | sed 's/^planar-//') .*\.$" listed.txt || fail "planar does not list $program"
done
[ "$(grep -c . listed.txt)" -eq "$(find "$bin" -name 'planar-*' | grep -c .)" ] || fail "$(cat listed.txt)"
"$bin/planar" help record | cmp - <("$bin/planar-record" --help) || fail "planar help record"
"$bin/planar" record --version | cmp - <("$bin/planar-record" --version) || fail "planar record --version"
expect 2 "^planar-record: --cell, --out are required; --help" "$bin/planar" record
for how in recrod "help recrod" "recrod --cell cell/cell.yaml"; do
  # shellcheck disable=SC2086
  expect 2 "^planar: there is no command 'recrod' \(did you mean record\?\); planar --help lists the commands" \
    "$bin/planar" $how
done
expect 2 "^planar: there is no command 'x/../record';" "$bin/planar" x/../record
expect 2 "^planar: not understood: --nonsense; --help" "$bin/planar" --nonsense
mkdir alone
cp "$bin/planar" alone
expect 1 "^planar: planar-record cannot be run: No such file or directory" env PATH=/usr/bin:/bin alone/planar record
PATH=$bin:$PATH alone/planar record --version | grep -q "^planar-record " || fail "planar does not search PATH"
printf 'not a program\n' >alone/planar-record
expect 1 "^planar: .*/planar-record cannot be run: Permission denied" alone/planar record

# Cell files: a key mistyped, a missing file, a number that is none, a range left.
sed 's/settle_ms/setle_ms/; s/gain: 1.0/gain: 7/' cell/cell.yaml >cell/wrong.yaml
expect 2 "wrong.yaml:[0-9]+:[0-9]+: unknown key 'servo.setle_ms'; allowed are" \
  "$bin/planar-servo" --cell cell/wrong.yaml --targets targets.csv --out made
expect 2 "servo.gain is 7; a positive number of at most 1" \
  "$bin/planar-servo" --cell cell/wrong.yaml --targets targets.csv --out made
expect 2 "absent.yaml: cannot be read" \
  "$bin/planar-record" --cell absent.yaml --plan plan.csv --out made
expect 2 "camera.yaml: does not exist yet; make it with planar-calibrate-camera" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv --out made

# Tables: empty, without a column, not a number, beyond reach.
: >empty.csv
expect 2 "empty.csv: is empty" "$bin/planar-fit-error-map" -o made empty.csv
echo "$pairs_header" >header.csv
expect 2 "header.csv: has no rows" "$bin/planar-fit-error-map" -o made header.csv
printf '%s\na,1,2,NaN,4\n' "$pairs_header" >nan.csv
expect 2 "nan.csv:2: x_tracker_mm is 'NaN'; a finite number is needed" \
  "$bin/planar-fit-error-map" -o made nan.csv
printf '%s\na,1,2,1,2\nb,3,4,3,4\n' "$pairs_header" >few.csv
expect 2 "2 pairs have 2 distinct positions; a map needs at least 3" "$bin/planar-fit-error-map" --out made few.csv
printf '%s\na,.1,.2,100,200\nb,.3,.1,300,100\nc,.2,.4,200,400\n' "$pairs_header" >one_unit.csv
expect 2 "look like metres; write both in millimetres" \
  "$bin/planar-fit-error-map" -o made one_unit.csv
expect 2 "--method is 'magic'; allowed are auto, rbf, idw, hand:WIDTH_MM" \
  "$bin/planar-fit-error-map" --method magic -o made few.csv
expect 2 "--arm-out requires --cell" "$bin/planar-fit-error-map" --arm-out made -o made few.csv
expect 2 "--method excludes --cell" \
  "$bin/planar-fit-error-map" --cell cell/cell.yaml --method rbf -o made few.csv
expect 2 "camera.yaml: does not exist yet; make it with planar-calibrate-camera" \
  "$bin/planar-fit-error-map" --cell cell/cell.yaml -o made few.csv
printf '%s,sigma_tracker_mm\np1,1,2,1,2,0.01\n' "$pairs_header" >no_joints.csv
expect 2 "pair 'p1' lacks its joints" \
  "$bin/planar-calibrate-arm" --cell cell/cell.yaml -o made no_joints.csv
printf 'id,theta1_deg,theta2_deg,theta3_deg,x_mm,y_mm,sigma_mm\na,1,2,3,4,5,0.01\n' >samples.csv
expect 2 "1 readings are too few to find an arm; 12 are needed" \
  "$bin/planar-calibrate-arm" --cell cell/cell.yaml -o made samples.csv
expect 2 "11 tracker readings are too few" \
  "$bin/planar-plan" --cell cell/cell.yaml --readings 11 -o made
sed 's/^tracker: {/tracker: {source: none, /' cell/cell.yaml >cell/untracked.yaml
expect 0 "untracked.yaml: names no tracker" "$bin/planar-plan" --cell cell/untracked.yaml --readings 40 -o untracked.csv
expect 2 "pair 'p1' lacks its lamps" \
  "$bin/planar-plan" --cell cell/cell.yaml --readings 5 --after no_joints.csv -o made
printf 'id,plan,x_mm,y_mm\nfar,train,900,0\nnear,train,10,0\n' >far.csv
for refused in "far': out of reach: the point lies farther from the base than both links" \
  "near': .* mm is 10.000 mm from the base; the workspace reaches from 60.000"; do
  expect 2 "plan row '$refused" "$bin/planar-record" --cell cell/cell.yaml --plan far.csv --out made
done
printf 'id,x_m,y_m\na,0.2,0.1\n' >metres.csv
expect 2 "lacks the columns x_mm, y_mm" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets metres.csv --out made

# A torn last line moves nothing; elsewhere it is doubted.
printf 'id,x_mm,y_mm\na,200,100\nb,150,29' >torn.csv
expect 2 "torn.csv:3: the last line does not end with a newline" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets torn.csv --out made
printf '%s\na,1,2,1,2\nb,3,4,3,4' "$pairs_header" >torn_pairs.csv
expect 2 "torn_pairs.csv:3: the last line does not end with a newline" \
  "$bin/planar-fit-error-map" -o made torn_pairs.csv
expect 2 "--require-end is for targets on standard input" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets targets.csv --out made --require-end

printf 'id|x_mm|y_mm\na|200|100\n' >bars.csv
expect 2 "it has id.x_mm.y_mm \(what separates columns is ','\)" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets bars.csv --out made
expect 2 "needs another --separator than ','" "$bin/planar-pair-tracker" --cell cell/cell.yaml \
  --lamps few.csv --recording cell --decimal-comma --workplane-out made --tool-out t.yaml -o p.csv

# Images: missing, not an image, without a lamp, of the wrong size, boards that are none.
expect 2 "absent.png: cannot be read: there is no such image or recording" \
  "$bin/planar-calibrate-camera" --grid circles:6x6:30mm -o made absent.png
expect 2 "grid 'circles:6x6' is not circles:COLSxROWS:PITCHmm" \
  "$bin/planar-calibrate-camera" --grid circles:6x6 -o made absent.png
expect 2 "--model: fisheye not in .*equidistant" \
  "$bin/planar-calibrate-camera" --grid circles:6x6:30mm --model fisheye -o made absent.png
head -c 65550 /dev/zero | sed '1s/^/P5 256 256 255\n/' >dark.pgm
expect 1 "no image shows what was looked for; dark.csv says why for each" \
  "$bin/planar-locate-lamps" -q -o dark.csv dark.pgm
grep -q "no_lamp" dark.csv || fail "a dark image has no lamp: $(cat dark.csv)"
expect 2 "absent.png: does not exist" "$bin/planar-locate-lamps" -o made absent.png
expect 2 "not understood: --lmaps \(did you mean --lamps\?\);" "$bin/planar-locate-lamps" -o made --lmaps 2 dark.pgm
head -c 100000 "$2/recording/images/grid_1_0.pgm" >cut.pgm
expect 2 "cut.pgm: cannot be read to its end as an image" \
  "$bin/planar-calibrate-camera" --grid circles:6x6:30mm -o made cut.pgm
[ "$(wc -l <err.txt)" -eq 1 ] || fail "a library spoke, too: $(cat err.txt)"
expect 2 "dark.pgm: is 256 x 256 pixels; the cell file says 5120 x 5120" \
  "$bin/planar-locate-lamps" --cell cell/cell.yaml -o made dark.pgm

# The doctor is no exception: what it cannot read is wrong input, what a cell lacks it says.
expect 2 "absent.yaml: cannot be read" "$bin/planar-doctor" --cell absent.yaml
expect 2 "unknown key 'servo.setle_ms'" "$bin/planar-doctor" --cell cell/wrong.yaml
"$bin/planar-doctor" --cell cell/cell.yaml >out.txt || fail "$(cat out.txt)"
grep -q "camera: is virtual; there is no device to examine" out.txt || fail "$(cat out.txt)"
"$bin/planar-doctor" -v --cell cell/cell.yaml 2>&1 >/dev/null |
  grep -q "^planar-doctor: reading cell/cell.yaml" || fail "-v does not name the file that is read"

# A camera that is not virtual needs its settings.
sed 's/source: virtual/source: aravis/' cell/cell.yaml >cell/aravis.yaml
expect 2 "camera lacks the key 'exposure_us'" \
  "$bin/planar-servo" --cell cell/aravis.yaml --targets targets.csv --check

# Nobody can type targets and stand at the tracker.
expect 2 "--judged asks a person at the terminal" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets - --judged --out made

# A target beyond reach is refused without motion.
printf 'id,x_mm,y_mm\nfar,900,0\n' >far_target.csv
status=0
"$bin/planar-servo" --cell cell/cell.yaml --targets far_target.csv --dry-run >out.txt || status=$?
[ "$status" -eq 1 ] || fail "a dry run to an unreachable target ended with $status"
grep -q "far: refused:" out.txt || fail "$(cat out.txt)"
printf 'id,x_mm,y_mm\nnear,10,0.1\n' >near_target.csv
status=0
"$bin/planar-servo" --cell cell/cell.yaml --targets near_target.csv --dry-run >out.txt || status=$?
[ "$status" -eq 1 ] || fail "a dry run to a target near the base ended with $status"
grep -q "near: refused: (10.000, 0.100) mm is 10.000 mm from the base; the workspace" out.txt ||
  fail "$(cat out.txt)"

# Targets in other units, and a plan in their place.
printf 'id,x_mm,y_mm\nnear,0.2,0.1\n' >metres.csv
expect 2 "metres.csv: no coordinate is larger than 0.2 mm, while .* metres would be such numbers; write millimetres" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets metres.csv --dry-run
printf 'id,x_mm,y_mm,phi_rad\na,200,100,1.57\n' >radians.csv
expect 2 "radians.csv: the column phi_rad is probably phi_deg \(in degrees\); write it so" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets radians.csv --out made
sed 's/phi_rad/phi_dge/' radians.csv >misspelt.csv
expect 2 "misspelt.csv: the column phi_dge is probably phi_deg" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets misspelt.csv --out made
sed -i 's/phi_rad/phi_deg/' radians.csv
"$bin/planar-servo" --cell cell/cell.yaml --targets radians.csv --dry-run >out.txt 2>err.txt || fail "$(cat err.txt)"
grep -q "radians.csv: phi_deg is at most 1.57 in every row; radians would be such numbers" err.txt || fail "$(cat err.txt)"
{
  printf 'id,plan,x_mm,y_mm\n'
  printf 'g%d,grid,,\n' 1 2 3 4 5
} >views.csv
expect 2 "views.csv: is a plan for planar-record, .*; a table of targets is needed" \
  "$bin/planar-servo" --cell cell/cell.yaml --targets views.csv --out made
[ "$(wc -l <err.txt)" -eq 1 ] || fail "a plan in place of targets is told more than once: $(cat err.txt)"
printf 'id,x_mm,y_mm\n' >no_numbers.csv
printf 't%d,"200 mm",100\n' 1 2 3 4 5 6 >>no_numbers.csv
expect 2 "^... and 3 more" "$bin/planar-servo" --cell cell/cell.yaml --targets no_numbers.csv --out made

expect 2 "is 'nan'; a number from -100000 to 100000" "$bin/planar-virtual-cell" put --cell cell/cell.yaml --drawing work.csv --at nan,0,0
expect 2 "AT_S of --slide: is -5; 0 s or later is needed" \
  "$bin/planar-virtual-cell" put --cell cell/cell.yaml --drawing work.csv --at 200,150,0 --slide=-5,1,0,0
# An output that is an input stays as it was.
printf '%s\na,1,2,1,2\nb,3,4,3,4\nc,5,1,5,1\n' "$pairs_header" >same.csv
cp same.csv before.csv
expect 2 "same.csv: is an input" "$bin/planar-fit-error-map" -o same.csv same.csv
cmp -s same.csv before.csv || fail "an input was overwritten"
expect 2 "cell.yaml: is a file of planar-servo/cell, which this output would replace" "$bin/planar-locate-lamps" --cell cell/cell.yaml \
  -o cell/cell.yaml dark.pgm
expect 2 "cell.yaml: is a file of planar-servo/cell, which this output would replace" \
  "$bin/planar-doctor" --cell cell/cell.yaml --json cell/cell.yaml
cmp -s cell/cell.yaml cell_before.yaml || fail "a cell file was overwritten"

# An output that cannot be written is refused before the work, and none of the others is written.
expect 2 "there is no folder 'absent'" "$bin/planar-fit-error-map" -o absent/map.yaml same.csv
expect 2 "cell: is a folder; name the file to write" "$bin/planar-fit-error-map" -o cell same.csv
expect 2 "there is no folder 'absent'" "$bin/planar-pair-tracker" --cell cell/cell.yaml \
  --lamps same.csv --recording cell --workplane-out made --tool-out absent/tool.yaml -o pairs.csv

# All required options that are missing are named at once, a subcommand's own ones as well.
expect 2 "^planar-record: --cell, --out are required; --help" "$bin/planar-record"
expect 2 "^planar-check-error-map: map, pairs are required;" "$bin/planar-check-error-map"
expect 2 "^planar-virtual-cell: --seed, --out are required;" "$bin/planar-virtual-cell" draw
expect 2 "^planar-virtual-cell: needs a subcommand: draw or put or serve; --help" "$bin/planar-virtual-cell"
expect 2 "needs a subcommand: draw or put or serve; not understood: drwa --seed 1 \(did you mean draw\?\);" \
  "$bin/planar-virtual-cell" drwa --seed 1
expect 2 "not understood: --lik=paper \(did you mean --like\?\);" \
  "$bin/planar-virtual-cell" draw --seed 1 --out made --lik=paper

# A subcommand's help is its own.
"$bin/planar-virtual-cell" serve --help >out.txt
grep -q "^Usage: planar-virtual-cell serve --cell" out.txt || fail "$(cat out.txt)"
if grep -q "draw" out.txt; then fail "the help of serve tells of draw: $(cat out.txt)"; fi

# An option mistyped is named, also where a required one is missing for it; units are not guessed.
expect 2 "^planar-record: --cell is required; not understood: --cel .* \(did you mean --cell\?\);" \
  "$bin/planar-record" --cel cell/cell.yaml --plan plan.csv --out made
expect 2 "^planar-record: not understood: --cel cell.yaml \(did you mean --cell\?\);" "$bin/planar-record" \
  --cell cell/cell.yaml --plan plan.csv --out made --cel cell.yaml
expect 2 "not understood: --target targets.csv --no_error_map \(did you mean --targets, --no-error-map\?\);" \
  "$bin/planar-servo" --cell cell/cell.yaml --path absent.csv --target targets.csv --no_error_map
# Where lengths are taken from a board, its pitch must be known; lays are of dots.
expect 2 "grid 'circles:6x6:\\?' has no pitch, but lengths depend on it here; measure the pitch" \
  "$bin/planar-calibrate-camera" --grid 'circles:6x6:?' -o made dark.pgm
lays() {
  "$bin/planar-pair-tracker" --cell cell/cell.yaml --lamps same.csv --recording cell \
    --workplane-out made --tool-out made -o made "$@"
}
expect 2 "grid 'circles:6x6:\?' has no pitch, but lengths depend on it" \
  lays --workplane-from grid --grid 'circles:6x6:?'
expect 2 "--lays-out needs a board of dots, not 'chessboard:6x6:30mm'" \
  lays --grid chessboard:6x6:30mm --lays-out made
expect 2 "--lays-out requires --grid" lays --lays-out made
expect 2 "--board-thickness-mm: is '2000'; a number from -1000 to 1000 is needed" \
  lays --grid circles:6x6:30mm --board-thickness-mm 2000

expect 2 "'circles:6x6:30' is not circles:COLSxROWS:PITCHmm" \
  "$bin/planar-calibrate-camera" --grid circles:6x6:30 -o made dark.pgm

# Boards and mounts on paper: what does not fit, what is not asked for rightly, what is not ours.
board() { "$bin/planar-board" "$@"; }
expect 2 "needs a page of 599 x 601 mm, but --page is 210 x 297 mm; the largest pitch that fits is 16.1 mm; the largest count at 50 mm is 3 x 4;" \
  board circles:11x11:50mm --page A4 -o board.pdf
expect 2 "board.png: is neither an .svg nor a .pdf" board circles:11x11:15mm -o board.png
expect 2 "grid 'circle:11x11:15mm' is not circles:COLSxROWS:PITCHmm" board circle:11x11:15mm -o board.pdf
expect 2 "tool needs --cell" board tool -o board.pdf
expect 2 "--cell is for the word tool" board circles:11x11:15mm --cell cell/cell.yaml -o board.pdf
expect 2 "--reflector-mm requires --cell" board tool --reflector-mm 1,2 -o board.pdf
expect 2 "lamp 2 and reflector overlap: their centres are 10.0 mm apart; place them at least 23.1 mm apart" \
  board tool --cell cell/cell.yaml --reflector-mm 14,-8 -o board.pdf
expect 2 "--ball-mm: is 'nan'; a number from 1 to 200 is needed" \
  board tool --cell cell/cell.yaml --ball-mm nan -o board.pdf
[ ! -e board.pdf ] || fail "a refused board was drawn"
printf '%%PDF-1.4\n%%%%EOF\n' >theirs.pdf
expect 2 "theirs.pdf: is a file of another program or of a person" board circles:11x11:15mm -o theirs.pdf
for file in board.pdf board.svg; do
  board circles:11x11:15mm -o $file >out.txt
  board circles:11x11:12mm -o $file >out.txt || fail "an earlier board cannot be drawn anew"
done
