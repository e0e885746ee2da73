#!/bin/sh
# Runs the fault matrix, keeps it as the bounds that later runs must not be worse than, and writes its tables: the whole of them
# into deploy/docs/fault-matrix.md, the short one into README.md.
# Look at what changed (git diff) before you commit it: a bound that got worse is a decision.
#   tests/golden/remake_fault_matrix.sh [BUILD_FOLDER]        default: build/release
set -eu
cd "$(dirname "$0")/../.."
study=${1:-build/release}/simulators/lab/study/motionlab-study
[ -x "$study" ] || { echo "$study is not there; build it: cmake --build build/release --target motionlab-study" >&2; exit 1; }
"$study" --fault-matrix --report tests/golden/fault_matrix.json
"$study" --fault-matrix --recorded tests/golden/fault_matrix.json --markdown --report deploy/docs/fault-matrix.md
with_table=$(mktemp)
trap 'rm -f "$with_table"' EXIT
awk '
  FNR == NR { if (/^\| fault \| mru1 /) short = 1; if (!/^\|/) short = 0; if (short) table = table $0 "\n"; next }
  /^\| fault \| mru1 / { printf "%s", table; old = 1 }
  !/^\|/ { old = 0 }
  !old' deploy/docs/fault-matrix.md README.md >"$with_table"
cat "$with_table" >README.md
