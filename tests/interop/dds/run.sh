#!/bin/sh
# Cyclone DDS on one end, our bus on the other, on loopback: every value must arrive to the last bit.
#   run.sh OUR_PEER CYCLONE_SUBSCRIBER CYCLONE_REQUESTER CYCLONE_ECHO
set -eu
peer=$1 subscriber=$2 requester=$3 echo=$4
domain=$((90 + $$ % 5)) # tests/support/own_domain.hpp has those below 85
work=$(mktemp -d)
trap 'exec 3>&-; rm -rf "$work"' EXIT
export CYCLONEDDS_URI='<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General></Domain></CycloneDDS>'

echo "== ours to Cyclone: motionlab/mru, motionlab/estimate"
mkfifo "$work/stay"
"$peer" publish $domain <"$work/stay" >"$work/written" &
publisher=$!
exec 3>"$work/stay"
"$subscriber" $domain 20 3>&- >"$work/read"
exec 3>&-
wait $publisher
# The stranger prints every field of the MRU and a selection of the estimate's; keep the same of ours.
fields=$(awk '$1 == "estimate" { for (i = 2; i <= NF; ++i) { split($i, kv, "="); printf " %s", kv[1] }; exit }' "$work/read")
awk -v fields="$fields" '
  BEGIN { n = split(fields, list, " "); for (i = 1; i <= n; ++i) keep[list[i]] = 1 }
  $1 == "mru" { print; next }
  { line = $1; for (i = 2; i <= NF; ++i) { split($i, kv, "="); if (kv[1] in keep) line = line " " $i }; print line }
' "$work/written" >"$work/expected"
[ "$(grep -c '^mru ' "$work/read")" -eq 20 ] && [ "$(grep -c '^estimate ' "$work/read")" -eq 20 ]
if grep -vxFf "$work/expected" "$work/read"; then
  echo "Cyclone read the lines above, which we never wrote" >&2
  exit 1
fi

echo "== Cyclone to ours: motionlab/mode_request"
name="requester-with-exactly-32-letters"
[ ${#name} -eq 33 ] && name=${name%s}
"$peer" receive $domain 10 >"$work/requests" &
receiver=$!
"$requester" $domain 10 "$name"
wait $receiver
for n in 1 2 3 4 5 6 7 8 9 10; do
  if [ $((n % 2)) -eq 1 ]; then action=engage; else action=authority; fi
  echo "$name $n -$((1000000007 * n)) $action limited"
done >"$work/expected"
diff "$work/expected" "$work/requests"
echo "== ours to Cyclone and, what it understood, back: every topic"
mkfifo "$work/remain"
"$echo" $domain <"$work/remain" &
mirror=$!
exec 3>"$work/remain"
"$peer" echo $domain 3>&- >"$work/echoed"
exec 3>&-
wait $mirror
sort "$work/echoed"
echo "== well"
