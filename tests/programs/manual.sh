#!/usr/bin/env bash
# Manual pages: free of warnings, and with every option, word and sentence of --help.
source "$(dirname "$0")/common.sh"

# On one long line for each paragraph.
rendered() { groff -man -Tascii -P-cbou -rLL=20000n -rHY=0 "$1" 2>/dev/null | tr -s ' '; }

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
  # What --help says of each option, behind the name and its rules.
  grep -oE '^ +(-[a-z],)?--[a-z-]+' help.txt | grep -oE -- '--[a-z-]+' | sort -u >options.txt
  [ -s options.txt ] || fail "$name: --help lists no options"
  while read -r option; do
    grep -qE -- "^ *(-[a-z], )?$option( |\$)" page.txt || fail "$name: the page lacks $option"
  done <options.txt
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
  "$bin/planar-virtual-cell" "$command" --help | grep -oE '^ +(-[a-z],)?--[a-z-]+' | grep -oE -- '--[a-z-]+' |
    while read -r option; do
      grep -q -- "$option" page.txt || fail "planar-virtual-cell: the page lacks $option of $command"
    done
done
