#!/bin/sh
# The tables for people are those of the recorded matrix.
set -eu
study=$1
text=$(mktemp)
trap 'rm -f "$text"' EXIT
stale() {
  echo "$1 is not that of the recorded matrix; run tests/golden/remake_fault_matrix.sh" >&2
  exit 1
}
short() { awk '/^\| fault \| mru1 / { on = 1 } !/^\|/ { on = 0 } on' "$1"; }
"$study" --fault-matrix --recorded tests/golden/fault_matrix.json --markdown --report "$text"
diff -u deploy/docs/fault-matrix.md "$text" || stale deploy/docs/fault-matrix.md
if [ -z "$(short README.md)" ] || [ "$(short README.md)" != "$(short "$text")" ]; then stale "the table of README.md"; fi
