#!/usr/bin/env bash
# A new cell file is written once, and examined as it is: a virtual cell is sound, and a real one lacks only devices.
source "$(dirname "$0")/common.sh"
doctor=$bin/planar-doctor

kinds=$("$doctor" --help | sed -n 's/.*--drives \([a-z|]*\)$/\1/p')
[[ $kinds == *virtual*tic* ]] || fail "--help names the drives '$kinds'"
for kind in ${kinds//|/ }; do
  "$doctor" --new "$kind.yaml" --drives "$kind" >out.txt || fail "$(cat out.txt)"
  grep -q "planar-doctor --cell $kind.yaml" out.txt || fail "$(cat out.txt)"
  cp "$kind.yaml" before.yaml
  expect 2 "$kind.yaml: exists already; name another file" "$doctor" --new "$kind.yaml" --drives tic
  cmp -s "$kind.yaml" before.yaml || fail "$kind.yaml was replaced"
done

"$doctor" --cell virtual.yaml >out.txt || fail "$(cat out.txt)"
if grep "^doubtful" out.txt; then fail "$(cat out.txt)"; fi

# On a machine without USB devices and network; see tests/support/loopback_only.sh. The library of
# umockdev comes before that of the address sanitizer, which minds unless it is told not to.
export ASAN_OPTIONS=verify_asan_link_order=0
if command -v umockdev-run >/dev/null; then
  for kind in ${kinds//|/ }; do
    [ "$kind" = virtual ] && continue
    status=0
    umockdev-run -- "$repository/tests/support/loopback_only.sh" "$doctor" --cell "$kind.yaml" \
      >out.txt || status=$?
    [ "$status" -eq 1 ] || fail "$kind: status $status, $(cat out.txt)"
    grep -q "^well *cell file" out.txt || fail "$(cat out.txt)"
    grep -q "^faulty *drive" out.txt || fail "$(cat out.txt)"
    if grep "^faulty" out.txt | grep -v "drive\|camera: "; then fail "$(cat out.txt)"; fi
  done
fi

# The doctor questions what can hardly be meant, which is no fault.
sed 's/\[300.0, 300.0\]/[0.3, 0.3]/; s/pitch_um: 2.5/pitch_um: 2500/' virtual.yaml >odd.yaml
"$doctor" --cell odd.yaml >out.txt || fail "a question is no fault: $(cat out.txt)"
grep -q "^doubtful *arm.link_lengths_mm: is \[0.3, 0.3\]" out.txt || fail "$(cat out.txt)"
grep -q "^doubtful *camera.pixel_pitch_um: is 2500" out.txt || fail "$(cat out.txt)"

expect 2 "--new requires --drives" "$doctor" --new made
expect 2 "--drives requires --new" "$doctor" --cell virtual.yaml --drives tic
expect 2 "--cell excludes --new" "$doctor" --cell virtual.yaml --new made --drives tic
expect 2 "magic not in" "$doctor" --new made --drives magic

# doc/cell.md has every key that a block may have; those of one kind of drives may stand in doc/drives.md.
sed -e 's/^camera:/&\n  nonsense: 1/; s/^lamps:/&\n  nonsense: 1/; s/^arm:/&\n  nonsense: 1/' \
    -e 's/^servo:/&\n  nonsense: 1/; s/^workspace:/&\n  nonsense: 1/; s/^tracker:/&\n  nonsense: 1/' \
    -e 's/^  - kind: [a-z]*/&\n    nonsense: 1/; s/{id: [a-z0-9]*,/& nonsense: 1,/' \
    -e 's/keep_out: \[\]/keep_out: [{nonsense: 1}]/' -e '$a reference_lamps: [{nonsense: 1}]\nnonsense: 1' \
    -i ./*.yaml
for kind in ${kinds//|/ }; do
  "$doctor" --cell "$kind.yaml" 2>err.txt && fail "nonsense is no fault"
  sed -n 's/.*nonsense.; allowed are //p' err.txt | tr -d ' ' | tr , '\n' | sort -u >keys.txt
  [ "$(grep -c "nonsense'" err.txt)" -ge 14 ] || fail "a block was left out: $(cat err.txt)"
  while read -r key; do
    grep -q "\`$key\`" "$repository/doc/cell.md" || grep -qw "$key" "$repository/doc/drives.md" ||
      fail "doc/cell.md lacks $key of drives $kind"
  done <keys.txt
done
