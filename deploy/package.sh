#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the Debian packages vdrived, vdrive, vdrive-gateway, vdrive-ros2, vdrive-canopen,
# libvdrive-dev, python3-vdrive and vdrive-doc into build/packages.
#
#   deploy/package.sh
#
# From the release build. Needs deploy/setup.sh --page --python first. Prints the names of the packages.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/deploy/build.sh"
rm -rf "$root/build/packages"
if ! output=$(cd "$root/build/release" && cpack 2>&1); then
  printf '%s\n' "$output" >&2
  echo "package: cpack failed" >&2
  exit 1
fi
rm -rf "$root/build/packages/_CPack_Packages"
ls "$root"/build/packages/*.deb
