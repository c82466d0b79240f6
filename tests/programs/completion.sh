#!/usr/bin/env bash
# Completion, as the shells ask for it: options, words, subcommands, and files of the right kind.
source "$(dirname "$0")/common.sh"

for program in "$bin"/planar "$bin"/planar-*; do
  name=$(basename "$program")
  "$program" --completion bash >"$name.bash"
  bash -n "$name.bash" || fail "$name: bash cannot read its completion"
  for shell in zsh fish; do
    "$program" --completion "$shell" >"$name.$shell"
    "$shell" -n "$name.$shell" || fail "$name: $shell cannot read its completion"
  done
done
expect 2 "^planar-record: --completion: tcsh not in \{bash,zsh,fish\}; --help" "$bin/planar-record" --completion tcsh
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
offers "draw serve" planar-virtual-cell ""
offers "cheap ordinary paper rough workshop" planar-virtual-cell draw --like ""
offers "cell.yaml folder" planar-servo --cell ""
offers "canny-kasa" planar-servo --cell cell.yaml --centre c

# planar completes its commands, then what they complete.
offers "record" planar rec
offers "cell.yaml folder" planar record --cell ""
offers "--on-bad-reading" planar record --cell cell.yaml --on
offers "draw" planar virtual-cell d
offers "record" planar help rec

# In zsh, a line that is typed up to a Tab becomes the wanted one; cell.csv is no cell, pairs.txt no pairs.
touch cell.csv pairs.txt
# shellcheck disable=SC2016
in_zsh='zmodload zsh/zpty
  zpty z env TERM=dumb zsh -fi
  zpty -w z "autoload -Uz compinit; compinit -u -D; source ../$1.zsh; print READ\"\"Y"
  zpty -r z seen "*READY*"
  zpty -w -n z "$2$(printf "\t")"
  zpty -r z seen "*$3*"'
becomes() { timeout 60 zsh -fc "$in_zsh" zsh "$@" || fail "Tab in zsh after '$2' gives no '$3'"; }
becomes planar-record "planar-record --cell ce" "cell.yaml"
becomes planar-record "planar-record --on-bad-reading sk" "skip"
becomes planar-virtual-cell "planar-virtual-cell dr" "draw"
becomes planar-virtual-cell "planar-virtual-cell draw --like wo" "workshop"
becomes planar-check-error-map "planar-check-error-map cell.yaml pai" "pairs.csv"
becomes planar "planar rec" "record"
becomes planar "planar record --pl" "--plan"

in_fish() {
  local wanted=$1 found
  found=$(fish --no-config -c "source ../$2.fish; complete -C '$3'" | cut -f 1 | sort -u | tr '\n' ' ')
  [ "$found" = "$wanted " ] || fail "Tab in fish after '$3' offers '$found' instead of '$wanted'"
}
in_fish "cell.yaml folder/" planar-record "planar-record --cell "
in_fish "skip stop" planar-record "planar-record --on-bad-reading s"
in_fish "draw serve" planar-virtual-cell "planar-virtual-cell "
in_fish "--like" planar-virtual-cell "planar-virtual-cell draw --li"
in_fish "cell.yaml" planar "planar record --cell ce"
in_fish "cell.yaml folder/" planar-check-error-map "planar-check-error-map "
in_fish "pairs.csv" planar-check-error-map "planar-check-error-map --json f.json cell.yaml pa"
in_fish "circles:11x11:50mm" planar-record "planar-record --grid ci"
