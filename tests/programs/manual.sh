#!/usr/bin/env bash
# Manual pages: free of warnings, and with every option, word and sentence of --help.
source "$(dirname "$0")/common.sh"

# On one long line for each paragraph.
rendered() { groff -man -Tascii -P-cbou -rLL=20000n -rHY=0 "$1" 2>/dev/null | tr -s ' '; }

names_in() { sed -nE 's/^ +(-[a-z],)?(--[a-z-]+).*/\2/p; s/^  ([a-z-]+)  +[A-Z].*/\1/p' "$1" | sort -u; }

# explained PROGRAM: each name on standard input has its own entry in page.txt.
explained() {
  local name
  while read -r name; do
    grep -qE -- "^ *(-[a-z], )?$name( |\$)" page.txt || fail "$1: the page lacks $name"
  done
}

for program in "$bin"/planar "$bin"/planar-*; do
  name=$(basename "$program")
  "$program" --man-page >"$name.1"
  groff -man -ww -z -Tutf8 "$name.1" 2>warnings.txt
  [ ! -s warnings.txt ] || fail "$name: $(cat warnings.txt)"
  rendered "$name.1" >page.txt
  for section in NAME SYNOPSIS DESCRIPTION OPTIONS "EXIT STATUS" "SEE ALSO"; do
    grep -qx "$section" page.txt || fail "$name: the page has no section $section"
  done
  "$program" --help >help.txt
  sentence=$(head -n 1 help.txt)
  grep -qF -- "$sentence" page.txt || fail "$name: the page lacks '$sentence'"
  # The options and, of planar, the commands that --help lists.
  names_in help.txt >names.txt
  grep -q -- --json names.txt || fail "$name: --help lists no options"
  explained "$name" <names.txt
  # What --help says of them, behind the name and its rules.
  sed -nE '/^(Options|Positionals):$/,$ s/^ +[^ ].*[^ ]  +([^ ].*)$|^ {20,}([^ ].*)$/\1\2/p' help.txt >texts.txt
  [ -s texts.txt ] || fail "$name: --help explains nothing"
  # What stands below the options.
  awk '/^Options:$/ { on = 1; next } /:$/ && !/^Commands, one/ { next } on && /^[^ [-]/' help.txt >>texts.txt
  while read -r text; do
    grep -qF -- "$(tr -s ' ' <<<"$text")" page.txt || fail "$name: the page lacks '$text'"
  done <texts.txt
done

rendered planar-virtual-cell.1 >page.txt
for command in draw serve; do
  "$bin/planar-virtual-cell" "$command" --help >help.txt
  names_in help.txt >names.txt
  [ "$(grep -c . names.txt)" -ge 4 ] || fail "planar-virtual-cell $command: --help lists no options"
  explained "planar-virtual-cell $command" <names.txt
done
