#!/usr/bin/env bash
# Every public header includes what it needs. What a source includes before anything else has shown it by being built; the
# others are compiled here.
#   headers.sh COMPILER BUILD_FOLDER     (the build folder has the headers made from idl/)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
export compiler=$1 made=$2

files() { find "${@:2}" -name node_modules -prune -o -name "$1" -print; }

alone() {
  echo "#include \"$1\"" | "$compiler" -x c++ -std=c++20 -fsyntax-only -DMOTIONLAB_SOURCE_DIR='"."' -I. -I"$made/plain" -isystem "$made/twins" \
    -isystem /usr/include/eigen3 - || {
    echo "$1 does not compile alone"
    return 1
  }
}
export -f alone

shown=$(files '*.cpp' drivers gateway simulators tests | xargs grep -hm1 '^#include' | sed -n 's/^#include "\(.*\)"$/\1/p' | sort -u)
files '*.hpp' drivers gateway simulators | grep -vxFf <(echo "$shown") | xargs -n 1 -P "$(nproc)" bash -c "alone \"\$0\""
