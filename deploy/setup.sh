#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the packages of Debian 12 or 13 that building and running vdrive needs.
#
#   deploy/setup.sh [--tests] [--page] [--python] [--browser] [--judges] [--images]
#
#   --tests     also what the tests, the benchmarks and the lint need
#   --page      also node and npm, where these programs are missing: they build the page of the gateway
#   --python    also what the Python module is built from; --tests brings it, too
#   --browser   also the browser that tests this page
#   --judges    also programs of others that judge what bridges send
#   --images    also what runs images of containers
#
# Installs only what is missing, by apt, through sudo unless run as root. Prints nothing when
# nothing is missing. Writes to standard error only. Exit code 0: all packages are installed.
set -euo pipefail

fail() {
  echo "setup: $*" >&2
  exit 1
}

# A variable of os-release(5); nothing where it is not set.
system() {
  # shellcheck disable=SC1091
  (. /etc/os-release && printf '%s' "${!1:-}") 2>/dev/null || true
}

# Both releases have all packages below under the same names, but for the DDS library.
case $(system ID)-$(system VERSION_ID) in
  debian-12) dds_package=libfastrtps-dev ;; # 2.9
  debian-13) dds_package=libfastdds-dev ;;  # 3.1
  *)
    name=$(system PRETTY_NAME)
    fail "this is ${name:-a system without a name}; installs packages on Debian 12 and 13 only. Elsewhere install" \
      "Fast DDS 2.9 or 3.1, g++ 12 or later, CMake 3.25 or later and the libraries of docs/architecture.md," \
      "then run deploy/build.sh"
    ;;
esac

packages=(
  build-essential
  ccache
  cmake
  help2man
  libboost-dev # Beast, the web servers of the metrics and of the gateway; Asio, the servers of CANopen
  libcli11-dev
  libedit-dev # lines of the shell of the tool
  libeigen3-dev
  "$dds_package"
  file # CPack asks it which files of a package need libraries
  libseccomp-dev # what each half of the service may ask of the kernel
  libspdlog-dev
  libssl-dev # checks of the security material; Fast DDS brings it too, like libtinyxml2-dev
  libsystemd-dev
  libtinyxml2-dev
  libyaml-cpp-dev
  libzstd-dev # chunks of recordings
  ninja-build
  nlohmann-json3-dev
  pkg-config
  prometheus-cpp-dev # text of the metrics
  python3 # makes the messages of the IDL
  zlib1g-dev # check sums of recordings
)
test_packages=(
  bubblewrap # the sandbox of the systemd unit
  clang
  clang-format
  clang-tidy
  cyclonedds-dev # a second vendor's DDS
  cyclonedds-tools
  debootstrap # clean roots: for the packages, and of the other Debian
  faketime # a clock that is ahead, for certificates that expire
  fastddsgen # what Fast DDS makes of our IDL; brings a Java runtime, through antlr4
  fastdds-tools # the discovery server of the network tests
  fish # completion of the tool
  gnupg # signs a repository of the packages
  iproute2 # hosts of the network tests
  libbenchmark-dev
  libclang-rt-dev # sanitizers and fuzzers with clang
  libgmock-dev
  libgtest-dev
  libfastcdr-dev # the encoder of Fast DDS, which ours is compared with
  librapidcheck-dev
  lld # links tests in a third of the time
  llvm # coverage of core/
  man-db
  mypy # the types of the Python module
  nftables # loss and blocked multicast in the network tests
  openssl # makes the material of the closed mode
  python3-can # a client of the CAN bus that others wrote
  python3-matplotlib # a plot of the documents
  python3-pip # the wheel
  python3-pytest
  python3-pytest-xdist # tests side by side
  python3-websockets # a client of the gateway that others wrote
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
  runc # runs also where control groups are of the first version, unlike crun
  aardvark-dns # names of containers in a network
  catatonit # the first process of a pod
  iptables # ports that a container publishes
  netavark # networks of containers
)

browser_packages=(
  chromium
  fonts-wqy-microhei # Chinese characters
  pngquant # pictures of the documents
)

while (($#)); do
  case $1 in
    --tests) packages+=("${test_packages[@]}" "${python_packages[@]}") ;;
    --page)
      # Many machines have a newer node than Debian's; npm is 350 packages there.
      command -v node >/dev/null || packages+=(nodejs)
      command -v npm >/dev/null || packages+=(npm)
      ;;
    --python) packages+=("${python_packages[@]}") ;;
    --browser) packages+=("${browser_packages[@]}") ;;
    --judges)
      packages+=("${judge_packages[@]}")
      # Kubernetes' own packages have it under another name.
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
# The package lists of a new machine are empty; those of an old one name packages that no longer
# exist.
apt update || fail "apt-get update failed; missing: ${missing[*]}"
apt install --yes --no-install-recommends "${missing[@]}" ||
  fail "apt-get install failed on $(system PRETTY_NAME); missing: ${missing[*]}"
