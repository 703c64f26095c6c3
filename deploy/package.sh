#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the Debian packages vdrived, vdrive, vdrive-gateway, vdrive-ros2, vdrive-canopen,
# libvdrive-dev, python3-vdrive and vdrive-doc into build/packages, for the Debian on which it runs,
# and next to them a list of their contents (SPDX 2.3): vdrive_VERSION_ARCHITECTURE.spdx.json.
#
#   deploy/package.sh
#
# Uses the release build. Run deploy/setup.sh --page --python first. Prints the names of the
# packages. The same commit gives the same bytes in any folder, on a system with the same packages.
# Their date is SOURCE_DATE_EPOCH, otherwise the date of the commit, otherwise the date of
# CHANGELOG.md.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
packages=$root/build/packages

fail() {
  echo "package: $*" >&2
  exit 1
}

if [[ -z ${SOURCE_DATE_EPOCH:-} ]]; then
  SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct 2>/dev/null || stat -c %Y "$root/CHANGELOG.md")
fi
export SOURCE_DATE_EPOCH
umask 022 # the packages record the modes of folders

"$root/deploy/build.sh"
rm -rf "$packages"
if ! output=$(cd "$root/build/release" && cpack 2>&1); then
  printf '%s\n' "$output" >&2
  fail "cpack failed"
fi
rm -rf "$packages/_CPack_Packages"
/usr/bin/python3 -B "$root/deploy/list_contents.py" "$root/build/release" \
  "$root/clients/gateway/page/package-lock.json" "$packages"/*.deb || fail "listing the package contents failed"
ls "$packages"/*.deb
