#!/usr/bin/env bash
# The two Debian packages: made, judged by lintian, installed into a clean root, upgraded over an edited configuration, removed,
# purged.
#   packages.sh BUILD_FOLDER
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=tests/package/root.sh
source tests/package/root.sh
build=$(realpath "$1")

if ! command -v dpkg-shlibdeps >/dev/null || ! command -v lintian >/dev/null || ((EUID != 0)); then
  echo "skipped: this needs root, dpkg-dev and lintian"
  exit 77
fi

here=$(mktemp -d)
trap 'close_root "$here/root"; rm -rf "$here"' EXIT
fail() {
  echo "FAILED: $1"
  exit 1
}
ok() { echo "ok $1"; }

rm -rf "$build/packages"
{ cmake --build "$build" -j "$(nproc)" &&
  (cd "$build" && cpack -G DEB); } >"$here/cpack" 2>&1 || {
  cat "$here/cpack"
  fail "cpack"
}
gateway=$(echo "$build"/packages/motionlab-gateway_*.deb)
sim=$(echo "$build"/packages/motionlab-sim_*.deb)
[[ -f $gateway && -f $sim ]] || fail "cpack made no packages"
for package in "$gateway" "$sim"; do
  dpkg-deb -f "$package" Package Version Installed-Size Depends
done
ok "are made"

lintian --fail-on error,warning --tag-display-limit 0 "$gateway" "$sim" || fail "lintian (above)"
ok "satisfy lintian"

# contains PACKAGE PATH…
contains() {
  local list path
  list=$(dpkg-deb -c "$1" | awk '{ print $6 }')
  for path in "${@:2}"; do grep -qxF "./$path" <<<"$list" || fail "$(basename "$1") lacks $path"; done
}
contains "$gateway" usr/bin/motionlab-gateway usr/bin/motionlab usr/lib/systemd/system/motionlab-gateway.service \
  usr/lib/systemd/system/motionlab-recorder.service usr/lib/systemd/system/motionlab-console.service \
  usr/lib/systemd/system/motionlab.target etc/motionlab/lab.toml usr/share/doc/motionlab-gateway/copyright
for idl in idl/*.idl; do contains "$gateway" "usr/share/motionlab/$idl"; done
for page in deploy/docs/*.md; do contains "$gateway" "usr/share/doc/motionlab-gateway/$(basename "$page")"; done
contains "$sim" usr/bin/motionlab-sim usr/bin/motionlab-study usr/lib/systemd/system/motionlab-sim.service \
  etc/motionlab/world.toml usr/share/motionlab/loopback.toml
ok "hold what they should"

open_root "$here/root" || {
  echo "skipped: no overlay can be mounted here"
  exit 77
}
echo "in $root_kind"
readonly root=$here/root/root
inside() { chroot "$root" env DEBIAN_FRONTEND=noninteractive "$@"; }
# Installing says what it does; that is read only when it fails.
quietly() {
  "$@" >"$here/said" 2>&1 || {
    cat "$here/said"
    return 1
  }
}
cp "$gateway" "$root/tmp/gateway.deb"
cp "$sim" "$root/tmp/sim.deb"

quietly inside dpkg -i /tmp/gateway.deb /tmp/sim.deb || fail "they do not install"
inside motionlab-gateway --check >"$here/check" || fail "the installed gateway does not read the installed configuration"
grep -q 'from 192.168.90.42:50042 to' "$here/check" || fail "it read another file"
for program in "motionlab-sim --help" "motionlab --help" "motionlab-study --list"; do
  # shellcheck disable=SC2086 # a program and its option
  quietly inside $program || fail "the installed $program does not run"
done
! ls "$root"/etc/systemd/system/*.wants/motionlab* >/dev/null 2>&1 || fail "something was enabled by being installed"
ok "install, and the programs run"

# The next version, with another lab.toml, over an edited one.
dpkg-deb -R "$gateway" "$here/next"
sed -i 's/^Version: .*/&+next/' "$here/next/DEBIAN/control"
echo '# the next version of this file' >>"$here/next/etc/motionlab/lab.toml"
(cd "$here/next" && find . -type f ! -path './DEBIAN/*' -printf '%P\0' | xargs -0 md5sum >DEBIAN/md5sums)
dpkg-deb --root-owner-group -b "$here/next" "$root/tmp/next.deb" >/dev/null
sed -i 's/^domain = 42$/domain = 43/' "$root/etc/motionlab/lab.toml"
quietly inside dpkg --force-confdef --force-confold -i /tmp/next.deb || fail "the next version does not install"
grep -q 'DDS domain 43' <<<"$(inside motionlab-gateway --check)" || fail "an edited lab.toml did not survive the upgrade"
[[ -f $root/etc/motionlab/lab.toml.dpkg-dist ]] || fail "the new lab.toml is not laid beside the edited one"
ok "keep an edited configuration when upgraded"

quietly inside dpkg -r motionlab-sim motionlab-gateway || fail "they cannot be removed"
[[ ! -e $root/usr/bin/motionlab-gateway && ! -e $root/usr/lib/systemd/system/motionlab.target ]] || fail "a removed file is there"
grep -q '^domain = 43$' "$root/etc/motionlab/lab.toml" || fail "removing took the edited configuration"
ok "leave the configuration when removed"

echo 'OPTIONS=""' >"$root/etc/default/motionlab-gateway"
quietly inside dpkg -P motionlab-sim motionlab-gateway || fail "they cannot be purged"
left=$(find "$root/etc" "$root/usr" "$root/var/lib" "$root/lib" -name '*motionlab*' 2>/dev/null || true)
[[ -z $left ]] || fail "purging left $left"
ok "leave nothing when purged"
