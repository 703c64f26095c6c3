#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds a checking preset and runs its unit tests: check_preset.sh asan|tsan|tidy
# tests/coverage/run.sh runs those of the core under asan and measures their coverage.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
preset=$1

"$root/tests/checks/build_preset.sh" "$preset"
if [[ $preset != tidy ]]; then
  cd "$root"
  # The instrumented code is ten times slower, so use the counts of a manual run.
  unset VDRIVE_FULL VDRIVE_NIGHTLY
  left_out=()
  [[ $preset == asan ]] && left_out=(--exclude-regex '^core_')
  # At idle priority, see tests/checks/CMakeLists.txt.
  chrt --idle 0 ctest --preset "$preset" --label-regex '^unit$' "${left_out[@]}"
fi
