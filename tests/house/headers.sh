#!/usr/bin/env bash
# Every header includes what it needs.
#   headers.sh COMPILER BUILD_FOLDER     (the build folder has the headers made from idl/)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
export compiler=$1 made=$2

alone() {
  echo "#include \"$1\"" | "$compiler" -x c++ -std=c++20 -fsyntax-only -DMOTIONLAB_SOURCE_DIR='"."' -I. -I"$made/plain" -isystem "$made/twins" \
    -isystem /usr/include/eigen3 - || {
    echo "$1 does not compile alone"
    return 1
  }
}
export -f alone

find drivers gateway simulators tests -name node_modules -prune -o -name '*.hpp' -print0 |
  xargs -0 -n 1 -P "$(nproc)" bash -c "alone \"\$0\""
