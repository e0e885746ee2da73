#!/usr/bin/env bash
# The world of the thesis on the command line of motionlab-study.
#   thesis.sh PROGRAM
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
study=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

fail() {
  echo "$1" >&2
  exit 1
}

# refuses SENTENCE OPTION…: the program exits with 2 and says so.
refuses() {
  local sentence=$1 status=0
  shift
  "$study" "$@" >"$folder/out" 2>"$folder/err" || status=$?
  [[ $status == 2 ]] || fail "motionlab-study $* ended with $status, not 2"
  grep -qF -- "$sentence" "$folder/err" || fail "motionlab-study $* said: $(cat "$folder/err")"
}

"$study" --table thesis >"$folder/table"
diff "$here/../golden/thesis_table.txt" "$folder/table"

"$study" --list >"$folder/list"
for word in thesis-load-4b thesis-motion-6b thesis-pendulum ekf35 prefilter printed thesis-wave; do
  grep -q -- "$word" "$folder/list" || fail "--list does not show $word"
done

"$study" --world thesis --scenario thesis-motion-5 --estimator ideal --seconds 5 --report "$folder/a.json"
"$study" --world thesis --scenario thesis-motion-5 --estimator ideal --seconds 5 >"$folder/b.json"
cmp "$folder/a.json" "$folder/b.json"
for line in '"world": "thesis"' '"gains": "code"' '"frame": "world"' '"duration_s": 5.0' '"controller": "integral"'; do
  grep -qF -- "$line" "$folder/a.json" || fail "the report has no $line"
done

refuses "choose one of: thesis-pendulum, thesis-load-1" --world thesis
refuses "choose one of: none, integral" --world thesis --scenario thesis-motion-5 --controller damper
refuses "choose one of: none, prefilter, integral, damper" --world thesis --scenario thesis-pendulum --controller ours
refuses "--fault does not go with --world thesis" --world thesis --scenario thesis-load-1 --fault mru1:silent@1
refuses "it is one of --world thesis" --scenario thesis-motion-5
refuses "choose one of: ours, integral, none" --controller prefilter
refuses "choose one of: ours" --estimator ekf35
refuses "--frame thesis does not go with --world lab" --frame thesis
refuses "--gains text does not go with --world lab" --gains text
