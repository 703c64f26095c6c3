#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the packages of Debian 12 or 13 that are needed to build and run vdrive.
#
#   deploy/setup.sh [--tests] [--page] [--python] [--browser] [--judges] [--images]
#
#   --tests     also the packages for the tests, the benchmarks and the lint
#   --page      also node and npm, if missing: they build the page of the gateway
#   --python    also the packages to build the Python module; included in --tests
#   --browser   also the browser that tests the page
#   --judges    also third-party programs that check the output of the bridges
#   --images    also the packages to run container images
#
# Installs only missing packages, with apt, through sudo unless run as root. Prints nothing if
# nothing is missing. Writes to standard error only. Exit code 0: all packages are installed.
set -euo pipefail

fail() {
  echo "setup: $*" >&2
  exit 1
}

# Prints a variable of os-release(5); nothing if it is not set.
system() {
  # shellcheck disable=SC1091
  (. /etc/os-release && printf '%s' "${!1:-}") 2>/dev/null || true
}

# All packages below have the same names in both releases, except the DDS library.
case $(system ID)-$(system VERSION_ID) in
  debian-12) dds_package=libfastrtps-dev ;; # 2.9
  debian-13) dds_package=libfastdds-dev ;;  # 3.1
  *)
    name=$(system PRETTY_NAME)
    fail "only Debian 12 and 13 are supported, and this is ${name:-a system without a name}. Elsewhere install" \
      "Fast DDS 2.9 or 3.1, g++ 12 or later, CMake 3.25 or later and the libraries of docs/architecture.md," \
      "then run deploy/build.sh"
    ;;
esac

packages=(
  build-essential
  ccache
  cmake
  help2man
  libboost-dev # Beast: the web servers of the metrics and the gateway; Asio: the CANopen servers
  libcli11-dev
  libedit-dev # line editing in `vdrive shell`
  libeigen3-dev
  "$dds_package"
  file # CPack uses it to find the files that need libraries
  libseccomp-dev # restricts the system calls of engine and wire
  libspdlog-dev
  libssl-dev # checks of the security material; Fast DDS depends on it, too, as on libtinyxml2-dev
  libsystemd-dev
  libtinyxml2-dev
  libyaml-cpp-dev
  libzstd-dev # chunks of recordings
  ninja-build
  nlohmann-json3-dev
  pkg-config
  prometheus-cpp-dev # text of the metrics
  python3 # generates the messages from the IDL
  zlib1g-dev # checksums of recordings
)
test_packages=(
  bubblewrap # the sandbox of the systemd unit
  clang
  clang-format
  clang-tidy
  cyclonedds-dev # DDS of a second vendor
  cyclonedds-tools
  debootstrap # clean root file systems for the packages, also of the other Debian
  faketime # sets the clock ahead, for certificates that expire
  fastddsgen # the code that Fast DDS generates from our IDL; brings a Java runtime, through antlr4
  fastdds-tools # the discovery server of the network tests
  fish # completion of the tool
  gnupg # signs a repository of the packages
  iproute2 # hosts of the network tests
  libbenchmark-dev
  libclang-rt-dev # sanitizers and fuzzers with clang
  libgmock-dev
  libgtest-dev
  libfastcdr-dev # the encoder of Fast DDS, with which ours is compared
  librapidcheck-dev
  lld # links tests in a third of the time
  llvm # coverage of core/
  man-db
  mypy # the types of the Python module
  nftables # loss and blocked multicast in the network tests
  openssl # makes the material of the closed mode
  python3-can # a third-party client of the CAN bus
  python3-matplotlib # a plot in the documents
  python3-pip # the wheel
  python3-pytest
  python3-pytest-xdist # parallel tests
  python3-websockets # a third-party client of the gateway
  python3-yaml # manifests of Kubernetes
  python3-seccomp # the sandbox of the systemd unit
  systemd # systemd-analyze
  util-linux # chrt and setarch
  zsh # completion of the tool
)

python_packages=(
  pybind11-dev
  python3-dev
  python3-numpy
)

judge_packages=(
  tshark # decodes captures of the CAN bus
)

image_packages=(
  podman
  runc # unlike crun, also runs with cgroups v1
  aardvark-dns # names of containers in a network
  catatonit # the first process of a pod
  iptables # ports that a container publishes
  netavark # networks of containers
)

browser_packages=(
  chromium
  fonts-wqy-microhei # Chinese characters
  pngquant # pictures in the documents
)

while (($#)); do
  case $1 in
    --tests) packages+=("${test_packages[@]}" "${python_packages[@]}") ;;
    --page)
      # Many machines have a newer node than Debian, whose npm brings 350 packages.
      command -v node >/dev/null || packages+=(nodejs)
      command -v npm >/dev/null || packages+=(npm)
      ;;
    --python) packages+=("${python_packages[@]}") ;;
    --browser) packages+=("${browser_packages[@]}") ;;
    --judges)
      packages+=("${judge_packages[@]}")
      # The packages of Kubernetes itself use a different name.
      command -v kubectl >/dev/null || packages+=(kubernetes-client)
      ;;
    --images) packages+=("${image_packages[@]}") ;;
    *) fail "unknown option '$1'; usage: deploy/setup.sh [--tests] [--page] [--python] [--browser] [--judges] [--images]" ;;
  esac
  shift
done

is_installed() {
  [[ $(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null) == installed ]]
}

missing=()
for package in "${packages[@]}"; do
  is_installed "$package" || missing+=("$package")
done
((${#missing[@]})) || exit 0

if ((EUID != 0)) && ! command -v sudo >/dev/null; then
  fail "run as root, or install sudo; missing: ${missing[*]}"
fi
# shellcheck source=deploy/apt.sh
source "$(dirname "${BASH_SOURCE[0]}")/apt.sh"

echo "setup: installing ${missing[*]}" >&2
# On a new machine the package lists are empty; on an old one they name packages that no longer
# exist.
apt update || fail "apt-get update failed; missing: ${missing[*]}"
apt install --yes --no-install-recommends "${missing[@]}" ||
  fail "apt-get install failed on $(system PRETTY_NAME); missing: ${missing[*]}"
