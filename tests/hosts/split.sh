#!/usr/bin/env bash
# Drivers, guard and deadman on one host, estimator and controller on another, somebody who looks on at a third: the
# load hangs still over the network, and the arm rests when the controller dies.
#   split.sh GATEWAY SIM HAND CONTROLLER
# shellcheck source=tests/hosts/hosts.sh
source "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
readonly controller=$pilot

look() { on other "$hand" --interface 192.168.90.72 "$@"; }
mode_has() { look --json --timeout 3 echo mode --once >"$here/mode.log" 2>&1 && grep -q "\"$1\"" "$here/mode.log"; }

printf '[bus]\ninterfaces = ["192.168.90.71"]\n' >"$here/desk.toml"
start_controller() {
  start controller desk "$controller" --config deploy/config/lab.toml --overlay deploy/config/loopback.toml \
    --overlay "$here/desk.toml" --name controller@desk --engage
}
readonly scenario=thesis-wave
start_laboratory "$scenario"
start_gateway ''
readonly running=$started

start_controller
readonly flying=$started
eventually 60 mode_has controller@desk || fail "the controller on the desk does not own the crane"
ok "the controller on the desk owns the crane on gateway-pc"

look --json delay --window 3 >"$here/delay.json" 2>"$here/delay.log" || fail "no delay can be measured"
ok "estimates from gateway-pc to other: $(last_hop "$here/delay.json")"

sleep 8
on gateway-pc "$hand" --interface 127.0.0.1 score --from 1 --seconds 16 --report "$here/score.json" \
  >"$here/score.log" 2>&1 || true # it misses the mode, which is on the wire alone
python3 - "$here/score.json" <<'END' || fail "the load does not hang still"
import json, sys
report = json.load(open(sys.argv[1]))
load, twin = report["load_error_rms_norm_m"], report["baseline"]["load_error_rms_norm_m"]
print(f"ok the load is kept within {1e3 * load:.1f} mm rms, without control it would be {1e3 * twin:.0f} mm")
sys.exit(not load < 0.05 * twin)
END

kill -9 "$flying"
eventually 20 mode_has fault || fail "the gateway does not notice that the controller has died"
ok "a controller that is killed loses its lease; the gateway rests and stays so"
stop "$running"
