#!/usr/bin/env bash
# The units as systemd's own judge sees them: no word of `verify`, and no more exposure than we say.
#   units.sh FOLDER_OF_UNITS PROGRAM…        (as they were built; /usr/bin/NAME in the units)
set -euo pipefail
units=$1
shift

if ! command -v systemd-analyze >/dev/null; then
  echo "skipped: systemd-analyze is not here (package systemd)"
  exit 77
fi

here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
# verify looks whether the programs are there.
places=()
for program in "$@"; do places+=(-e "s|/usr/bin/${program##*/} |$program |"); done
for unit in motionlab-{gateway,sim,recorder,console}.service motionlab.target; do
  sed "${places[@]}" "$units/$unit" >"$here/$unit"
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
exposed motionlab-recorder.service 12
exposed motionlab-console.service 12
exit $status
