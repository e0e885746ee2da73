#!/usr/bin/env bash
# Three hosts on one wire, each a network namespace of its own. To be sourced by a script whose arguments are
#   GATEWAY SIM HAND PILOT (or whatever else commands)
# gateway-pc 192.168.90.70: simulated laboratory on its loopback, gateway; desk .71: tools; other .72.
# Exits 77 where no namespace can be made.
set -euo pipefail
# shellcheck disable=SC2034 # for who sources this
gateway=$1 sim=$2 hand=$3 pilot=$4

skip() {
  echo "skipped: $1"
  exit 77
}
for tool in ip unshare nft python3 hostname; do
  command -v $tool >/dev/null || skip "$tool is not here"
done
# A network namespace for the wire, and mounts of its own, in which the hosts' names collide with nobody's.
if [[ ${MOTIONLAB_INSIDE:-} != yes ]]; then
  unshare --net --mount true 2>/dev/null || skip "no network namespace can be made here (needs root)"
  MOTIONLAB_INSIDE=yes exec unshare --net --mount "$0" "$@"
fi

here=$(mktemp -d)
pids=()
cleanup() {
  set +e
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null; done
  wait 2>/dev/null
  rm -rf "$here"
}
trap cleanup EXIT
trap 'exit 130' INT TERM

fail() {
  echo "FAILED: $1"
  tail -n 20 "$here"/*.log
  exit 1
}
ok() { echo "ok $1"; }

mkdir -p /run/netns
mount -t tmpfs tmpfs /run/netns || skip "nothing can be mounted here"
ip link add wire type bridge
ip link set wire up
number=70
for host in gateway-pc desk other; do
  ip netns add $host || skip "no network namespace can be made here"
  ip link add $host type veth peer name eth0 netns $host
  ip link set $host master wire up
  ip -n $host link set lo up
  ip -n $host address add 192.168.90.$number/24 dev eth0
  ip -n $host link set eth0 up
  number=$((number + 1))
done

# become HOST COMMAND…: there, under its name, in place of this shell.
become() {
  # shellcheck disable=SC2016 # for the inner shell
  exec ip netns exec "$1" unshare --uts sh -c 'hostname "$0" && exec "$@"' "$@"
}
# on HOST COMMAND…: there, to its end.
on() { (become "$@"); }

# start LOG HOST COMMAND…: in the background, until the end. Sets $started.
start() {
  become "${@:2}" >>"$here/$1.log" 2>&1 &
  started=$!
  pids+=("$started")
}

# stop PID: politely, and to its end.
stop() {
  kill "$1" 2>/dev/null || true
  wait "$1" 2>/dev/null || true
}

# eventually SECONDS COMMAND…: again and again until it succeeds.
eventually() {
  local end=$((SECONDS + $1))
  shift
  until "$@"; do
    ((SECONDS < end)) || return 1
    sleep 0.2
  done
}

# start_laboratory SCENARIO: on the loopback of gateway-pc.
start_laboratory() { start sim gateway-pc "$sim" --config deploy/config/world.toml --scenario "$1"; }

# start_gateway LINE…: with these lines in its [bus]. Sets $started.
start_gateway() {
  {
    printf '[bus]\ninterfaces = ["192.168.90.70"]\n'
    printf '%s\n' "$@"
    # A machine that runs tests stands still now and then.
    printf '[%s]\nstale_after_s = 1.0\n' mru1 mru2 qualisys comau winch
    printf '[deadman]\nheartbeat_s = 1.0\ncontrol_s = 1.0\n'
  } >"$here/gateway.toml"
  start gateway gateway-pc "$gateway" --config deploy/config/lab.toml --overlay deploy/config/loopback.toml \
    --overlay "$here/gateway.toml"
}

# How long estimates are under way between the hosts, out of `motionlab delay --json`.
last_hop() {
  python3 - "$1" <<'END'
import json, sys
hop, = [h for h in json.load(open(sys.argv[1]))["hops"] if "heard" in h["hop"] and "estimate" in h["of"]]
print(f'p50 {hop["p50"]:.0f} us, p99 {hop["p99"]:.0f} us of {hop["samples"]} estimates')
END
}
