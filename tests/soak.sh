#!/usr/bin/env bash
# What takes hours: every fuzzer for ten million executions, floods in earnest, and the laboratory over many seeds.
#   tests/soak.sh [--runs N] [--seeds N] [--only deadman|engagement|flood|fuzz|lab|recording|study|watching]
#     --runs N    executions of each fuzzer (10000000)
#     --seeds N   seeds of each scenario in lockstep (20); a tenth as many, at least one, on real sockets
# After tests/run.sh, whose packages and builds it needs. Logs are in build/soak-log.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

runs=10000000 seeds=20 only=''
while (($#)); do
  case $1:${2:-} in
    --runs:[1-9]* | --seeds:[1-9]* | --only:deadman | --only:engagement | --only:flood | --only:fuzz | --only:lab | --only:recording | --only:study | --only:watching)
      declare "${1#--}=$2"
      shift 2
      ;;
    *)
      sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
      exit 64
      ;;
  esac
done
readonly logs=build/soak-log study=build/release/simulators/lab/study/motionlab-study
mkdir -p "$logs"
failed=0

# step NAME COMMAND…: one line, and the end of the log of what failed.
step() {
  local name=$1 begin=$SECONDS
  [[ -z $only || $name == "$only"* ]] || return 0
  if "${@:2}" >"$logs/${name// /-}.log" 2>&1 </dev/null; then
    printf 'ok      %-28s %6d s\n' "$name" $((SECONDS - begin))
  else
    failed=$((failed + 1))
    printf 'FAILED  %-28s %6d s\n' "$name" $((SECONDS - begin))
    tail -n 30 "$logs/${name// /-}.log"
  fi
}

# A report says that the load hung still.
still() {
  python3 - "$1" <<'END'
import json, sys
report = json.load(open(sys.argv[1]))
swing, load = report["swing_rms_deg"], report["load_error_rms_norm_m"]
print(f"swing {swing:.3f} deg (at most 0.12), load {load:.4f} m (at most 0.012)")
sys.exit(not (swing <= 0.12 and load <= 0.012))
END
}
run_study() { # SCENARIO SEED
  "$study" --scenario "$1" --seed "$2" --seconds 600 --report "$logs/study.json" && still "$logs/study.json"
}
run_lab() { # SEED
  deploy/lab.sh --headless --seconds 600 --scenario sea --seed "$1" --report "$logs/lab.json" && still "$logs/lab.json"
}

# How late this machine wakes any thread that sleeps until a beat, as a stranger measures it.
wake_ups() {
  if ! command -v cyclictest >/dev/null; then
    echo "cyclictest is not installed (Debian: rt-tests): nothing to compare our wake-ups with"
    return 0
  fi
  cyclictest --quiet --mlockall --priority=50 --interval=1000 --duration=60 --histogram=1000 ||
    cyclictest --quiet --policy=other --interval=1000 --duration=60 --histogram=1000
}

step "fuzz" tests/fuzz/run.sh --runs "$runs"
step "engagement of half an hour" build/release/tests/bench/long_run
step "engagement's own machine" wake_ups
step "deadman of a hardened arm" build/release/tests/bench/deadman_kills --kills 100
step "deadman of a faithful arm" build/release/tests/bench/deadman_kills --kills 100 --robot faithful
step "recording to a RAM disk" build/release/tests/bench/bench_recording
step "watching" build/release/tests/bench/bench_watching
step "flood of the bus" build/release/tests/bench/bench_bus_flood
step "flood of datagrams" build/release/tests/bench/bench_datagram_flood
for ((seed = 1; seed <= seeds; ++seed)); do
  for scenario in thesis-wave sea; do step "study $scenario $seed" run_study "$scenario" "$seed"; done
done
for ((seed = 1; seed <= (seeds + 9) / 10; ++seed)); do step "lab $seed" run_lab "$seed"; done
((failed == 0))
