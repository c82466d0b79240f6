#!/usr/bin/env bash
# linuxcnc.sh start|stop CONFIGURATION FOLDER: LinuxCNC, whole and without hardware, as a user other than root.
set -euo pipefail
configuration=$2 folder=$3
as_user=()
if [ "$(id -u)" -eq 0 ]; then as_user=(setpriv --reuid=nobody --regid=nogroup --clear-groups); fi

if [ "$1" = stop ]; then
  [ -e "$folder/session" ] || exit 0
  # LinuxCNC ends with its display, and takes its shared memory with it.
  (exec 3<>/dev/tcp/127.0.0.1/5007 && printf 'hello EMC stop 1.0\r\nset enable EMCTOO\r\nshutdown\r\n' >&3; sleep 1) 2>/dev/null || true
  for _ in $(seq 150); do
    kill -0 "$(cat "$folder/session")" 2>/dev/null || exit 0
    sleep 0.1
  done
  pkill -KILL -f "^(/bin/bash /usr/bin/linuxcnc|script -qfc linuxcnc|/usr/bin/rtapi_app)"
  exit 0
fi

command -v linuxcnc >/dev/null && [ -d "$configuration" ] || {
  echo "skipped: no LinuxCNC, or no configuration of it"
  exit 0
}
rm -rf "$folder"
mkdir -p "$folder"
cp "$configuration"/planar.* "$folder"
touch "$folder/planar.var" "$folder/tool.tbl"
if [ "$(id -u)" -eq 0 ]; then chown -R nobody "$folder"; fi
cd "$folder"
HOME=$folder setsid "${as_user[@]}" script -qfc "linuxcnc planar.ini" log >/dev/null 2>&1 </dev/null &
echo $! >session
for _ in $(seq 300); do
  if (exec 3<>/dev/tcp/127.0.0.1/5007) 2>/dev/null; then exit 0; fi
  sleep 0.1
done
cat log
echo "LinuxCNC does not listen"
exit 1
