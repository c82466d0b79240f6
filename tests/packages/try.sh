#!/usr/bin/env bash
# tests/packages/try.sh PACKAGES: the Debian packages of this folder as a new user meets them, on a
# bare Debian 12 below a temporary folder, where no checkout is. Needs root, debootstrap and lintian.
# Prints what each step took, and lintian's warnings.
set -euo pipefail
packages=$(realpath "$1")
root=$(mktemp -d)
log=$(mktemp)
trap 'rm -rf "$root" "$log"' EXIT
ours=()
for package in "$packages"/*.deb; do ours+=("$(dpkg-deb -f "$package" Package)"); done

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# step WHAT COMMAND...: says how long it took, or shows how it failed.
step() {
  local what=$1 start=$EPOCHREALTIME
  shift
  "$@" >"$log" 2>&1 || { tail -n 30 "$log" >&2; fail "$what: $*"; }
  seconds_since "$start" "$what"
}

# seconds_since START WHAT
seconds_since() {
  awk -v what="$2" -v from="$1" -v to="$EPOCHREALTIME" 'BEGIN { printf "%6.1f s  %s\n", to - from, what }'
}

clean=(env -i PATH=/usr/sbin:/usr/bin LC_ALL=C.UTF-8)
inside=(chroot "$root" "${clean[@]}" DEBIAN_FRONTEND=noninteractive)
as_user=(chroot --userspec=1000:1000 "$root" "${clean[@]}" HOME=/home/user)

# install WHAT NAME [PACKAGE...]: our package of this name and others; what they need is downloaded first.
install() {
  local what=$1 file
  file=$(basename "$packages/$2"_*.deb)
  local new=(apt-get install -y --no-install-recommends "/packages/$file" "${@:3}")
  step "download $what" "${inside[@]}" "${new[@]}" --download-only
  step "install $what" "${inside[@]}" "${new[@]}"
}

# Every file must have "planar" in its path, so that remove() finds what stays.
require_names() {
  local strangers
  strangers=$("${inside[@]}" dpkg -L "${ours[@]}" | while read -r path; do
    if [ -n "$path" ] && [ ! -d "$root$path" ]; then echo "$path"; fi
  done | grep -v planar || true)
  [ -z "$strangers" ] || fail "these paths do not tell whose they are: $strangers"
}

# Every link of the pages that are installed leads somewhere; those of benchmarks lead to scripts, too.
require_links() {
  local pages=$root/usr/share/doc/planar-servo page link missing=0
  for page in "$pages"/*.md "$pages"/doc/*.md; do
    for link in $(grep -oP '\]\(\K[^)#:]+(?=[)#])' "$page"); do
      [ -e "$(dirname "$page")/$link" ] || { echo "${page#"$root"} links to $link"; missing=1; }
    done
  done
  return $missing
}

# Each program and module calls every library that it names. (The loader, which all need, is left out.)
require_used() {
  local file
  for file in $("${inside[@]}" dpkg -L "${ours[@]}" | grep -E '/bin/planar|\.so$'); do
    "${inside[@]}" ldd -u "$file" | grep -F / | grep -v ld-linux | grep . && { echo "$file does not call these"; return 1; }
  done
  return 0
}

remove() {
  "${inside[@]}" apt-get purge -y "${ours[@]}"
  local left
  left=$(cd "$root" && find . -xdev \( -path ./packages -o -path ./home \) -prune -o -path "*planar*" -print)
  [ -z "$left" ] || { echo "left: $left"; return 1; }
}

for package in "$packages"/*.deb; do
  step "lintian $(basename "$package")" lintian --allow-root --fail-on error "$package"
  cat "$log"
done

chmod 755 "$root"
start=$EPOCHREALTIME
if ! debootstrap --variant=minbase bookworm "$root" >"$log" 2>&1; then
  echo "SKIPPED: debootstrap makes no bare Debian here, so the packages were not tried: $(tail -n 3 "$log")"
  exit 0
fi
seconds_since "$start" "a bare Debian 12"
echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/hasty"  # what is here need not survive a power cut
mkdir -p "$root/packages" "$root/home/user"
cp "$packages"/*.deb "$root/packages"
chown 1000:1000 "$root/home/user"
step "apt-get update" "${inside[@]}" apt-get update

install "the programs" planar-servo
step "a first report" "${as_user[@]}" planar-experiment --out /home/user/first --grid circles:11x11:25mm \
  --cell /usr/share/planar-servo/calib/small/cell.yaml
grep -q "<svg" "$root/home/user/first/report.html" || fail "the report has no figure"
grep -q "<svg" "$root/usr/share/doc/planar-servo/sample/report.html" || fail "the report of the package has no figure"
step "follow the pages' links" require_links

install "the library" libplanar-servo-dev cmake g++ make
examples=/usr/share/doc/libplanar-servo-dev/examples
step "configure an example" "${as_user[@]}" cmake -S "$examples" -B /home/user/examples
step "build an example" "${as_user[@]}" cmake --build /home/user/examples --target fit_error_map
step "run an example" bash "$(dirname "$0")/../library/fit_error_map.sh" \
  "${as_user[@]}" /home/user/examples/fit_error_map

if [[ " ${ours[*]} " == *" python3-planar-servo "* ]]; then
  install "the module" python3-planar-servo
  step "import the module" "${as_user[@]}" python3 -c 'import planar_servo._camera; print(planar_servo.camera_models())'
  grep -q plumb_bob "$log" || fail "the module knows no camera model"
fi

require_names
step "look for libraries that nothing calls" require_used
step "remove all" remove
