#!/usr/bin/env bash
# A real boot: the two packages installed into a clean root, booted under real systemd in a network namespace that has the
# laboratory's own addresses, the laboratory's own lab.toml, and the simulated laboratory at the other end of every wire.
#   boot.sh FOLDER_OF_PACKAGES
# Needs root and systemd-nspawn; says so and exits 77 where there is none.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=tests/package/root.sh
source tests/package/root.sh
packages=$(realpath "$1")

skip() {
  echo "skipped: $1"
  exit 77
}
((EUID == 0)) || skip "only root can boot a container"
for tool in systemd-nspawn ip python3; do command -v $tool >/dev/null || skip "$tool is not here"; done

readonly name=motionlab-boot-$$
here=$(mktemp -d)
container='' nspawn=''
cleanup() {
  set +e
  exec 2>/dev/null
  [[ -z $container ]] || nsenter -t "$container" -a systemctl poweroff
  if [[ -n $nspawn ]]; then
    for _ in $(seq 300); do kill -0 "$nspawn" || break; sleep 0.1; done
    kill -KILL "$container" "$nspawn"
    wait "$nspawn"
  fi
  ip netns del $name
  close_root "$here/root"
  rm -rf "$here"
}
trap cleanup EXIT
trap 'exit 130' INT TERM

fail() {
  echo "FAILED: $1"
  [[ -z $container ]] || in_container journalctl --no-pager -u motionlab-gateway -u motionlab-sim -n 60
  exit 1
}

open_root "$here/root" || skip "no overlay can be mounted here"
echo "in $root_kind"
readonly root=$here/root/root

# --- the laboratory's addresses, all in one namespace

ip netns add $name || skip "no network namespace can be made here"
ip -n $name link set lo up
ip -n $name link add lab type veth peer name lab-far # both ends here: an interface that is up, with multicast
ip -n $name link set lab up
ip -n $name link set lab-far up
for address in 192.168.90.{13,14,16,32,42,70,150}; do ip -n $name address add "$address/24" dev lab; done

# --- install, configure

chroot "$root" dpkg -i /dev/null >/dev/null 2>&1 || true # creates dpkg's own folders
cp "$packages"/motionlab-*.deb "$root/tmp/"
chroot "$root" sh -c 'dpkg -i /tmp/motionlab-*.deb' >"$here/dpkg" 2>&1 || {
  cat "$here/dpkg"
  fail "the packages do not install"
}
cp tests/hosts/laboratory.toml "$root/etc/motionlab/lab-addresses.toml"
echo 'OPTIONS="--scenario calm --overlay /etc/motionlab/lab-addresses.toml"' >"$root/etc/default/motionlab-sim"
# lab.toml stays as it is but for the limits of freshness: a machine that runs tests stands still now and then.
{
  printf '[%s]\nstale_after_s = 1.0\n' mru1 mru2 qualisys comau winch
  printf '[deadman]\nheartbeat_s = 1.0\ncontrol_s = 1.0\n'
} >"$root/etc/motionlab/slow-machine.toml"
echo 'OPTIONS="--overlay /etc/motionlab/slow-machine.toml"' >"$root/etc/default/motionlab-gateway"

# --- boot

systemd-nspawn -q --register=no --keep-unit --network-namespace-path=/run/netns/$name --capability=CAP_IPC_LOCK \
  --console=pipe -M $name -D "$root" --boot systemd.unit=multi-user.target </dev/null >"$here/console" 2>&1 &
nspawn=$!

# eventually SECONDS COMMAND…: again and again until it succeeds.
eventually() {
  local end=$((SECONDS + $1))
  shift
  until "$@"; do
    ((SECONDS < end)) || return 1
    sleep 0.2
  done
}
find_container() { container=$(pgrep -P $nspawn | head -1) && [[ -n $container ]]; }
in_container() { nsenter -t "$container" -a -- "$@"; }
booted() { [[ $(in_container systemctl is-system-running 2>/dev/null) =~ ^(running|degraded)$ ]]; }
eventually 30 find_container || {
  cat "$here/console"
  skip "systemd-nspawn cannot boot here"
}
if ! eventually 120 booted; then
  cat "$here/console"
  skip "systemd does not come up in a container here"
fi
echo "booted: systemd $(in_container systemctl --version | awk 'NR == 1 { print $2 }')"

