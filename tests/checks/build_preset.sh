#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds one of the checking presets: build_preset.sh asan|tsan|tidy|fuzz [TARGET]
# TARGET: only this one, instead of everything that the check needs. For tidy the build is the
# check: lint.sh checks the files that are not in linted.txt. tsan also builds the benchmarks, to
# show that they compile: this takes 60 % of the time that it takes in the preset release, which is
# used to measure. Exit code 77: tests/run.sh had no time for this preset.
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
# clang-tidy reports the number of suppressed warnings, even with --quiet.
"$root/deploy/build.sh" --preset "$preset" "${options[@]}" 2>&1 |
  sed --unbuffered --regexp-extended '/^[0-9]+ warnings? generated\.$/d'
