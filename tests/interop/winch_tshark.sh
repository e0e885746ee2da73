#!/usr/bin/env bash
# Wireshark's own AMS dissector reads what the simulated winch controller says: every frame, none malformed.
#   winch_tshark.sh PATH/TO/interop_winch_server
# The session is played by ads_decode.py and written as a capture file, so that nobody needs the right to capture.
set -euo pipefail
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 "$folder/ads_decode.py" "$1" "$work/session.pcap"
read_capture() {
  tshark -n -r "$work/session.pcap" -o tcp.check_checksum:FALSE -o ip.check_checksum:FALSE "$@" 2>"$work/errors"
}

malformed=$(read_capture -Y '_ws.malformed || _ws.expert.severity == error' | tee /dev/stderr | wc -l)
if ((malformed > 0)); then
  echo "$malformed packets have a mark of tshark"
  exit 1
fi
number() { read_capture -Y "$1" | wc -l; }
status=0
# What must be seen: AMS command, and the least number of frames with it.
while read -r command least name; do
  seen=$(number "ams.cmdid == $command")
  if ((seen < least)); then
    echo "tshark sees $seen frames of $name, and not $least"
    status=1
  fi
done <<'END'
1 2 ReadDeviceInfo
2 6 Read
3 200 Write
4 4 ReadState
6 2 AddDeviceNotification
7 2 DeleteDeviceNotification
8 50 DeviceNotification
9 6 ReadWrite
END
# No packet with data that is not AMS for it.
strange=$(number 'tcp.len > 0 && !ams')
if ((strange > 0)); then
  echo "$strange packets are no AMS for tshark"
  status=1
fi
((status)) || echo "tshark reads all of it"
exit $status
