#!/usr/bin/env bash
# A tool and a controller on another host than the gateway, found by multicast, by addresses, by a discovery server; and
# nobody by multicast where none goes.
#   discovery.sh GATEWAY SIM HAND PILOT
# shellcheck source=tests/hosts/hosts.sh
source "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
command -v fast-discovery-server >/dev/null || skip "fast-discovery-server (fastdds-tools) is not here"

readonly server=192.168.90.72:11811
tool() { on desk "$hand" --interface 192.168.90.71 "${flags[@]}" "$@"; }
healthy() { tool --timeout 3 status >"$here/status.log" 2>&1; }

# from_the_desk NAME: what $flags say is enough to look on, to measure, and to command.
from_the_desk() {
  eventually 40 healthy || fail "$1: the gateway is not seen, or not healthy"
  tool topics --endpoints >"$here/topics.log" 2>&1
  grep -q gateway-pc "$here/topics.log" || fail "$1: topics does not name the gateway's host"
  tool echo estimate --count 3 >"$here/echo.log" 2>&1 || fail "$1: no estimate is heard"
  tool --json delay --window 3 >"$here/delay.json" 2>"$here/delay.log" || fail "$1: no delay can be measured"
  tool reset >"$here/reset.log" 2>&1 || true
  on desk "$pilot" 192.168.90.71 "${pilot_words[@]}" >"$here/pilot.log" 2>&1 || fail "$1: the pilot cannot command"
  ok "$1: seen, measured (gateway-pc to desk $(last_hop "$here/delay.json")), commanded"
}

start_laboratory calm

flags=() pilot_words=()
start_gateway
from_the_desk "by multicast"
stop "$started"

for host in gateway-pc desk other; do
  on $host nft "add table ip wire; add chain ip wire out { type filter hook output priority 0; };
    add rule ip wire out ip daddr 224.0.0.0/4 drop" || skip "this kernel has no nftables"
done
start_gateway
if healthy; then fail "the gateway is found by multicast, although none goes"; fi
grep -q 'nobody answers' "$here/status.log" || fail "it is not said that nobody answers"
ok "no multicast, nobody found"
stop "$started"

flags=(--peer 192.168.90.70) pilot_words=(peer=192.168.90.70)
start_gateway 'peers = ["192.168.90.71"]'
from_the_desk "by addresses"
stop "$started"

flags=(--server "$server") pilot_words=("server=$server")
start server other fast-discovery-server -i 0 -l "${server%:*}" -p "${server#*:}"
start_gateway "server = \"$server\""
from_the_desk "by a discovery server"