property() { in_container systemctl show -P "$1" motionlab-gateway; }
is() { [[ $(property "$1") == "$2" ]]; }
status_has() { [[ $(property StatusText) == *"$1"* ]]; }
# entries FIELD=VALUE…: of the journal, as JSON.
entries() { in_container journalctl --no-pager -o json -u motionlab-gateway "$@"; }
logged() { [[ -n $(entries "$@") ]]; }
# What is searched is heard to its end: who is cut off in the middle of a sentence fails.
mode_is() { grep -q "\"state\": \"$1\"" <<<"$(in_container motionlab --json status 2>/dev/null)"; }
# A machine that stands still for a tenth of a second ends an engagement, rightly.
stood_still() { logged MOTIONLAB_CODE=lease_lost || logged MOTIONLAB_CODE=control_late; }
engage() { in_container motionlab --timeout 30 engage --wait 60 >"$here/engage" 2>&1; }
# seen_from_here PID: the number that a process of the container has out here.
seen_from_here() {
  local status
  for status in /proc/[0-9]*/status; do
    if grep -qE "^NSpid:.*\s$1$" "$status" 2>/dev/null && grep -qE '^Name:\s+motionlab-gatew' "$status"; then
      basename "$(dirname "$status")"
      return
    fi
  done
}
ok() { echo "ok $1"; }

# --- the checks

in_container systemctl start --no-block motionlab-gateway
eventually 60 status_has "waiting for mru1" || fail "the status does not say whom it waits for: $(property StatusText)"
is ActiveState activating || fail "it is $(property ActiveState) without any device"
ok "waits for its devices and says so"

in_container systemctl start motionlab-sim
eventually 90 is ActiveState active || fail "it does not become ready"
eventually 60 status_has "up: mru1 mru2 qualisys arm winch" || fail "status: $(property StatusText)"
ok "is ready when they are there"

grep -q '"MOTIONLAB_SOURCE":"house"' <<<"$(entries MOTIONLAB_CODE=ready)" || fail "no structured entry in the journal"
grep -q '"PRIORITY":"6"' <<<"$(entries MOTIONLAB_CODE=ready)" || fail "the entry has the wrong priority"
logged MOTIONLAB_SOURCE=mru1 MOTIONLAB_CODE=link_up || fail "no entry of mru1's link"
ok "writes to the journal with fields"

pid=$(property MainPID)
in_container grep -qE '^CapEff:\s+0+$' "/proc/$pid/status" || fail "it has capabilities"
[[ $(in_container stat -c %u "/proc/$pid") -ge 61184 ]] || fail "it runs as no dynamic user"
ok "has no capability and no user of its own"
if ((0x$(awk '/^CapEff/ { print $2 }' /proc/self/status) >> 24 & 1)); then
  if logged MOTIONLAB_CODE=kernel_refused; then fail "the kernel refused it something, with the limits of the unit"; fi
  grep -qE 'FF +control' <<<"$(in_container ps -L -o cls,comm -p "$pid")" || fail "control has no real-time scheduling"
  in_container grep -qE '^VmLck:\s+[1-9]' "/proc/$pid/status" || fail "no memory is locked"
  ok "has real-time threads and locked memory by its limits"
else
  echo "not checked: real-time threads and locked memory; on this machine even root cannot raise limits (CAP_SYS_RESOURCE)"
fi

engage || fail "it does not engage: $(cat "$here/engage")"
eventually 30 mode_is engaged || fail "it is not engaged"
ok "engages"

in_container sed -i -e 's/^log_level = "info"/log_level = "warning"/' -e 's/^period_s = 0.001 /period_s = 0.002 /' \
  /etc/motionlab/lab.toml
in_container systemctl reload motionlab-gateway || fail "it cannot be reloaded"
eventually 30 logged MOTIONLAB_CODE=reload_refused || fail "a key that takes a restart was not refused"
grep -q 'control. period_s stays' <<<"$(entries MOTIONLAB_CODE=reload_refused)" || fail "the refusal names no key"
eventually 30 status_has "reload refused [control] period_s" || fail "status: $(property StatusText)"
in_container sed -i 's/^log_level = "warning"/log_level = "loud"/' /etc/motionlab/lab.toml
if in_container systemctl reload motionlab-gateway 2>/dev/null; then fail "a file with an error was accepted"; fi
mode_is engaged || stood_still || fail "a reload ended the engagement"
in_container sed -i -e 's/^log_level = "loud"/log_level = "info"/' -e 's/^period_s = 0.002 /period_s = 0.001 /' \
  /etc/motionlab/lab.toml
