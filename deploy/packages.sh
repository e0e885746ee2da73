#!/usr/bin/env bash
# Installs the Debian 12 packages that are missing. Silent, and without a network, when none is.
#   deploy/packages.sh build        to build and to run
#   deploy/packages.sh build test   to test, too
set -euo pipefail

# package/command: a command that is there already will do, wherever it came from.
build=(
  cmake ninja-build g++ pkg-config python3
  libeigen3-dev libboost-dev libspdlog-dev libfmt-dev libtomlplusplus-dev libcli11-dev nlohmann-json3-dev
  libtinyxml2-dev libsystemd-dev libzstd-dev # zstd: recordings
  libfastrtps-dev libfastcdr-dev fastddsgen default-jre-headless/java # fastddsgen is a Java program
  procps
  gnuplot-nox/gnuplot # motionlab-study --figures
  nodejs/node npm/npm # the libraries of the console's page
)
test=(
  libgtest-dev libgmock-dev
  cyclonedds-dev cyclonedds-tools # a stranger on the bus
  nodejs/node npm/npm             # strangers' clients
  chromium                        # looks at the console's page
  fastdds-tools/fast-discovery-server # knows everybody
  openssl                         # identities of DDS Security
  tshark                          # a stranger's dissector
  clang-14 libclang-rt-14-dev     # libFuzzer
  liborocos-kdl-dev               # other people's kinematics
  liborocos-bfl-dev               # other people's Kalman filters
  libxml2-utils/xmllint           # judges the figures
  clang-format-14 shellcheck
  nftables/nft iproute2/ip        # the firewall rules and the laboratory's addresses, in namespaces
  systemd/systemd-analyze systemd-container/systemd-nspawn systemd-sysv dbus # judge and boot the units
  dpkg-dev/dpkg-shlibdeps lintian debootstrap                                # make, judge and install the packages
)

wanted=()
for group in "${@:-build}"; do
  case $group in
    build) wanted+=("${build[@]}") ;;
    test) wanted+=("${test[@]}") ;;
    *)
      echo "packages.sh: there is no group $group; say build, or build test" >&2
      exit 64
      ;;
  esac
done

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "This is not Debian. Install what these packages of Debian 12 hold, and go on by hand: ${wanted[*]%%/*}" >&2
  exit 1
fi

installed=" $(dpkg-query -W -f='${db:Status-Status}:${Package} ' 2>/dev/null)"
missing=()
for entry in "${wanted[@]}"; do
  package=${entry%%/*}
  [[ $installed == *" installed:$package "* ]] && continue
  [[ $entry == */* ]] && command -v "${entry#*/}" >/dev/null && continue
  missing+=("$package")
done

# The libraries of the console's page, as its lock file pins them.
fetch_page() {
  cd gateway/console/page
  [[ node_modules/.package-lock.json -nt package-lock.json ]] && return 0
  local output
  echo "fetching the libraries of the console's page from npm"
  if ! output=$(npm ci --no-audit --no-fund --ignore-scripts 2>&1); then
    printf '%s\n' "$output" >&2
    echo "npm could not fetch them (above). Is there a network?" >&2
    return 1
  fi
  touch node_modules/.package-lock.json
}

cd "$(dirname "${BASH_SOURCE[0]}")/.."
if ((${#missing[@]} == 0)); then
  fetch_page
  exit
fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "Packages are missing, and there is no sudo. As root, run: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
as_root+=(env DEBIAN_FRONTEND=noninteractive)

echo "installing ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() { "${as_root[@]}" apt-get -q -y -o DPkg::Lock::Timeout=300 "$@" >>"$log" 2>&1 </dev/null; }
if ! apt update || ! apt install --no-install-recommends "${missing[@]}"; then
  tail -n 30 "$log" >&2
  echo "apt-get could not install them (above). Is there a network, and is this Debian 12?" >&2
  exit 1
fi
fetch_page
