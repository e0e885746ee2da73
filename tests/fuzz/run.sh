#!/usr/bin/env bash
# Builds every fuzzer (build/fuzz, by clang) and runs each from its seeds: tests/fuzz/corpus/NAME, words in tests/fuzz/NAME.dict.
#   tests/fuzz/run.sh --seconds S [NAME…]     each so long, e.g. 20
#   tests/fuzz/run.sh --runs N [NAME…]        each so many executions, e.g. 10000000
# One line a fuzzer. An input that ends one is left in build/test-log/NAME-crash-….
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

usage() {
  echo "usage: tests/fuzz/run.sh --seconds S | --runs N [NAME…]" >&2
  exit 64
}
[[ ${2:-} =~ ^[0-9]+$ ]] || usage
case $1 in
  --seconds) export limit=-max_total_time=$2 ;;
  --runs) export limit=-runs=$2 ;;
  *) usage ;;
esac
shift 2

run_fuzzer() { # NAME
  local name=$1 output found code=0 words=()
  [[ ! -f tests/fuzz/$name.dict ]] || words=("-dict=tests/fuzz/$name.dict")
  found=$(mktemp -d)
  output=$("build/fuzz/${name}_fuzz" "$limit" "${words[@]}" -timeout=5 -print_final_stats=1 \
    -artifact_prefix="build/test-log/$name-" "$found" "tests/fuzz/corpus/$name" 2>&1) || code=$?
  rm -rf "$found"
  if ((code == 0)); then
    echo "ok $name: $(grep -o 'number_of_executed_units: *[0-9]*' <<<"$output")"
  else
    printf '%s\nnot ok %s\n' "$output" "$name"
  fi
  return $code
}
export -f run_fuzzer

mkdir -p build/test-log
cmake -S tests/fuzz -B build/fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++-14
cmake --build build/fuzz -j "$(nproc)"
names=("$@")
if ((${#names[@]} == 0)); then
  for source in tests/fuzz/*_fuzz.cpp; do names+=("$(basename "$source" _fuzz.cpp)"); done
fi
printf '%s\0' "${names[@]}" | xargs -0 -n 1 -P "$(nproc)" bash -c "run_fuzzer \"\$0\""
