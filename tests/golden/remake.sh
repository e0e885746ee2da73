#!/usr/bin/env bash
# Makes the golden runs anew, from the study as it is built now. README.md here says when that is honest.
#   tests/golden/remake.sh [MOTIONLAB_STUDY]     default: build/release/simulators/lab/study/motionlab-study
# One line a run: its size, and what its replay says.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
study=${1:-build/release/simulators/lab/study/motionlab-study}
[[ -x $study ]] || {
  echo "remake.sh: there is no $study; build it: cmake --build build/release --target motionlab-study" >&2
  exit 1
}
study=$(realpath "$study")
runs=$PWD/tests/golden/runs
MOTIONLAB_CONFIG_DIR=$PWD/deploy/config
export MOTIONLAB_CONFIG_DIR

# run NAME OPTIONS…: recorded in its own folder, so that a run which fails leaves the old file.
run() {
  local name=$1 fresh
  fresh=$(mktemp -d)
  "$study" "${@:2}" --seed 5 --record "$fresh/$name.mcap" --report "$fresh/report.json" \
    --set lab.record.outputs_every=100 --set lab.record.zstd_level=19
  printf '%-20s %4d kB  ' "$name" $(($(stat -c %s "$fresh/$name.mcap") / 1024))
  "$study" --replay "$fresh/$name.mcap"
  mv "$fresh/$name.mcap" "$runs/"
  rm -r "$fresh"
}

run engaged-in-a-sea --scenario sea --engage-at 3 --seconds 6
run fault-latches --scenario thesis-wave --engage-at 3 --seconds 6 --fault mru1:silent@4.5..5
run external-reference --scenario sea --engage-at 3 --seconds 6 --reference sine --reference-from 4
