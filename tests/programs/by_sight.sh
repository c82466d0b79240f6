#!/usr/bin/env bash
# by_sight.sh BIN_DIR CELL_DIR: an arm whose drives know nothing finds by sight how it stands, or refuses to guess.
source "$(dirname "$0")/common.sh"
cp -r "$2/cell" .
sed -i 's/direction: 1,/direction: 1, home: {reference: sight},/' cell/cell.yaml
printf 'id,x_mm,y_mm\nA,200,100\n' >targets.csv
servo=("$bin/planar-servo" --no-health --cell cell/cell.yaml --targets targets.csv)

standing() { # standing THETA...: where the arm stands when it is switched on
  python3 - "$@" <<'END'
import re, sys
text = re.sub(r"^  home_deg: .*\n", "", open("cell/truth.yaml").read(), flags=re.M)
open("cell/truth.yaml", "w").write(text.replace("arm:\n", f"arm:\n  home_deg: [{', '.join(sys.argv[1:])}]\n", 1))
END
}
n=0
# The last stands 8 mm beyond the workspace.
for theta in "20, 110, 40" "-60, 30, 200" "150, 260, 10" "75, -20, -130" "10, 58, 100"; do
  standing "$theta"
  n=$((n + 1))
  status=0
  "${servo[@]}" --home --nearest-turn --out "run$n" >out.txt 2>err.txt || status=$?
  # The log says what the tests turned; zeros of the arm are some 0.3 deg off.
  python3 - "$theta" <<'END' || fail "from $theta the arm was not homed: $(cat err.txt out.txt)"
import re, sys
said = open("err.txt").read()
joints = re.search(r"homed by sight: joints (\S+) (\S+) (\S+) deg", said).groups()
two = sum(map(float, re.findall(r"motor 2 turns by (\S+) deg", said)))
three = sum(map(float, re.findall(r"motor 3 turns by (\S+) deg", said)))
stood = [float(angle) for angle in sys.argv[1].split(",")]
for seen, stands in zip(joints, (stood[0], stood[1] + two, stood[2] + two + three)):
    assert abs((float(seen) - stands + 180) % 360 - 180) < 1, (joints, stood, two, three)
END
  ! grep "no room" err.txt || fail "at $theta the play was not taken up"
  # From the other elbow the way to the target leads through the stretched arm, which the workspace forbids.
  [ $status -eq 0 ] || [ "$n" -eq 4 ] || fail "from $theta the target was not reached: $(cat err.txt out.txt)"
done

# A whole turn away from here play could not be taken up, but it does not stand there.
standing "-0.2, 110, 40"  # 0.09 deg as this arm counts
"${servo[@]}" --home --nearest-turn --out room >out.txt 2>err.txt || fail "the target was not reached: $(cat err.txt)"
! grep "no room" err.txt || fail "at 0 of [-360, 360] deg the play was not taken up"

standing "20, 110, 40"
# The play of the gears is taken up as every approach does: half of it separates both ways of arriving.
cp cell/truth.yaml truth.yaml
sed -i 's/^  backlash_deg: .*/  backlash_deg: [0.1, 0.1, 0.1]/' cell/truth.yaml
for approach in one_side direct; do
  sed "s/approach: one_side/approach: $approach/" cell/cell.yaml >"cell/$approach.yaml"
  "$bin/planar-servo" --no-health --cell "cell/$approach.yaml" --targets targets.csv --home --nearest-turn \
    --out "$approach" >out.txt 2>"$approach.txt" || true  # with play the target may not be reached
done
python3 - <<'END' || fail "the play was not taken up: $(grep homed one_side.txt direct.txt)"
import re
first = [float(re.search(r"homed by sight: joints (\S+)", open(f"{way}.txt").read())[1]) for way in ("one_side", "direct")]
assert abs(abs(first[0] - first[1]) - 0.05) < 0.02, first
END
cp truth.yaml cell/truth.yaml
expect 1 "start with --home" "${servo[@]}" --out made
expect 1 "whole turns from there.*--nearest-turn" "${servo[@]}" --home --out made
# By hand and in a recording it is the same.
# jog PATTERN FAULT COMMAND...
jog() {
  printf '%s\n' "${@:3}" quit | "$bin/planar-jog" --cell cell/cell.yaml >out.txt 2>&1 || true
  grep -q "$1" out.txt || fail "$2: $(cat out.txt)"
}
jog "have no marks" "a mark was taken" enable "mark 1"
jog "do not know where they stand" "it moved unhomed" enable "joint 1 5"
jog "whole turns from there" "a turn was guessed" enable home
jog "3 joints homed" "by hand" enable "home nearest-turn" where
[ "$(grep -c "homed by sight" out.txt)" -eq 1 ] || fail "by hand: $(cat out.txt)"
jog "3 joints homed" "again" enable "home nearest-turn" "home nearest-turn"
[ "$(grep -c "homed by sight" out.txt)" -eq 2 ] || fail "a second homing did nothing: $(cat out.txt)"
printf 'id,plan,x_mm,y_mm\nA,pose,200,100\n' >plan.csv
"$bin/planar-record" --cell cell/cell.yaml --plan plan.csv --home --nearest-turn --out recorded >out.txt 2>err.txt ||
  fail "recording: $(cat out.txt err.txt)"
grep -q "homed by sight" err.txt || fail "recording homed otherwise: $(cat err.txt)"
# Limits that leave one order of the lamps need no turn of joint 3.
sed 's/\[-720, 720\]/[-100, 100]/' cell/cell.yaml >cell/narrow.yaml
"$bin/planar-servo" --no-health --cell cell/narrow.yaml --targets targets.csv --home --nearest-turn --out narrow \
  >/dev/null 2>err.txt || fail "$(cat err.txt)"
grep -q "motor 3 turns" err.txt && fail "joint 3 turned in vain: $(cat err.txt)"
sed '0,/, home: {reference: sight}/s///' cell/cell.yaml >cell/mixed.yaml
expect 2 "all three or none" "$bin/planar-servo" --cell cell/mixed.yaml --targets targets.csv --dry-run

# Lamps whose middle joint 3 turns about look alike after any turn: it makes none.
cp cell/tool.yaml tool.yaml
sed -i '/^checksum: /d; s/^p_TP_mm: .*/p_TP_mm: [0, 0]/' cell/tool.yaml
expect 1 "which lamp is which.*--at-marks, or mount the lamps" "${servo[@]}" --accept-stale --home --nearest-turn --out made
grep -q "motor 3 turns" err.txt && fail "joint 3 turned in vain: $(cat err.txt)"
cp tool.yaml cell/tool.yaml

# Lamps that turn about an end point beside their middle leave no doubt about the elbow.
python3 - <<'END'
import re
def beside(path, key, by):
    text = re.sub(r"^checksum: .*\n", "", open(path).read(), flags=re.M)
    open(path, "w").write(re.sub(rf"({key}: \[)([^,]+)", lambda m: m[1] + str(float(m[2]) + by), text))
beside("cell/truth.yaml", "lamp[12]_mm", 2)
beside("cell/tool.yaml", "p_TP_mm", -2)
END
standing "-60, 30, 200"
"${servo[@]}" --accept-stale --home --nearest-turn --out beside >out.txt 2>err.txt || fail "$(cat out.txt err.txt)"
grep -q "homed by sight" err.txt || fail "$(cat err.txt)"
