#!/usr/bin/env bash
# The units as systemd's own judge sees them: no word of `verify`, and no more exposure than we say.
#   units.sh FOLDER_OF_UNITS GATEWAY SIM        (the programs as they were built)
set -euo pipefail
units=$1 gateway=$2 sim=$3

if ! command -v systemd-analyze >/dev/null; then
  echo "skipped: systemd-analyze is not here (package systemd)"
  exit 77
fi

here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
for unit in motionlab-gateway.service motionlab-sim.service motionlab.target; do
  # verify looks whether the programs are there.
  sed -e "s|/usr/bin/motionlab-gateway |$gateway |" -e "s|/usr/bin/motionlab-sim |$sim |" "$units/$unit" >"$here/$unit"
done

status=0
said=$(systemd-analyze verify --man=no "$here"/* 2>&1) || status=1
# Of other people's units it may say what it likes.
said=$(grep -F motionlab <<<"$said" || true)
if [[ -n $said ]]; then
  echo "systemd-analyze verify: $said"
  status=1
fi

# Tenths above which the exposure may not be.
exposed() {
  local unit=$1 most=$2
  if ! systemd-analyze security --offline=true --threshold="$most" "$here/$unit" >"$here/said" 2>&1; then
    status=1
    cat "$here/said"
  fi
  grep Overall "$here/said" || status=1
}
exposed motionlab-gateway.service 12
exposed motionlab-sim.service 12
exit $status
