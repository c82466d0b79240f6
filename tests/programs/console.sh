#!/usr/bin/env bash
# A cell worked over HTTP by planar-console: rights, every kind of work, stop, lost pages, floods, and how it ends.
source "$(dirname "$0")/common.sh"

cp -r "$2/cell" .
# Without the visits to places of the calibration, which take a minute of real time; their joints are fast
# enough to run targets, and so slow that a jog can be stopped on its way.
sed '/^health:/d; s/max_speed_deg_s: 120/max_speed_deg_s: 300/' cell/cell.yaml >cell/fast.yaml
sed '/^health:/d; s/max_speed_deg_s: 60/max_speed_deg_s: 5/' cell/cell.yaml >cell/slow.yaml
"$bin/planar-virtual-cell" -q draw --seed 6 -o fresh >/dev/null
printf 'id,x_mm,y_mm,phi_deg\n' >cell/targets.csv
# A certificate that lacks its last move, and one of a cell whose camera has moved since.
"$bin/planar-certify" -q --cell cell/fast.yaml --cycles 2 --targets 1 --out cell/proof >/dev/null
sed -i '$d' cell/proof/cycles.csv
rm cell/proof/certificate.*
cp -r cell moved
cp -r "$repository/calib/workshop" doubted # its map has no checksum
sed -i '/^health:/d; s/max_speed_deg_s: 120/max_speed_deg_s: 300/' doubted/cell.yaml
awk -F'[][]' '/translation_mm/ { split($2, t, ","); sub(/\[[^,]*/, "[" t[1] + 20) } 1' cell/truth.yaml >moved/truth.yaml
echo outside >secret.html
ln -s ../secret.html cell/link.html

python3 "$repository/tests/programs/console.py" "$bin/planar-console" cell || fail "see above"
sed -i "s/token=.*/token=.../" console.txt
expect_sample console.txt "$bin/planar-console"
