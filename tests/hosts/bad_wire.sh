#!/usr/bin/env bash
# Gateway and laboratory on two hosts with the laboratory's own addresses, the unchanged lab.toml (but for the freshness
# limits of a shared machine), and a wire between them that loses, delays, reorders, doubles, and is cut. Whatever it does:
# the gateway keeps the load or rests; nothing resumes by itself; once the wire is well again it can be engaged again.
#   bad_wire.sh GATEWAY SIM HAND anything
# The kernel's netem makes what nftables cannot; where it is missing that is said.
# shellcheck source=tests/hosts/hosts.sh
source "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
command -v tc >/dev/null || skip "tc is not here"

look() { on desk "$hand" --interface 192.168.90.71 --timeout 20 "$@"; }
mode_is() { look --json status 2>/dev/null >"$here/status.json"; grep -q "\"state\": \"$1\"" "$here/status.json"; }

for address in 13 14 16 32 150; do ip -n other address add 192.168.90.$address/24 dev eth0; done
ip -n gateway-pc address add 192.168.90.42/24 dev eth0
printf '[bus]\ninterfaces = ["127.0.0.1"]\n' >"$here/sim.toml"
printf '[bus]\ninterfaces = ["192.168.90.70"]\n' >"$here/gateway.toml"
start sim other "$sim" --config deploy/config/world.toml --overlay tests/hosts/laboratory.toml \
  --overlay "$here/sim.toml" --scenario calm
start gateway gateway-pc "$gateway" --config deploy/config/lab.toml --overlay deploy/config/shared-vm.toml \
  --overlay "$here/gateway.toml"
start modes desk "$hand" --interface 192.168.90.71 --json echo mode --field state

# On both directions of the laboratory's wire.
drop() {
  on other nft "add table ip wire; add chain ip wire in { type filter hook input priority 0; };
    add chain ip wire out { type filter hook output priority 0; };
    add rule ip wire in ip saddr 192.168.90.0/24 $1 drop; add rule ip wire out ip daddr 192.168.90.0/24 $1 drop"
}
netem() {
  on other tc qdisc add dev eth0 root netem "$@" 2>>"$here/netem.log" && tc qdisc add dev other root netem "$@" 2>>"$here/netem.log"
}
mend() {
  on other nft delete table ip wire 2>/dev/null || true
  on other tc qdisc del dev eth0 root 2>/dev/null || true
  tc qdisc del dev other root 2>/dev/null || true
  ip link set other up
}

asked=0
engage() {
  # A machine that stands still ends an engagement, rightly: it may be asked twice.
  for _ in 1 2 3; do
    if mode_is fault; then look reset >>"$here/hand.log" 2>&1 || true; fi
    asked=$((asked + 1))
    if look engage --wait 60 >>"$here/hand.log" 2>&1; then return 0; fi
  done
  return 1
}

# through NAME SECONDS COMMAND…: engaged, then through so many seconds of it, then mended. Sets $state to what it led to.
through() {
  eventually 60 engage || fail "before \"$1\": it cannot be engaged"
  if ! "${@:3}"; then
    mend
    echo "not tried: $1: this kernel has no netem"
    return 1
  fi
  sleep "$2"
  mend
  sleep 3
  state=engaged
  mode_is engaged || state=$(grep -o '"state": *"[a-z]*"' "$here/status.json" | cut -d'"' -f4)
  [[ $state == engaged || $state == fault ]] || fail "$1: the gateway is $state"
  ok "$1: $state, $(grep -o '"reason": "[^"]*"' "$here/status.json" | head -n 1)"
}

eventually 90 mode_is ready || fail "it does not become ready"
through "30 % lost" 5 drop "numgen random mod 100 < 30" || true
through "cut for 3 s" 3 ip link set other down || true
[[ $state == fault ]] || fail "a wire that was cut for 3 s was not noticed"
through "delayed by 50 ms, give or take 20" 5 netem delay 50ms 20ms || true
through "reordered" 5 netem delay 5ms reorder 25% 50% || true
through "doubled" 5 netem duplicate 30% || true
eventually 60 engage || fail "after all that it cannot be engaged"

engaged=$(grep -o '"state": *"[a-z]*"' "$here/modes.log" | uniq | grep -c engaged)
((engaged <= asked)) || fail "it was engaged $engaged times and asked $asked times"
ok "engaged $engaged times, asked $asked times: nothing resumed by itself"
