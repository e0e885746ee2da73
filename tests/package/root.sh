#!/usr/bin/env bash
# Clean roots to install into. To be sourced; also run by itself to fetch what a network is needed for:
#   tests/package/root.sh prepare
clean_root_cache=$PWD/build/clean-root

# What our packages depend on, and what a machine that boots has.
runtime_packages=(
  systemd-sysv dbus iproute2 procps
  libspdlog1.10 libfmt9 libfastrtps2.9 libfastcdr1 libtinyxml2-9 libsystemd0 libtomlplusplus3 libstdc++6
)

# A minimal Debian with these packages and nothing of ours. Needs root, debootstrap, a network; once.
prepare_clean_root() {
  [[ -f $clean_root_cache/.complete ]] && return 0
  command -v debootstrap >/dev/null && ((EUID == 0)) || return 1
  local packages mirror
  packages=$(IFS=,; echo "${runtime_packages[*]}")
  mirror=$(grep -rhoE 'https?://[^ ]+/debian/?( |$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null | head -1)
  rm -rf "$clean_root_cache"
  mkdir -p "$(dirname "$clean_root_cache")"
  debootstrap --variant=minbase --include="$packages" bookworm "$clean_root_cache" "${mirror% }" || return 1
  touch "$clean_root_cache/.complete"
}

# open_root FOLDER: mounts a root there that can be written to and thrown away. Sets $root_kind, what it is.
# shellcheck disable=SC2034 # root_kind is for who sources this
open_root() {
  local folder=$1 lower
  if [[ -f $clean_root_cache/.complete ]]; then
    lower=$clean_root_cache root_kind="a clean Debian, made by debootstrap"
  else
    lower=/ root_kind="a copy of this machine's own root, because debootstrap has made no clean one"
  fi
  mkdir -p "$folder"
  mount -t tmpfs -o size=2G tmpfs "$folder" || return 1
  mkdir "$folder/up" "$folder/work" "$folder/root"
  mount -t overlay overlay -o "lowerdir=$lower,upperdir=$folder/up,workdir=$folder/work" "$folder/root" || return 1
  : >"$folder/root/etc/machine-id"
}

close_root() {
  umount "$1/root" 2>/dev/null
  umount "$1" 2>/dev/null
  rmdir "$1" 2>/dev/null
}

if [[ ${BASH_SOURCE[0]} == "$0" ]]; then
  set -euo pipefail
  cd "$(dirname "${BASH_SOURCE[0]}")/../.."
  clean_root_cache=$PWD/build/clean-root
  [[ ${1:-} == prepare ]] || {
    echo "usage: tests/package/root.sh prepare" >&2
    exit 64
  }
  prepare_clean_root || echo "no clean root: tests of the packages use a copy of this machine's own"
fi
