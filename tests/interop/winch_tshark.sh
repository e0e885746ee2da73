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
  tshark -n -r "$work/session.pcap" -o tcp.check_checksum:FALSE -o ip.check_checksum:FALSE "$@" 2>>"$work/errors"
}

read_capture -Y '_ws.malformed || _ws.expert.severity == error' >"$work/marked"
if [[ -s $work/marked ]]; then
  cat "$work/marked"
  exit 1
fi
# What must be seen: the number of an AMS command, and the least number of frames with it.
read_capture -Y 'tcp.len > 0' -T fields -e ams.cmdid >"$work/commands"
awk '
  BEGIN {
    split("1 2 3 4 6 7 8 9", command); split("2 6 200 4 2 2 50 6", least)
    for (i in command) wanted[command[i]] = least[i]
  }
  !($1 in wanted) && $1 != 77 { print "packet " NR " is no AMS for tshark: " $1; bad = 1 } # 77 was asked to be refused
  { ++seen[$1] }
  END {
    for (c in wanted) if (seen[c] < wanted[c]) { print "tshark sees " seen[c] + 0 " frames of command " c; bad = 1 }
    if (!bad) print "tshark reads all " NR " frames"
    exit bad
  }' "$work/commands"
