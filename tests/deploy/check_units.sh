#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Checks that systemd accepts the units, and that their exposure stays below the promised values:
# 1.5 of systemd-analyze's 10 points, 1.9 with the drop-in for real time.
#
#   tests/deploy/check_units.sh
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "check_units: $*" >&2
  exit 1
}

# --threshold is in tenths of a point.
check_exposure() {
  local unit=$1 threshold=$2 output
  if ! output=$(systemd-analyze security --offline=true --threshold="$threshold" "$unit" 2>&1); then
    grep -e '✗' -e '→' <<<"$output" >&2
    fail "$unit is more exposed than 0.1 x $threshold"
  fi
  tail -n 1 <<<"$output"
}

cp "$root/deploy/systemd/vdrived.service" "$work/"
check_exposure "$work/vdrived.service" 15

for bridge in gateway ros2 canopen; do
  cp "$root/deploy/systemd/vdrive-$bridge.service" "$work/"
  check_exposure "$work/vdrive-$bridge.service" 15
done

mkdir "$work/vdrived.service.d"
cp "$root/deploy/systemd/realtime.conf" "$work/vdrived.service.d/"
check_exposure "$work/vdrived.service" 19

# The program is not installed here; everything else must be correct.
for unit in vdrived.service vdrive-gateway.service vdrive-ros2.service vdrive-canopen.service; do
  sed -i 's|^ExecStart=.*|ExecStart=/bin/true|; /^Documentation=/d' "$work/$unit"
  output=$(systemd-analyze verify --man=no "$work/$unit" 2>&1) || true
  if [[ -n $output ]]; then
    fail "$output"
  fi
done
