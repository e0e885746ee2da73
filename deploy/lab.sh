#!/usr/bin/env bash
# From nothing to a still load: installs what is missing, builds, starts a simulated laboratory and the gateway as separate
# processes on loopback, engages at 10 s, and says once a second how still the load is. Leaves nothing running.
set -euo pipefail

readonly engage_at_s=10 score_from_s=20 calm_before_s=5
readonly healthy_within_s=20 # of real time
readonly page=127.0.0.1:8080

usage() {
  cat <<'END'
usage: deploy/lab.sh [--scenario NAME] [--seed N] [--seconds S] [--headless] [--report FILE]

  --scenario NAME  thesis-wave (default), sea, pierson-moskowitz, calm
  --seed N         of everything random (1)
  --seconds S      length of the run, more than 20 (until Ctrl-C; with --headless 60)
  --headless       nothing but this terminal: no page
  --report FILE    write the score as JSON

The sea begins at 0 s, the gateway is engaged at 10 s, the score counts from 20 s on. Needs Debian 12; packages that are
missing are installed with apt-get (deploy/packages.sh).
Exit codes: 0 the run was complete, 1 it was not (the last sentence says what to do), 64 wrong usage, 130 interrupted.
END
}

wrong_usage() {
  echo "lab.sh: $1; see deploy/lab.sh --help" >&2
  exit 64
}

fail() {
  echo "lab.sh: $1" >&2
  [[ -d ${logs:-} ]] && echo "lab.sh: the programs' own words are in $logs" >&2
  exit 1
}

# --- what is wanted

scenario=thesis-wave seed=1 seconds='' headless=false report=''
while (($#)); do
  case $1 in
    --headless) headless=true ;;
    --help | -h)
      usage
      exit 0
      ;;
    --scenario | --seed | --seconds | --report)
      (($# > 1)) || wrong_usage "$1 needs a value"
      declare "${1#--}=$2"
      shift
      ;;
    *) wrong_usage "there is no $1" ;;
  esac
  shift
done
case $scenario in
  thesis-wave | sea | pierson-moskowitz | calm) ;;
  *) wrong_usage "there is no scenario $scenario" ;;
