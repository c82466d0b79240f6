# Sourced by the scripts beside it, which are called NAME.sh PROGRAM [ARGUMENT...]: runs the example,
# shows what it prints and keeps it in `printed`.
set -euo pipefail
printed=$("$@")
echo "$printed"

# number PATTERN: of the printed lines, the number that stands for N in this pattern; one per line.
number() {
  local pattern=${1/N/([-0-9.e+]+)}
  sed -nE "s/(^|.*[^-0-9.e+])$pattern.*/\2/p" <<<"$printed"
}

# within NAME LOWER VALUE UPPER
within() {
  awk -v low="$2" -v value="$3" -v high="$4" 'BEGIN { exit !(value != "" && value + 0 >= low && value + 0 <= high) }' ||
    { echo "FAILED: $1 is '$3', not from $2 to $4" >&2; exit 1; }
}
