#!/bin/sh
# The tables for people are those of the recorded matrix.
set -eu
study=$1
text=$(mktemp)
trap 'rm -f "$text"' EXIT
"$study" --fault-matrix --recorded tests/golden/fault_matrix.json --markdown --report "$text"
diff -u deploy/docs/fault-matrix.md "$text" || {
  echo "deploy/docs/fault-matrix.md is not that of the recorded matrix; run tests/golden/remake_fault_matrix.sh" >&2
  exit 1
}
