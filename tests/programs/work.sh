#!/usr/bin/env bash
# work.sh BIN_DIR CELL_DIR: a workpiece is found by its marks, targets lie on it, and what is wrong with it is named.
source "$(dirname "$0")/common.sh"
cp -r "$2/cell" .
find_work=("$bin/planar-find-work" --cell cell/cell.yaml)
servo=("$bin/planar-servo" -q --cell cell/cell.yaml --no-health)

cat >work.csv <<'END'
id,x_mm,y_mm,kind,size_mm,z_mm,sigma_z_mm
F1,5,5,bright_disc,4,-10,0.05
F2,95,5,dark disc,4,-10,0.05
F3,95,65,ring,6,-10,0.05
F4,5,50,chess-corner,8,-10,0.05
END
cp cell/truth.yaml bare_truth.yaml
put() { # put AT [OPTION...]: the only work of the cell lies there
  cp bare_truth.yaml cell/truth.yaml
  "$bin/planar-virtual-cell" put --cell cell/cell.yaml --drawing work.csv --at "$@" >/dev/null
}

put 200,150,12
"${find_work[@]}" --drawing work.csv -o work.yaml --json found.json --report work.html >printed.txt 2>err.txt
expect_sample printed.txt "${find_work[0]}"
grep -q "data:image/jpeg" work.html || fail "the page has no picture"
grep -q "^<title>The picture, with a circle around each mark" work.html || fail "the page does not say what its picture shows"
python3 - <<'END' || fail "the work is not where it was put: $(cat found.json)"
import json, math
found = json.load(open("found.json"))
assert math.dist(found["origin_mm"], (200, 150)) < 0.1, found
assert abs(found["turn_deg"] - 12) < 0.03, found
END

printf 'id,x_mm,y_mm,phi_deg\nT1,20,20,\nT2,70,40,0\n' >targets.csv
expect 2 "targets.csv: is no DXF" "${servo[@]}" --work work.yaml --targets targets.csv --check --drawing-unit inch
"${servo[@]}" --work work.yaml --targets targets.csv --out run
python3 - <<'END' || fail "targets are not those of the drawing: $(cat run/results.csv)"
import csv, math
rows = list(csv.DictReader(line for line in open("run/results.csv") if line[0] != "#"))
turn = math.radians(12)
for row, (x, y) in zip(rows, ((20, 20), (70, 40))):
    at = (200 + x * math.cos(turn) - y * math.sin(turn), 150 + x * math.sin(turn) + y * math.cos(turn))
    assert math.dist((float(row["x_mm"]), float(row["y_mm"])), at) < 0.1, row
    assert 0 < float(row["sigma_target_mm"]) < float(row["uncertainty_mm"]), row
assert abs(float(rows[0]["phi_deg"])) < 1e-6 and abs(float(rows[1]["phi_deg"]) - 12) < 0.03, rows
END
grep -q "name: work.yaml" run/run.yaml || fail "the run does not name its work: $(cat run/run.yaml)"
"${servo[@]}" --work work.yaml --targets - --out streamed <<<"S,20,20" >answers.txt 2>err.txt
grep -q '"x_mm":215\.' answers.txt || fail "a target of a stream is not on the work: $(cat answers.txt)"
printf 'G90 G1 X20 Y20 F300\nG1 X60 Y20\nG2 X60 Y40 I0 J10\n' >part.nc
"${servo[@]}" --work work.yaml --path part.nc --check --json path.json >/dev/null
"${servo[@]}" --work work.yaml --path part.nc --speed-mm-s 30 --out path >/dev/null

