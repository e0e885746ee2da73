#!/usr/bin/env bash
# motionlab-study --figures: every figure is there, well-formed by another's judgement, has units on its axes and a
# place on the page.
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
xmllint --noout "$figures/index.html" "$figures"/*.svg

wanted=(fig-4-{20,21,22,24,27,29,30,31,33,36,38,39,40} fig-5-{1,2,3,4,5,6,7,8,9,10,11,12,13}
  ours-{wave,wave-rest,sea,sea-rest,estimate,effort})
list=$("$study" --list)
page=$(<"$figures/index.html")
title="set label 1 '(.*)' at " axis="set ylabel '([^']*)'" with_unit=' \[(m|mm|deg)\]$'
for name in "${wanted[@]}"; do
  [[ $list == *$'\n'"  $name "* ]] || fail "--list does not show $name"
  svg=$(<"$figures/$name.svg")
  labels=('time [s]') curves=0
  while read -r line; do
    if [[ $line =~ $title ]]; then labels+=("${BASH_REMATCH[1]//\'\'/\'}"); fi
    if [[ $line == *' using 1:'* ]]; then curves=$((curves + 1)); fi
    if [[ $line =~ $axis ]]; then
      labels+=("${BASH_REMATCH[1]}")
      [[ ${BASH_REMATCH[1]} =~ $with_unit ]] || fail "$name has an axis without a unit: ${BASH_REMATCH[1]}"
    fi
  done <"$figures/$name.gp"
  ((${#labels[@]} >= 4 && curves >= 2)) || fail "$name.gp lacks labels or curves"
  for label in "${labels[@]}"; do
    [[ $svg == *">$label<"* ]] || fail "$name.svg does not show '$label'"
  done
  (($(grep -c '<path' "$figures/$name.svg") >= curves)) || fail "$name.svg lacks curves"
  [[ $page == *"id=\"$name\""*"<a href=\"$name.svg\"><img src=\"$name.svg\""* ]] ||
    fail "index.html does not show $name"
done
[[ $(in_page "//*[local-name()='figure']") == "${#wanted[@]}" ]] ||
  fail "index.html shows a figure that is not expected here"
[[ $(in_page "//*[local-name()='img'][string-length(@alt) < 40]") == 0 ]] ||
  fail "a figure says nothing to those who cannot see it"
[[ $(in_page "//*[local-name()='figcaption'][string-length(.) < 40]") == 0 ]] ||
  fail "a figure is not explained"
[[ $(in_page "//@*[starts-with(., 'http')]") == 0 && $page != *'url('* ]] ||
  fail "index.html needs more than its figures"

# What the page says of the scripts is so.
gnuplot -d <"$figures/fig-5-12.gp" | cmp - "$figures/fig-5-12.svg"
