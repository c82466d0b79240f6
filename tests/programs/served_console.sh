#!/usr/bin/env bash
# A served cell worked by planar-console: a page that is lost stops the drives in time, by what is sent to them, and no
# other program moves the cell meanwhile: loopback_only.sh served_console.sh BIN_DIR.
source "$(dirname "$0")/common.sh"

cp -r "$repository/calib/small" cell
# A jog that lasts for seconds.
sed -i 's/max_speed_deg_s: 60/max_speed_deg_s: 10/' cell/cell.yaml
printf 'id,x_mm,y_mm\na,200,100\n' >targets.csv
printf 'id,plan,x_mm,y_mm\nt1,train,200,100\n' >plan.csv
python3 -B "$repository/tests/programs/served_console.py" "$bin" cell live || fail "see above"
