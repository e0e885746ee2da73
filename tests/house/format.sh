#!/usr/bin/env bash
# C++ and C look as .clang-format says. Formatting differs from version to version: ours is Debian 12's.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
find drivers gateway simulators tests -name node_modules -prune -o -type f \( -name '*.hpp' -o -name '*.cpp' -o -name '*.c' \) -print0 |
  xargs -0 -n 8 -P "$(nproc)" clang-format-14 --dry-run -Werror
