#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and runs every test; ends with ctest's summary.
#
#   tests/run.sh [--nightly] [--quick] [ctest arguments...]
#
#   --nightly   the long counts of property, fuzz and soak tests (VDRIVE_NIGHTLY=1)
#   --quick     only the release build: no sanitizers, clang-tidy, format check, fuzzers, coverage
#
# The other presets are tests too (label checks), so the summary speaks for all of them. What was
# built and linted once is not done again. Exit code 0: all tests passed.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
quick=false
ctest_arguments=()
while (($#)); do
  case $1 in
    --nightly)
      export VDRIVE_NIGHTLY=1
      ctest_arguments+=(--timeout 7200)
      ;;
    --quick) quick=true ;;
    *) ctest_arguments+=("$1") ;;
  esac
  shift
done

"$root/deploy/setup.sh" --tests

check_presets=ON
if $quick; then
  check_presets=OFF
fi
"$root/deploy/build.sh" --tests -D VDRIVE_CHECK_PRESETS=$check_presets

if ! $quick; then
  # Here the progress is seen; a failure is reported by the test of that preset.
  for preset in asan tsan tidy fuzz coverage; do
    "$root/tests/checks/build_preset.sh" $preset >&2 || true
  done
fi

cd "$root"
exec ctest --preset release "${ctest_arguments[@]}"
