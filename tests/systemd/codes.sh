#!/usr/bin/env bash
# Every code that the gateway can tell is on the page that says what to do about it, and the page has no other.
set -euo pipefail
page=deploy/docs/recover.md
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT

# The forms in which a code stands in the source; one that is made otherwise must be added here.
code='[a-z][a-z0-9_]*'
{
  # A code may stand on the line below what it belongs to.
  find gateway -name '*.cpp' -exec cat {} + | tr -s ' \n' ' ' |
    grep -oE "(Obstacle\{ ?|stale\( ?|enter\(state_, t, |Transition\{[^\"}]*)\"$code\""
  grep -rhoE --include='*.cpp' "\"house\", \"$code\"" gateway/service
} | grep -oE "\"$code\"[^\"]*$" | tr -d '"' | sort -u >"$here/told"
grep -q '"link_" + link' gateway/service/program/house.cpp && printf 'link_%s\n' up stale connecting down >>"$here/told"
sort -u -o "$here/told" "$here/told"
if (($(wc -l <"$here/told") < 25)); then
  echo "only these codes were found in the source; the forms in $0 no longer fit it:"
  cat "$here/told"
  exit 1
fi

# The modes are codes of their events, too.
printf '%s\n' off settled engaged stopping ready >"$here/modes"
# The first column of its tables.
cut -d '|' -f 2 <(grep -E '^\| ' "$page") | grep -oE "\`$code\`" | tr -d '\`' | grep -vxE 'failed|watchdog' | sort -u >"$here/explained"

status=0
while read -r missing; do
  echo "$page does not say what to do about $missing"
  status=1
done < <(comm -23 "$here/told" "$here/explained")
while read -r invented; do
  echo "$page explains $invented, which nothing in the source tells"
  status=1
done < <(comm -13 <(sort -u "$here/told" "$here/modes") "$here/explained")
exit $status