in_container systemctl reload motionlab-gateway
is ActiveState active || fail "it is $(property ActiveState) after reloading"
ok "takes what may change live, refuses the rest by name, and a broken file whole"

# One thread hangs, all others are well.
restarts=$(property NRestarts)
python3 tests/package/hold_thread.py "$(seen_from_here "$(property MainPID)")" bus &
holder=$!
again() { [[ $(property NRestarts) == $((restarts + 1)) ]] && is ActiveState active; }
eventually 90 again || fail "a gateway with a hanging thread was not started again"
kill $holder 2>/dev/null || true
wait $holder 2>/dev/null || true
grep -q 'Watchdog timeout' <<<"$(in_container journalctl --no-pager -u motionlab-gateway)" || fail "it was not the watchdog"
grep -q 'the arm is at rest' <<<"$(in_container journalctl --no-pager -u motionlab-gateway)" || fail "the deadman was killed with it"
eventually 60 status_has "ready: " || fail "it does not come back ready: $(property StatusText)"
mode_is engaged && fail "it engaged by itself"
ok "is killed by the watchdog when a thread hangs, and comes back settled"

engage || fail "it does not engage again: $(cat "$here/engage")"
restarts=$(property NRestarts)
in_container systemctl kill --kill-who=main -s KILL motionlab-gateway
eventually 90 again || fail "a killed gateway was not started again"
eventually 60 status_has "ready: " || fail "it does not come back ready: $(property StatusText)"
mode_is engaged && fail "it engaged by itself"
ok "is started again after kill -9, and comes back settled"

engage || fail "it does not engage a third time: $(cat "$here/engage")"
in_container systemctl stop motionlab-gateway
is Result success || fail "it did not end well: $(property Result)"
logged MOTIONLAB_CODE=at_rest || fail "arm and winch were not brought to rest"
[[ $(property ExecStopPost) == *"--settle"*"pid="[1-9]* ]] || fail "--settle did not run after it"
ok "brings everything to rest when it is stopped"

in_container systemctl enable -q motionlab.target motionlab-gateway motionlab-sim
in_container systemctl start motionlab.target
eventually 90 is ActiveState active || fail "the target does not start it"
in_container systemctl stop motionlab.target
eventually 60 is ActiveState inactive || fail "the target does not stop it"
ok "starts and stops with motionlab.target"

# --- on a protected bus, as deploy/docs/security.md says

deploy/security/identities.sh "$here/identities" gateway operator=anna >"$here/identities.log"
install -d "$root/etc/motionlab/identity" "$root/etc/systemd/system/motionlab-gateway.service.d"
install -m 0600 "$here"/identities/gateway/* "$root/etc/motionlab/identity/"
cp -r "$here/identities/anna" "$root/srv/anna"
awk '/^\[Service\]/ { on = 1 } /^```/ { on = 0 } on' deploy/docs/security.md \
  >"$root/etc/systemd/system/motionlab-gateway.service.d/identity.conf"
# shellcheck disable=SC2016 # the backticks are the document's
protected=$(sed -n 's/^and `\(\[bus\] security = ".*"\)`\.$/\1/p' deploy/docs/security.md)
[[ -n $protected ]] || fail "deploy/docs/security.md does not say what [bus] security must be"
printf '[bus]\n%s\n' "${protected#\[bus\] }" >>"$root/etc/motionlab/slow-machine.toml"
in_container systemctl daemon-reload
in_container systemctl start motionlab-sim
in_container systemctl start motionlab-gateway || fail "it does not start with an identity"
eventually 60 status_has "ready: " || fail "it is not ready with an identity: $(property StatusText)"
healthy() { in_container motionlab --security /srv/anna --timeout 10 status >"$here/status" 2>&1; }
eventually 60 healthy || fail "an operator does not see it: $(cat "$here/status")"
code=0
in_container motionlab --timeout 5 status >"$here/status" 2>&1 || code=$?
((code == 2)) || fail "who has no identity sees it: $(cat "$here/status")"
in_container systemctl stop motionlab-gateway motionlab-sim
ok "has its identity handed over by systemd, and is seen by an operator alone"
