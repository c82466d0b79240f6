#!/usr/bin/env bash
# Completion, as bash asks for it: options, words, subcommands, and files of the right kind.
source "$(dirname "$0")/common.sh"

for program in "$bin"/planar "$bin"/planar-*; do
  name=$(basename "$program")
  "$program" --completion bash >"$name.bash"
  bash -n "$name.bash" || fail "$name: bash cannot read its completion"
done
expect 2 "^planar-record: --completion: tcsh not in \{bash\}; --help" "$bin/planar-record" --completion tcsh
export PATH=$bin:$PATH
for script in planar*.bash; do
  # shellcheck disable=SC1090
  source "$script"
done

# offered WORD...: what Tab offers for the last of these words.
offered() {
  local COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  "_${1//-/_}" || true
  printf '%s\n' "${COMPREPLY[@]}" | sort -u | tr '\n' ' '
}

# offers WANTED WORD...
offers() {
  local wanted=$1 found
  shift
  found=$(offered "$@")
  [ "$found" = "$wanted " ] || fail "Tab after '$*' offers '$found' instead of '$wanted'"
}

# Every option that a program's --help lists is offered.
options_in() { grep -oE '^ +(-[a-z], ?)?--[a-z][a-z-]*|^ +-[a-z],--[a-z-]+' | grep -oE -- '--[a-z-]+' | sort -u; }
for program in "$bin"/planar "$bin"/planar-*; do
  name=$(basename "$program")
  "$program" --help | options_in >wanted.txt
  [ "$(grep -c . wanted.txt)" -ge 6 ] || fail "$name: few options: $(cat wanted.txt)"
  offered "$name" - | tr ' ' '\n' | grep . >offered.txt
  cmp -s wanted.txt offered.txt || fail "$name: $(diff wanted.txt offered.txt)"
done
"$bin/planar-virtual-cell" draw --help | options_in | grep -v '^--version$' >wanted.txt
offered planar-virtual-cell draw - | tr ' ' '\n' >offered.txt
while read -r option; do
  grep -qxF -- "$option" offered.txt || fail "planar-virtual-cell draw: $option is not offered"
done <wanted.txt

mkdir -p a/b files && cd files
mkdir folder
touch cell.yaml plan.csv pairs.csv page.html photo.png other.txt
offers "cell.yaml folder" planar-record --cell ""
offers "folder pairs.csv plan.csv" planar-record --plan ""
offers "folder" planar-record --out ""
offers "plan.csv" planar-record --plan = pl
offers "auto none" planar-record --display ""
offers "" planar-plan --readings ""
offers "folder none page.html" planar-pair-tracker --report ""
offers "folder photo.png" planar-calibrate-camera --grid circles:11x11:50mm ""
offers "cell.yaml folder" planar-check-error-map ""
offers "folder pairs.csv plan.csv" planar-check-error-map map.yaml ""
offers "folder pairs.csv plan.csv" planar-check-error-map --plan test map.yaml ""
offers "draw put serve" planar-virtual-cell ""
offers "cheap ordinary paper rough workshop" planar-virtual-cell draw --like ""
offers "cell.yaml folder" planar-servo --cell ""
offers "canny-kasa" planar-servo --cell cell.yaml --centre c

# planar completes its commands, then what they complete.
offers "record" planar rec
offers "cell.yaml folder" planar record --cell ""
offers "--on-bad-reading" planar record --cell cell.yaml --on
offers "draw" planar virtual-cell d
offers "record" planar help rec
