#!/usr/bin/env bash
# One device is a fixed set of files (drivers/README.md): codec, driver, simulated device, tests with golden bytes, fuzzer,
# and a section in the example configuration.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
status=0
missing() {
  echo "$1"
  status=1
}

for device in $(basename -a drivers/*/ simulators/*/ | sort -u); do
  case $device in core | faults | lab | plant) continue ;; esac
  for file in "drivers/$device/${device}_"{wire,driver}.hpp "simulators/$device/${device}_device".{hpp,cpp} \
    "drivers/$device/${device}_driver.cpp" "tests/fuzz/${device}_fuzz.cpp"; do
    [[ -f $file ]] || missing "$device lacks $file"
  done
  compgen -G "drivers/$device/${device}_wire*.cpp" >/dev/null || missing "$device lacks drivers/$device/${device}_wire.cpp"
  compgen -G "tests/fuzz/corpus/$device/*" >/dev/null || missing "$device lacks seeds for its fuzzer in tests/fuzz/corpus/$device"
  if ! compgen -G "tests/$device/*_test.cpp" >/dev/null; then
    missing "$device lacks tests/$device/*_test.cpp"
  elif ! grep -qiE 'published|constructed' "tests/$device/"*; then
    missing "$device: no test of tests/$device says of its golden bytes whether they are published or constructed"
  fi
  grep -qE "^\[${device}[0-9]*\]" deploy/config/lab.toml || missing "$device lacks a section [$device] in deploy/config/lab.toml"
done
exit $status
