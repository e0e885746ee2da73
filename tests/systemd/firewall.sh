#!/usr/bin/env bash
# The rules of `motionlab-gateway --nftables` in the kernel's own firewall, on the laboratory's own addresses, in a network
# namespace: the configured peers are heard, strangers are dropped and counted.
#   firewall.sh GATEWAY
set -euo pipefail
gateway=$1

for tool in nft ip unshare python3; do
  if ! command -v $tool >/dev/null; then
    echo "skipped: $tool is not here"
    exit 77
  fi
done
if [[ ${MOTIONLAB_INSIDE:-} != yes ]]; then
  if ! unshare --net true 2>/dev/null; then
    echo "skipped: no network namespace can be made here (needs root)"
    exit 77
  fi
  MOTIONLAB_INSIDE=yes exec unshare --net "$0" "$@"
fi

here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
ip link set lo up
if ! nft list ruleset >/dev/null 2>&1; then
  echo "skipped: this kernel has no nftables"
  exit 77
fi
# Everybody on one machine: gateway .42 and .70, units, cameras, robot computer, and somebody else.
for address in 192.168.90.{13,14,16,32,42,70,99}; do ip address add "$address/32" dev lo; done

"$gateway" --config deploy/config/lab.toml --nftables >"$here/open"
printf '[bus]\ninterfaces = ["192.168.90.70"]\n' >"$here/bus.toml"
"$gateway" --config deploy/config/lab.toml --overlay "$here/bus.toml" --nftables >"$here/rules"
"$gateway" --config deploy/config/lab.toml --overlay deploy/config/loopback.toml --nftables >"$here/loopback"
for file in open rules loopback; do nft -c -f "$here/$file"; done
nft -f "$here/rules"
nft -f "$here/rules" # it replaces itself

python3 - <<'END'
import socket, sys

wrong = []
def heard(port, to, source, source_port=0):
    there = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    there.bind((to, port))
    there.settimeout(1.0)
    here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    here.bind((source, source_port))
    try:
        here.sendto(b"x", (to, port))
    except PermissionError:
        return False
    try:
        return there.recv(10) == b"x"
    except TimeoutError:
        return False
    finally:
        there.close()
        here.close()

def expect(wanted, *case):
    if heard(*case) != wanted:
        wrong.append(f"{'not heard' if wanted else 'heard'}: port, to, from, source port {case}")

gateway, arm, stranger = "192.168.90.70", "192.168.90.42", "192.168.90.99"
expect(True, 50043, gateway, "192.168.90.13")
expect(True, 50044, gateway, "192.168.90.14")
expect(True, 50199, gateway, "192.168.90.16")
expect(True, 50042, arm, "192.168.90.32", 50032)
expect(False, 50042, arm, "192.168.90.32", 50031)
expect(False, 50043, gateway, "192.168.90.14")
for port, to in [(50042, arm), (50043, gateway), (50044, gateway), (50199, gateway)]:
    expect(False, port, to, stranger)
expect(True, 17910, gateway, stranger)   # the bus, on an interface that it uses (lo)
expect(True, 60000, gateway, stranger)   # not ours
print("\n".join(wrong))
sys.exit(bool(wrong))
END

# A host on another wire: not heard on the bus either.
ip netns add motionlab-other-$$
trap 'rm -rf "$here"; ip netns del motionlab-other-$$' EXIT
ip link add veth-ml type veth peer name eth0 netns motionlab-other-$$
ip address add 10.99.0.1/24 dev veth-ml
ip link set veth-ml up
ip -n motionlab-other-$$ address add 10.99.0.2/24 dev eth0
ip -n motionlab-other-$$ link set eth0 up
for port in 17910 50043; do
  ip netns exec motionlab-other-$$ python3 -c "
import socket
socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b'x', ('10.99.0.1', $port))"
done
packets() { nft list counter inet motionlab "$1" | grep -oE 'packets [0-9]+' | cut -d' ' -f2; }
for _ in $(seq 100); do
  [[ $(packets strangers_at_bus) == 1 && $(packets strangers_at_devices) == 7 ]] && break
  sleep 0.1
done
nft list table inet motionlab
echo "dropped: $(packets strangers_at_devices) at devices (7 wanted), $(packets strangers_at_bus) at the bus (1 wanted)"
[[ $(packets strangers_at_bus) == 1 && $(packets strangers_at_devices) == 7 ]]
