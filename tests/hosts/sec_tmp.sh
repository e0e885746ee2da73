#!/usr/bin/env bash
# DDS Security between hosts: who has an identity of the laboratory does what its role may; who has none, or one of another
# authority, sees nothing and commands nothing; the wire tells nothing.
#   security.sh GATEWAY SIM HAND PILOT
# shellcheck source=tests/hosts/hosts.sh
source "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
for tool in openssl tshark; do command -v $tool >/dev/null || skip "$tool is not here"; done

deploy/security/identities.sh "$here/laboratory" gateway operator=anna observer=ben >"$here/identities.log"
deploy/security/identities.sh "$here/elsewhere" operator >>"$here/identities.log"

# tool IDENTITY WORD...: on the desk; identity "none" for none.
tool() {
  local identity=()
  [[ $1 == none ]] || identity=(--security "$here/$1")
  on desk "$hand" --interface 192.168.90.71 "${identity[@]}" "${@:2}"
}
# healthy [IDENTITY]: who has it sees a healthy gateway.
healthy() { tool "${1:-laboratory/anna}" --timeout 5 status >"$here/status.log" 2>&1; }

# words_on_the_wire: how many packets of three seconds hold the name of a type or a device. Names of topics are no judge: they
# stand in the permissions, which two who meet show each other in the open.
words_on_the_wire() {
  timeout 20 tshark -q -i wire -a duration:3 -w "$here/capture" >"$here/tshark.log" 2>&1 || true
  tshark -r "$here/capture" -Y 'frame contains "motionlab::" || frame contains "mru1"' 2>>"$here/tshark.log" | wc -l
}

# look_on IDENTITY: with a tool that keeps meeting the gateway, so that there is something to capture.
look_on() {
  while tool "$1" --timeout 1 status >/dev/null 2>&1 || true; do :; done &
  pids+=($!)
}

sees_nothing() {
  local code=0
  tool "$1" --timeout 5 status >"$here/nothing.log" 2>&1 || code=$?
  ((code == 2)) || fail "$1: status ends with $code, not with 2, nobody"
  tool "$1" topics --wait 5 --endpoints >"$here/nothing.log" 2>&1 || true
  if grep -E 'motionlab/(estimate|mode)' "$here/nothing.log"; then fail "$1: topics of the gateway are seen"; fi
}

start_laboratory calm

start_gateway
look_on none
plain=$(words_on_the_wire)
((plain > 0)) || fail "the capture is no judge: it has no name of a type in an unprotected bus"
stop "${pids[-1]}"
stop "$started"

start_gateway "security = \"$here/laboratory/gateway\""
readonly gateway_pid=$started
eventually 60 healthy || fail "the operator does not see a healthy gateway"
look_on laboratory/anna
protected=$(words_on_the_wire)
stop "${pids[-1]}"
((protected == 0)) || fail "names of types or devices are on the wire $protected times"
ok "the wire: $plain packets with names when unprotected, none when protected"

tool laboratory/anna --json delay --window 3 >"$here/delay.json" 2>"$here/delay.log" || fail "no delay can be measured"
cp "$here/delay.json" /tmp/delay.json; ok "an operator sees everything (gateway-pc to desk $(last_hop "$here/delay.json"))"
on desk "$pilot" 192.168.90.71 "security=$here/laboratory/anna" >"$here/pilot.log" 2>&1 || fail "the operator cannot command"
ok "and commands"

state() { tool laboratory/anna --json --timeout 5 status | python3 -c 'import json, sys; print(json.load(sys.stdin)["mode"]["state"])'; }
eventually 60 healthy laboratory/ben || fail "the observer does not see a healthy gateway"
tool laboratory/ben --timeout 5 echo estimate --count 3 >"$here/observer.log" 2>&1 || fail "the observer hears no estimate"
code=0
tool laboratory/ben engage >"$here/observer.log" 2>&1 || code=$?
((code == 64)) || fail "the observer's request ends with $code"
grep -q 'mode_request.*permissions' "$here/observer.log" || fail "the observer is not told why he may not"
[[ $(state) != engaged ]] || fail "an observer changed the mode to $(state)"
ok "an observer sees everything and cannot write mode_request"

for stranger in none elsewhere/operator; do
  sees_nothing $stranger
  tool $stranger --timeout 5 engage >"$here/stranger.log" 2>&1 && fail "$stranger: engage is said to be done"
  [[ $(state) != engaged ]] || fail "$stranger changed the mode to $(state)"
  ok "who has $stranger as identity sees nothing and commands nothing"
done

mv "$here/laboratory/ben/permissions.smime" "$here/ben.smime"
cp "$here/laboratory/anna/permissions.smime" "$here/laboratory/ben/"
code=0
tool laboratory/ben --timeout 5 status >"$here/borrowed.log" 2>&1 || code=$?
((code == 64)) || fail "permissions of somebody else are good for $code"
mv "$here/ben.smime" "$here/laboratory/ben/permissions.smime"
ok "permissions of somebody else are refused"

chmod 644 "$here/laboratory/ben/key.pem"
tool laboratory/ben status >"$here/open.log" 2>&1 && fail "a key that everybody can read is taken"
grep -q 'chmod 600' "$here/open.log" || fail "it is not said what to do about a key that everybody can read"
ok "a private key that others can read is refused"

kill -0 "$gateway_pid" || fail "the gateway is gone"
"$gateway" --config deploy/config/lab.toml --overlay "$here/gateway.toml" --check >"$here/check.log"
for key in "$here"/laboratory/*/key.pem; do
  while read -r line; do
    [[ $line == -----* ]] || ! grep -F -q -e "$line" "$here"/*.log || fail "a private key stands in a log"
  done <"$key"
done
ok "no private key stands in a log"
