#!/usr/bin/env bash
# Installs what is missing, builds, runs every test. After the installing nothing needs a network.
#   tests/run.sh            everything; about half an hour on two cores from nothing
#   tests/run.sh --quick    the release build and its tests alone
# One line a step, the output of the steps that failed, and last how many tests passed and failed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

quick=false
case ${1:-} in
  '') ;;
  --quick) quick=true ;;
  *)
    echo "usage: tests/run.sh [--quick]" >&2
    exit 64
    ;;
esac

readonly fuzz_seconds=20 # each fuzzer
readonly logs=build/test-log
jobs=$(nproc)
readonly jobs
export LC_ALL=C.UTF-8
export TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp"
rm -rf "$logs"
mkdir -p "$logs"

# --- what the steps do

install_all() {
  deploy/packages.sh build test
  cd tests/interop
  [[ node_modules/.package-lock.json -nt package-lock.json ]] || npm ci --no-audit --no-fund --ignore-scripts
  cd ../..
  tests/package/root.sh prepare
}

# build PRESET TARGETS…
build() {
  cmake --preset "$1" -DMOTIONLAB_TESTS=ON
  cmake --build "build/$1" -j "$jobs" --target "${@:2}"
}

# A test of label real_time waits for sockets and clocks of this machine, which may stand still for longer than its patience:
# it may be tried twice. What runs on the virtual clock may not.
run_ctest() {
  local every=(ctest --test-dir build/release --parallel "$jobs" --output-on-failure --no-tests=error) failed=0
  "${every[@]}" --label-exclude '^real_time$' || failed=1
  "${every[@]}" --label-regex '^real_time$' --repeat until-pass:2 || failed=1
  return $failed
}

# A report of lab.sh says that the load hung still.
still() {
  python3 - "$1" <<'END'
import json, sys
report = json.load(open(sys.argv[1]))
swing, load = report["reduction"]["swing_rms"], report["load_error_rms_norm_m"]
print(f"swing reduced by {swing:.3f} (at least 0.95), load error {load:.4f} m (at most 0.030)")
sys.exit(not (swing >= 0.95 and load <= 0.030))
END
}

# From nothing to a still load, on real sockets. A shared machine may stand still for longer than any freshness limit:
# then the gateway rightly lets go, and one more try is allowed.
run_lab() {
  local try
  for try in 1 2; do
    if deploy/lab.sh --headless --seconds 60 --report "$logs/lab.json" && still "$logs/lab.json"; then
      echo "ok lab.sh, try $try"
      return 0
    fi
  done
  return 1
}

# What waits for this machine's clock may be tried twice.
twice() { "$@" || "$@"; }

# One GoogleTest program of a sanitized build. The race detector dislikes random addresses, where they can be helped.
run_program() { # PRESET TARGET
  local program output
  program=$(find "build/$1" -type f -executable -name "$2")
  steady() { if setarch -R true 2>/dev/null; then setarch -R "$@"; else "$@"; fi; }
  if output=$(steady "$program" --gtest_brief=1 2>&1); then
    printf '%s\n%s\n' "$2" "$output"
  else
    printf '%s\n%s\nnot ok %s\n' "$program" "$output" "$2"
    return 1
  fi
}

run_programs() { # PRESET TARGETS…
  printf '%s\0' "${@:2}" | xargs -0 -n 1 -P "$jobs" bash -c "run_program $1 \"\$0\""
}

export -f run_program

# --- how steps are run

passed=0 failed=0 failures=()

# Passed and failed tests in a log: as CTest sums them up, else of GoogleTest and of the functions above. What CTest quotes of a
# test that it then tried again is not counted.
count() {
  awk '
    match($0, /[0-9]+ tests failed out of [0-9]+/) {
      if (!summed) good = bad = 0
      summed = 1
      split(substr($0, RSTART), word, " "); bad += word[1]; good += word[6] - word[1]
    }
    summed { next }
    /^\[  PASSED  \] [0-9]+ test/ { good += $4 }
    /^\[  FAILED  \] [0-9]+ test.*listed below/ { bad += $4; named = 1 }
    /^ok / { good += 1 }
    /^not ok / { if (!named) bad += 1; named = 0 }
    END { print good + 0, bad + 0 }' "$1"
}

# step NAME COMMAND…: a step that fails without a failed test, such as a build, counts as one.
step() {
  local name=$1 begin=$SECONDS word=ok code good bad
  local log=$logs/${name// /-}.log
  set +e
  (set -e && "${@:2}") >"$log" 2>&1 </dev/null
  code=$?
  set -e
  read -r good bad < <(count "$log")
  if ((code == 77 && bad == 0)); then
    word=skipped # what this machine cannot do; the log's last line says why
    tail -n 1 "$log"
  elif ((code != 0 || bad > 0)); then
    word=FAILED
    failures+=("$log")
    ((bad > 0)) || bad=1
  fi
  passed=$((passed + good)) failed=$((failed + bad))
  printf '%-6s  %-24s %5d passed %5d s\n' "$word" "$name" "$good" $((SECONDS - begin))
  [[ $word != FAILED ]]
}

# --- the steps

# Memory: whatever reads bytes, and what it stands on. Races: what hands values from thread to thread.
memory_tests=(unit_core unit_faults) race_tests=(unit_core)
for folder in drivers/*/; do
  device=$(basename "$folder")
  [[ $device != core ]] || continue
  memory_tests+=("device_${device}_test")
done

if step "install" install_all; then
  if step "release build" build release all; then
    step "release tests" run_ctest || true
    $quick || step "lab" run_lab || true
    if ! $quick && step "packages" tests/package/packages.sh build/release; then
      step "boot" twice tests/package/boot.sh build/release/packages || true
    fi
  fi
  if ! $quick; then
    step "fuzz" tests/fuzz/run.sh --seconds "$fuzz_seconds" || true
    ! step "memory build" build asan "${memory_tests[@]}" || step "memory tests" run_programs asan "${memory_tests[@]}" || true
    ! step "race build" build tsan "${race_tests[@]}" || step "race tests" run_programs tsan "${race_tests[@]}" || true
  fi
fi

for log in ${failures[@]+"${failures[@]}"}; do
  printf '\n--- the end of %s\n' "$log"
  tail -n 100 "$log"
done
echo "$passed passed, $failed failed"
((failed == 0))