esac
[[ $seed =~ ^[0-9]{1,18}$ ]] || wrong_usage "--seed $seed is no whole number"
$headless && seconds=${seconds:-60}
if [[ -n $seconds ]] && { [[ ! $seconds =~ ^[0-9]{1,6}$ ]] || ((10#$seconds <= score_from_s)); }; then
  wrong_usage "--seconds $seconds is no whole number above $score_from_s, where the score begins"
fi
if [[ -n $report ]]; then
  report=$(realpath -m -- "$report")
  [[ ! -d $report && -w $(dirname -- "$report") ]] || wrong_usage "the report cannot be written to $report"
fi

# --- install, build

cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly build=$PWD/build/release logs=$PWD/build/lab-log
mkdir -p "$build"
exec 9>"$build/lab.lock"
flock -n 9 || fail "another deploy/lab.sh of this folder is running; stop it with Ctrl-C in its terminal"
rm -rf "$logs"
mkdir -p "$logs"

deploy/packages.sh build
# On a terminal Ninja shows how far it is; elsewhere only what went wrong is worth reading.
quietly() {
  if [[ -t 1 ]]; then
    "$@"
  else
    "$@" >"$logs/build.log" 2>&1 || {
      tail -n 40 "$logs/build.log" >&2
      return 1
    }
  fi
}
echo "building (the first time takes some minutes)"
if [[ ! -f $build/build.ninja ]]; then
  quietly cmake --preset release -DMOTIONLAB_TESTS=OFF || fail "CMake could not configure (above)"
fi
quietly cmake --build "$build" --target motionlab motionlab-console motionlab-gateway motionlab-sim motionlab-study 9>&- ||
  fail "the build failed (above)"

readonly sim=$build/simulators/lab/sim/motionlab-sim
readonly gateway=$build/gateway/service/program/motionlab-gateway
unset MOTIONLAB_DOMAIN MOTIONLAB_INTERFACE # the files say where this laboratory is
readonly hand=$build/gateway/monitor/program/motionlab
status() { "$hand" --interface 127.0.0.1 --timeout 1 status >"$logs/status.log" 2>&1 9>&-; }

# --- run

declare -A pid=()
interrupted=false

# Each program is a process group of its own, so that Ctrl-C reaches this script alone, which stops them in order; and
# each is ended by the kernel should this script be killed.
start() {
  local name=$1
  shift
  setsid setpriv --pdeathsig TERM "$@" 9>&- &
  pid[$name]=$!
}

alive() { [[ -n ${pid[$1]:-} ]] && kill -0 "${pid[$1]}" 2>/dev/null; }

# stop NAME SIGNAL SECONDS: politely; then not.
stop() {
  local name=$1 tenth
  alive "$name" || return 0
  kill -s "$2" "${pid[$name]}" 2>/dev/null || true
  for ((tenth = 0; tenth < 10 * $3; ++tenth)); do
    alive "$name" || return 0
    sleep 0.1
  done
  echo "lab.sh: $name did not stop within $3 s and is killed" >&2
  kill -s KILL -- "-${pid[$name]}" 2>/dev/null || true
}

stop_all() {
  stop engage INT 2
  stop score INT 5
  stop console INT 2
  stop gateway INT 12 # brings arm and winch to rest first
  stop simulator INT 5
  local name left=''
  for name in "${!pid[@]}"; do
    wait "${pid[$name]}" 2>/dev/null || true
    if pgrep -g "${pid[$name]}" >/dev/null; then left+=" $name (process group ${pid[$name]})"; fi
  done
  [[ -z $left ]] || echo "lab.sh: still running:$left; end them by hand" >&2
}
trap stop_all EXIT
trap 'interrupted=true' INT TERM HUP

# The last words of a program that ended by itself.
ended() {
  local code=0
  wait "${pid[$1]}" || code=$?
  tail -n 5 "$logs/$1.log" >&2
  if ((code == 2)); then
    fail "the $1 did not start (above); is another laboratory running on this machine? pgrep -a motionlab tells"
  fi
  fail "the $1 ended by itself with code $code (above); run it again, and tell us with its log if it comes back"
}

check_alive() {
  alive simulator || ended simulator
  alive gateway || ended gateway
  ! $interrupted || exit 130
}

now_ns() { date +%s%N; }
start_ns=$(($(now_ns) + calm_before_s * 1000000000))

echo "starting the simulated laboratory ($scenario, seed $seed) and the gateway on 127.0.0.1"
start simulator "$sim" --config deploy/config/world.toml --scenario "$scenario" --seed "$seed" \
  --start-at-ns "$start_ns" >"$logs/simulator.log" 2>&1
start gateway "$gateway" --config deploy/config/lab.toml \
  --overlay deploy/config/loopback.toml --overlay deploy/config/shared-vm.toml >"$logs/gateway.log" 2>&1
echo "limits of freshness are wider than in a laboratory, because shared virtual machines stand still now and then:" \
  "deploy/config/shared-vm.toml"

# The page. Its token is this run's own; whoever can read this terminal may engage.
if ! $headless; then
  (umask 077 && od -An -N16 -tx1 /dev/urandom | tr -d ' \n' >"$logs/console.token")
  start console "$build/gateway/console/program/motionlab-console" --listen "$page" --config deploy/config/lab.toml \
    --overlay deploy/config/loopback.toml --overlay deploy/config/shared-vm.toml \
    --control --token-file "$logs/console.token" >"$logs/console.log" 2>&1
  for ((tenth = 0; tenth < 50; ++tenth)); do
    grep -q 'http://' "$logs/console.log" && break
    alive console || break
    sleep 0.1
  done
  if alive console; then
    echo "see it: http://$page/   token for engage and reset: $(<"$logs/console.token")"
  else
    echo "lab.sh: there is no page: $(tail -n 1 "$logs/console.log")" >&2
  fi
fi

deadline_ns=$(($(now_ns) + healthy_within_s * 1000000000))
until status; do
  check_alive
  if (($(now_ns) > deadline_ns)); then
    cat "$logs/status.log" >&2
    fail "not everything is healthy after $healthy_within_s s (above); a lost device says there what to look at"
  fi
done
check_alive
cat "$logs/status.log"

# Nothing to see before the sea begins; but who listens must be there by then.
while (($(now_ns) < start_ns - 1000000000)); do
  check_alive
  sleep 0.1
done
score=(--start-ns "$start_ns" --from "$score_from_s" --scenario "$scenario" --seed "$seed")
[[ -z $seconds ]] || score+=(--seconds "$((10#$seconds))")
[[ -z $report ]] || score+=(--report "$report")
start score "$hand" --interface 127.0.0.1 score "${score[@]}" 2>"$logs/score.log"
start engage "$hand" --interface 127.0.0.1 engage --at-ns $((start_ns + engage_at_s * 1000000000)) >"$logs/engage.log" 2>&1

while alive score && ! $interrupted; do
  check_alive
  if [[ -n ${pid[engage]:-} ]] && ! alive engage; then
    wait "${pid[engage]}" || {
      $interrupted && break
      cat "$logs/engage.log" >&2
      fail "the gateway did not engage (above); clear that up and run it again"
    }
    unset "pid[engage]"
  fi
  sleep 0.1
done

# --- judge

if $interrupted; then
  stop score INT 5
else
  check_alive
fi
score_code=0
wait "${pid[score]}" || score_code=$?
if ((score_code != 0)); then
  cat "$logs/score.log" >&2
  $interrupted && exit 130
  fail "there is no complete score (above)"
fi
$interrupted && [[ -n $seconds ]] && exit 130
status || true
if ! grep -q '^gateway *engaged' "$logs/status.log"; then
  cat "$logs/status.log" >&2
  fail "the gateway let the load go during the run (above); on a machine that stands still for long, try again"
fi
[[ -z $report ]] || echo "report in $report"
