#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The page of the gateway in a real browser (Debian's chromium): builds its
# dependencies, then runs page_test.mjs or creates the pictures for the documents.
#
#   tests/browser/run.sh [--no-build] [--pictures | --frames | --load]
#
#   --no-build   uses the programs in build/release/bin as they are
#   --pictures   creates docs/images/page_*.png instead of testing
#   --frames     measures the frames per second of the overview with 1,024 axes instead of testing
#   --load       measures processor time and memory of gateway and page with 1,024 axes instead of
#                testing
#
# Exit code 0: all passed; 77: nothing was tested, because the npm registry cannot be reached.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
program=(--test page_test.mjs)
build=true

fail() {
  echo "browser: $*" >&2
  exit 1
}

while (($#)); do
  case $1 in
    --no-build) build=false ;;
    --pictures) program=(pictures.mjs) ;;
    --frames) program=(frames.mjs) ;;
    --load) program=(load.mjs) ;;
    *) fail "unknown option '$1'; usage: tests/browser/run.sh [--no-build] [--pictures | --frames | --load]" ;;
  esac
  shift
done

if $build; then
  "$root/deploy/setup.sh" --page --browser
  "$root/deploy/build.sh" --target vdrived --target vdrive-gateway
fi

# npm writes next to package.json, so a copy keeps the source tree clean.
work=$root/build/browser
mkdir -p "$work"
cp "$here"/*.mjs "$here"/package.json "$here"/package-lock.json "$here"/.npmrc "$work"
cd "$work"
if ! cmp -s package-lock.json node_modules/lock; then
  if ! npm ci --no-audit --no-fund --prefer-offline --fetch-retries=0 >npm.log 2>&1; then
    cat npm.log >&2
    echo "browser: npm ci failed, is the registry reachable?" >&2
    exit 77
  fi
  cp package-lock.json node_modules/lock
fi

# A domain that no other program uses now; the helper keeps it until this script ends.
coproc claim { python3 -B "$root/tests/support/test_domain.py"; }
read -r domain <&"${claim[0]}"

export VDRIVE_BIN=${VDRIVE_BIN:-$root/build/release/bin} VDRIVE_DOMAIN=$domain VDRIVE_ROOT=$root
node "${program[@]}"