# On the page: a drawing's targets for a tool, on a work found beside the cell; then what planar next says.
cp work.yaml work.csv cell/
# The visits to places of the calibration would take a minute of real time.
sed -e '/^health:/d' -e 's/^lamps: {/tools: {needle: needle.yaml}\nlamps: {/' cell/cell.yaml >cell/tools.yaml
printf 'id,x_mm,y_mm,phi_deg\n' >poses.csv
printf 'A,225,120,0\nB,250,145,-90\nC,275,120,180\n' >>poses.csv
"$bin/planar-teach-tool" -q --cell cell/cell.yaml -o cell/needle.yaml --poses poses.csv
PYTHONPATH=$repository/tests/support python3 -B - "$bin/planar-console" <<'END' || fail "the page does not work on a work: $(cat page.txt)"
import sys, urllib.error
from served_console import ServedConsole
with ServedConsole(sys.argv[1], "cell/tools.yaml") as page:
    table = page.ask("/api/table")
    assert table["works"] == ["work.yaml"] and table["tools"] == ["needle"], table
    for wrong, says in (({"work": "none.yaml"}, "there are work.yaml"), ({"tool": "nail"}, "known are needle")):
        try:
            page.ask("/api/targets", {"csv": "id,x_mm,y_mm\nA,20,20\n", **wrong})
            raise SystemExit(f"{wrong} was taken")
        except urllib.error.HTTPError as refused:
            assert refused.code == 400 and says in (said := refused.read().decode()), said
    sent = {"csv": "id,x_mm,y_mm\nA,20,20\n", "work": "work.yaml", "tool": "needle"}
    (target,) = page.ask("/api/targets", sent)["targets"]
    assert 215 < target["x_mm"] < 216 and target["tool"] == "", target
    assert page.ask("/api/table")["csv"].splitlines()[1].startswith("A,20"), page.ask("/api/table")
    page.ask("/api/command", {"line": "enable"})
    page.ask("/api/run", {"out": "page_run"})
    state = page.rests()
    open("page.txt", "w").write(str(state["job"]))
    assert state["job"]["ok"], state["job"]
    (result,) = page.ask("/api/results")
    assert abs(result["x_mm"] - target["x_mm"]) < 1e-3, result
    assert "sigma_target_mm" not in result or result["sigma_target_mm"] > 0, result
    at = "/api/place?x_mm=300&y_mm=100&phi_deg=0"
    p, tip = (page.ask(at + tool)["way_mm"][-1] for tool in ("", "&tool=needle"))
    assert p == [300, 100] and max(abs(a - b) for a, b in zip(p, tip)) > 1, (p, tip)
END
put 203,150,12
PYTHONPATH=$repository/tests/support python3 -B - "$bin/planar-console" <<'END' || fail "the page runs on a work that has moved: $(cat page.txt)"
import sys
from served_console import ServedConsole
with ServedConsole(sys.argv[1], "cell/tools.yaml") as page:
    page.ask("/api/targets", {"csv": "id,x_mm,y_mm\nA,20,20\n", "work": "work.yaml", "tool": ""})
    page.ask("/api/command", {"line": "enable"})
    page.ask("/api/run", {"out": "moved_run"})
    state = page.rests()
    open("page.txt", "w").write(str(state["job"]))
    assert not state["job"]["ok"] and "has moved" in state["held_by"], state
    assert page.ask("/api/results") == []
END
"$bin/planar-next" --cell cell/tools.yaml --json next.json >next.txt
grep -q "^done *tools" next.txt && grep -q "^done *workpiece" next.txt || fail "$(cat next.txt)"
grep -q "planar-servo .*--work cell/work.yaml --targets" next.json || fail "$(cat next.json)"
rm cell/needle.yaml
"$bin/planar-next" --cell cell/tools.yaml --json next.json >next.txt
grep -q "planar-teach-tool" next.json || fail "$(cat next.txt)"

# A small work, whose marks are below the lamps at its target.
printf 'id,x_mm,y_mm,kind,size_mm,z_mm,sigma_z_mm\nA,0,0,bright_disc,4,-10,0.05\nB,40,0,bright_disc,4,-10,0.05\n' >small.csv
cp bare_truth.yaml cell/truth.yaml
"$bin/planar-virtual-cell" put --cell cell/cell.yaml --drawing small.csv --at 250,150,0 >/dev/null
"${find_work[@]}" --drawing small.csv --near 250,150,0 -o small.yaml --report none >/dev/null 2>&1
printf 'id,x_mm,y_mm,phi_deg\nA,20,0,0\n' >between.csv
"${servo[@]}" --work small.yaml --targets between.csv --out below >out.txt 2>err.txt ||
  fail "a work that the arm hides ended the run: $(cat out.txt err.txt)"
