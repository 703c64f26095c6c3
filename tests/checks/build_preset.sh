#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds one of the checking presets: build_preset.sh asan|tsan|tidy|fuzz [TARGET]
# TARGET: only this one, instead of all that the check needs. For tidy the build is the check: lint.sh
# reads what linted.txt does not have. tsan builds the benchmarks, too: that shows that they compile, in
# 60 % of the time of the preset release, in which they measure. Exit code 77: tests/run.sh found no time for
# this preset.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
preset=$1

if [[ " ${VDRIVE_SKIPPED:-} " == *" $preset "* ]]; then
  echo "build_preset: $preset is skipped by tests/run.sh" >&2
  exit 77
fi

case $preset in
  tidy) options=(--keep-going --target "${2:-lint}") ;;
  fuzz) options=(--target "${2:-fuzzers}") ;;
  asan)
    options=(-D VDRIVE_BUILD_TESTS=ON --target "${2:-unit_tests}")
    [[ -n ${2:-} ]] || options+=(--target fuzzers --target all_verify_interface_header_sets) ;;
  tsan)
    options=(-D VDRIVE_BUILD_TESTS=ON -D VDRIVE_BUILD_BENCHMARKS=ON --target "${2:-unit_tests}")
    [[ -n ${2:-} ]] || options+=(--target benchmarks) ;;
  *) echo "build_preset: unknown preset '$preset'" >&2 && exit 2 ;;
esac
# clang-tidy counts the warnings that it does not show, even with --quiet.
"$root/deploy/build.sh" --preset "$preset" "${options[@]}" 2>&1 |
  sed --unbuffered --regexp-extended '/^[0-9]+ warnings? generated\.$/d'
