#!/usr/bin/env bash
# obstacles.sh BIN_DIR CELL_DIR: links keep clear of obstacles, on a way round where the straight way is barred.
source "$(dirname "$0")/common.sh"
cp -r "$2/cell" .
servo=("$bin/planar-servo" -q --no-health --cell)

among() { # among NAME OBSTACLES: the cell with an arm of some width among obstacles
  sed -e 's/^arm: {/arm: {link_width_mm: [60, 50], tool_radius_mm: 40, /' \
    -e "s/keep_out: \[\]/keep_out: [], obstacles: [$2]/" cell/cell.yaml >"cell/$1.yaml"
}
among post '{name: post, x_mm: 0, y_mm: 330, radius_mm: 30}'
printf 'id,x_mm,y_mm\nF,0,200\nG,300,-200\nB,-250,150\nD,200,300\n' >targets.csv

# D's link lies on the post; G is reached by a way round it.
status=0
"$bin/planar-servo" --no-health --cell cell/post.yaml --targets targets.csv --dry-run --report plan.html >plan.txt || status=$?
[ $status -eq 1 ] || fail "a dry run with a target in an obstacle ended with $status"
grep -Eq "^D: refused: link 2 would come within .* of the obstacle post" plan.txt || fail "$(cat plan.txt)"
[ "$(grep -c refused plan.txt)" -eq 1 ] || fail "more than D is refused: $(cat plan.txt)"
grep -q "end point's way" plan.html || fail "the page does not draw the way"
head -n 4 targets.csv >two.csv
"$bin/planar-servo" --no-health --cell cell/post.yaml --targets two.csv --out run >/dev/null 2>err.txt || fail "$(cat err.txt)"
grep -q "going round by [1-9]" err.txt || fail "no way round was gone: $(cat err.txt)"
printf 'x_mm,y_mm\n0,200\n200,300\n' >path.csv
expect 2 "obstacle post" "${servo[@]}" cell/post.yaml --path path.csv --check

# What cannot be is named.
sed 's/link_width_mm: \[60, 50\], //' cell/post.yaml >cell/thin.yaml
expect 2 "width is not known.*link_width_mm" "${servo[@]}" cell/thin.yaml --targets two.csv --dry-run
among crossed '{name: box, polygon_mm: [[100, 100], [200, 200], [200, 100], [100, 200]]}'
expect 2 "must not cross itself" "${servo[@]}" cell/crossed.yaml --targets two.csv --dry-run
among base '{name: base, x_mm: 10, y_mm: 0, radius_mm: 30}'
expect 2 "base reaches over the base's axis" "${servo[@]}" cell/base.yaml --targets two.csv --dry-run
among pen '{name: west, polygon_mm: [[-600, -600], [-150, -600], [-150, 600], [-600, 600]]}'
status=0
"$bin/planar-servo" --no-health --cell cell/pen.yaml --targets two.csv --dry-run >out.txt || status=$?
[ $status -eq 1 ] && grep -q "^B: refused.*obstacle west" out.txt || fail "$(cat out.txt)"
