# Sourced after common.sh: a virtual cell that planar-virtual-cell serves, and a person at it. Scripts
# that use it are run by tests/support/loopback_only.sh, so that no other camera is there.

# serve OPTIONS...: serves a cell until the script ends, and waits until it is found.
serve() {
  rm -f commands
  mkfifo commands
  "$bin/planar-virtual-cell" serve "$@" <commands >served.txt 2>served.err &
  served=$!
  exec 3>commands
  trap 'kill "$served" 2>/dev/null || true; rm -rf "$work"' EXIT
  for _ in $(seq 300); do
    if grep -q "^tracker " served.txt; then return; fi
    kill -0 "$served" 2>/dev/null || fail "nothing is served: $(cat served.err)"
    sleep 0.1
  done
  fail "the served cell says nothing: $(cat served.txt)"
}

# at_cell COMMAND: does something at the cell and waits until it is done.
at_cell() {
  local before
  before=$(wc -l <served.txt)
  echo "$1" >&3
  for _ in $(seq 100); do
    if [ "$(wc -l <served.txt)" -gt "$before" ]; then return; fi
    sleep 0.1
  done
  fail "the served cell does not answer '$1'"
}

views_shown=0 # of the board; each is another pose

# operated MESSAGES COMMAND...: a command whose messages go to a file, and a person who does what they ask for:
# shows the board, another view after ten seconds, and takes it away; places the reflector and presses Enter.
operated() {
  local messages=$1 answered=0 shows="" shown_s=0 asked status=0
  shift
  rm -f keys
  mkfifo keys
  "$@" <keys 2>"$messages" &
  local command=$!
  exec 4>keys
  while kill -0 "$command" 2>/dev/null; do
    asked=$(grep -ao "place the reflector \(on '[^']*'\|back on the tool\)\|more \(view\|lay\)\|arm's way" \
      "$messages" | sed -n "$((answered + 1))p")
    case $asked in
    "") ;;
    *reflector*)
      at_cell "reflector $(sed "s/.* on '\(.*\)'/\1/; s/.* on the //" <<<"$asked")"
      echo >&4
      ;;
    *view) shows="board hold" shown_s=0 ;;
    *lay) shows="board lay" shown_s=0 ;;
    *)
      at_cell "board remove"
      shows=""
      ;;
    esac
    [ -z "$asked" ] || answered=$((answered + 1))
    if [ -n "$shows" ] && [ "$SECONDS" -ge "$shown_s" ]; then
      at_cell "$shows $((views_shown++))"
      shown_s=$((SECONDS + 10))
    fi
    sleep 0.1
  done
  exec 4>&-
  wait "$command" || status=$?
  return "$status"
}
