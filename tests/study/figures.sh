#!/usr/bin/env bash
# motionlab-study --figures: every figure is there, well-formed by another's judgement, has units on its axes and a place on
# the page.
#   figures.sh PROGRAM
set -euo pipefail
study=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
figures=$folder/made/figures

fail() {
  echo "$1" >&2
  exit 1
}

# refuses SENTENCE [VARIABLE=VALUE…] OPTION…: the program, in such an environment, exits with 2 and says so.
refuses() {
  local sentence=$1 status=0 environment=()
  shift
  while [[ $1 == *=* ]]; do
    environment+=("$1")
    shift
  done
  env "${environment[@]}" "$study" "$@" >"$folder/out" 2>"$folder/err" || status=$?
  [[ $status == 2 ]] || fail "motionlab-study $* ended with $status, not 2"
  grep -qF -- "$sentence" "$folder/err" || fail "motionlab-study $* said: $(cat "$folder/err")"
}

# in_page XPATH: how often that is in the page.
in_page() { xmllint --xpath "count($1)" "$figures/index.html"; }

refuses "--scenario does not go with --figures; these do: --seed, --seconds" --figures "$figures" --scenario sea
refuses "cannot make the folder" --figures "$study/figures"
refuses "install it (Debian: gnuplot-nox)" PATH=/nowhere --figures "$figures"

"$study" --figures "$figures" --seconds 12 >"$folder/out" 2>"$folder/err"
[[ ! -s $folder/err ]] || fail "gnuplot complains: $(cat "$folder/err")"
grep -qF "$figures/index.html" "$folder/out" || fail "it does not say what to open: $(cat "$folder/out")"
xmllint --noout "$figures/index.html"

wanted=(fig-4-{20,21,22,24,27,29,30,31,33,36,38,39,40} fig-5-{1,2,3,4,5,6,7,8,9,10,11,12,13}
  ours-{wave,wave-rest,sea,sea-rest,estimate,effort})
"$study" --list >"$folder/list"
for name in "${wanted[@]}"; do
  grep -q "^  $name " "$folder/list" || fail "--list does not show $name"
  svg=$figures/$name.svg
  xmllint --noout "$svg"
  texts=$(xmllint --xpath "//*[local-name()='text']" "$svg")
  for label in time "$(sed -n "s/^set label 1 '\([^']*\).*/\1/p" "$figures/$name.gp")"; do
    [[ -n $label && $texts == *"$label"* ]] || fail "$name.svg does not show '$label'"
  done
  grep '^set ylabel' "$figures/$name.gp" >"$folder/labels"
  if grep -vE " \[(m|mm|deg)\]'" "$folder/labels"; then fail "$name has an axis without a unit"; fi
  (($(grep -c '<path' "$svg") >= $(grep -c ' using 1:' "$figures/$name.gp"))) || fail "$name.svg lacks curves"
  [[ $(in_page "//*[local-name()='a'][@href='$name.svg']/*[@src='$name.svg'][string-length(@alt) > 40]") == 1 ]] ||
    fail "index.html does not show $name, or not to those who cannot see it"
  [[ $(in_page "//*[@id='$name']/*[local-name()='figcaption'][string-length(.) > 40]") == 1 ]] ||
    fail "index.html does not explain $name"
done
[[ $(in_page "//*[local-name()='img']") == "${#wanted[@]}" ]] || fail "index.html shows a figure that is not expected here"
if grep -E 'https?://' "$figures/index.html" | grep -v 'xmlns='; then fail "index.html needs a network"; fi

# What the page says of the scripts is so.
gnuplot -d <"$figures/fig-5-12.gp" | cmp - "$figures/fig-5-12.svg"