grep -q ",reached," below/results.csv || fail "what the arm hides is doubted: $(cat below/results.csv)"

# A work that slides while it is worked on.
put 200,150,12 --slide 10,0.4,0,0
"${find_work[@]}" --drawing work.csv -o slid.yaml >/dev/null 2>&1
awk 'BEGIN { print "id,x_mm,y_mm"; for (i = 0; i < 8; ++i) print "T" i "," 20 + 5 * i ",30" }' >many.csv
status=0
"${servo[@]}" --work slid.yaml --targets many.csv --out doubted >out.txt 2>err.txt || status=$?
[ $status -eq 1 ] || fail "a work that slid ended the run with $status"
grep -q "has moved since it was found" doubted/report.html || fail "the report does not say that the work moved"
grep -q -- "--resume" err.txt doubted/report.html && fail "a run is to be resumed that would be refused: $(cat err.txt)"
grep -q "doubted" doubted/results.csv || fail "no target is doubted: $(cat doubted/results.csv)"
status=0
"${servo[@]}" --work slid.yaml --path part.nc --out slid_path >out.txt 2>err.txt || status=$?
[ $status -eq 1 ] && grep -q "has moved since it was found" out.txt err.txt || fail "a path on it ended with $status: $(cat out.txt err.txt)"

# Fixed lamps are looked for as the camera exposes, however long the marks are exposed.
cp -r "$repository/calib/workshop" fixed
"$bin/planar-virtual-cell" put --cell fixed/cell.yaml --drawing work.csv --at 200,150,12 >/dev/null
"$bin/planar-find-work" -q --cell fixed/cell.yaml --drawing work.csv -o fixed/work.yaml --exposure-ms 16 --report none
"$bin/planar-servo" -q --cell fixed/cell.yaml --no-health --work fixed/work.yaml --targets targets.csv --out fixed/run \
  >out.txt 2>err.txt || fail "a work with an exposure of its own ended the run: $(cat out.txt err.txt)"

# What is wrong is named, and no file is written.
made=("${find_work[@]}" -o made)
put 200,150,12 --slide 0.1,2,0,0
expect 1 "F[1-4] moves from picture to picture" "${made[@]}" --drawing work.csv
put 200,150,12
variant() { sed "$1" work.csv >other.csv; }
variant 's/95,65/95,65.4/'
expect 1 "F3 is 0\.[0-9]* mm from where" "${made[@]}" --drawing other.csv --drawing-sigma-mm 0.005
variant 's/,5,5,/,5,-5,/; s/,95,5,/,95,-5,/; s/,95,65,/,95,-65,/; s/,5,50,/,5,-50,/'
expect 1 "mirrored" "${made[@]}" --drawing other.csv
variant '$a F5,50,30,dark_disc,4,-10,0.05'
expect 1 "F5 is not seen" "${made[@]}" --drawing other.csv
variant 's/,95,/,120,/'
expect 1 "found nowhere|not seen|do not fit" "${made[@]}" --drawing other.csv
"${find_work[@]}" --drawing work.csv --no-error-map -o bare.yaml >/dev/null 2>&1
expect 2 "was found without the error map" "${servo[@]}" --work bare.yaml --targets targets.csv --out made
variant 's/bright_disc/blob/; s/F2/F1/'
expect 2 "other.csv:2.*no kind of mark" "${made[@]}" --drawing other.csv
expect 1 "near the given place" "${made[@]}" --drawing work.csv --near -200,150
expect 2 "work.csv" "${find_work[@]}" -o work.csv --drawing work.csv
put 200,150,12 --higher-mm 2
expect 1 "mm higher than z_mm" "${made[@]}" --drawing work.csv
"${find_work[@]}" -o shrunk.yaml --drawing work.csv --map similarity --drawing-sigma-mm 0.005 >/dev/null 2>&1
grep -q "map: similarity" shrunk.yaml || fail "no similarity was fitted"

# A file of another calibration moves nothing.
sed -i 's/rms_mm: .*/rms_mm: 0.0123/' cell/workplane.yaml
"$bin/planar-doctor" --seal cell/workplane.yaml >/dev/null
expect 2 "planar-find-work" "${servo[@]}" --accept-map --work work.yaml --targets targets.csv --out made
