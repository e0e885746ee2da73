#!/bin/sh
# tshark looks on while our bus and Cyclone talk, at the ports of their domain alone: all that passes is RTPS to it, without a
# malformed mark.
#   tshark.sh OUR_PEER CYCLONE_ECHO      77 (left out) where nothing may be captured
set -eu
peer=$1 echo=$2
domain=$((95 + $$ % 5)) # below the ports that the kernel gives to others
first=$((7400 + 250 * domain)) # RTPS 2.2, 9.6.1.1; the echo uses the next domain, too
last=$((first + 499))
work=$(mktemp -d)
trap 'exec 3>&-; rm -rf "$work"' EXIT
export CYCLONEDDS_URI='<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General></Domain></CycloneDDS>'

command -v tshark >/dev/null || { echo "tshark is not installed (Debian: tshark)"; exit 77; }
tshark -q -i lo -f "udp portrange $first-$last" -w "$work/capture.pcapng" >"$work/tshark.log" 2>&1 &
tshark=$!
for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do
  grep -q "Capturing on" "$work/tshark.log" && break
  kill -0 $tshark 2>/dev/null || { cat "$work/tshark.log"; exit 77; }
  sleep 1
done

mkfifo "$work/remain"
"$echo" $domain <"$work/remain" &
mirror=$!
exec 3>"$work/remain"
"$peer" echo $domain 3>&- >"$work/echoed"
exec 3>&-
wait $mirror
sleep 2 # what was captured is written
kill -INT $tshark
wait $tshark || true

count() { tshark -n -r "$work/capture.pcapng" -Y "$1" 2>/dev/null | wc -l; }
# Fast DDS wakes its own multicast receivers at the end by one byte: 9 with the header.
other=$(count "udp && !rtps && udp.length != 9") rtps=$(count rtps) data=$(count "rtps.sm.id == 0x15")
malformed=$(count "_ws.malformed")
echo "$rtps datagrams of RTPS, $data with data, $malformed malformed, $other of another kind"
if [ "$malformed" -ne 0 ] || [ "$other" -ne 0 ]; then
  tshark -n -r "$work/capture.pcapng" -Y "_ws.malformed || (udp && !rtps && udp.length != 9)" -V 2>/dev/null | head -n 100
  exit 1
fi
[ "$data" -ge 100 ]
