#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Configures and builds vdrive; finished steps are not repeated.
#
#   deploy/build.sh [--preset NAME] [--tests] [--target TARGET]... [-D VAR=VALUE]... [--keep-going]
#
#   --preset NAME     a preset of CMakePresets.json, default release
#   --tests           also build the tests (they then stay enabled in that build directory);
#                     -D VDRIVE_BUILD_BENCHMARKS=ON builds the benchmarks
#   --target TARGET   build only this target instead of all; may be repeated
#   -D VAR=VALUE      passed to CMake; may be repeated
#   --keep-going      after a failure, build everything that still can be built
#
# The programs are then build/NAME/bin/vdrived and build/NAME/bin/vdrive. Writes to standard error
# only: progress on a terminal, otherwise one line and the errors. Run deploy/setup.sh first.
# JOBS in the environment limits the number of parallel jobs (default: one per processor).
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
preset=release
tests=false
targets=()
definitions=()
ninja_options=()

fail() {
  echo "build: $*" >&2
  exit 1
}

while (($#)); do
  case $1 in
    --preset | --target | -D) (($# >= 2)) || fail "$1 needs a value" ;;&
    --preset) preset=$2 && shift ;;
    --target) targets+=(--target "$2") && shift ;;
    -D) definitions+=(-D "$2") && shift ;;
    --tests) tests=true ;;
    --keep-going) ninja_options+=(-k 0) ;;
    *) fail "unknown option '$1'" ;;
  esac
  shift
done

directory=$root/build/$preset
mkdir -p "$directory"

# The cache needs a writable home directory, which a service account may not have.
if [[ -z ${CCACHE_DIR:-} && ! -w ${HOME:-/nonexistent} ]]; then
  export CCACHE_DIR=$root/build/ccache
fi

defaults=()
if $tests; then
  defaults=(-D VDRIVE_BUILD_TESTS=ON)
elif [[ ! -f $directory/CMakeCache.txt ]]; then
  # Users need no test libraries. An existing choice is kept, because switching tests off would only
  # discard the test programs.
  defaults=(-D VDRIVE_BUILD_TESTS=OFF -D VDRIVE_BUILD_BENCHMARKS=OFF)
fi

cd "$root"
log=$directory/configure.log
if ! cmake --preset "$preset" "${defaults[@]}" "${definitions[@]}" >"$log" 2>&1; then
  cat "$log" >&2
  fail "cmake --preset $preset failed"
fi

plan=$(cmake --build "$directory" "${targets[@]}" -- -n 2>&1 | tail -n 1) || true
if [[ $plan == *"no work to do"* ]]; then
  exit 0
fi
if [[ ! -t 2 ]]; then
  echo "build: $preset" >&2
  ninja_options+=(--quiet)
fi
cmake --build "$directory" --parallel "${JOBS:-$(nproc)}" "${targets[@]}" \
  -- "${ninja_options[@]}" >&2 ||
  fail "the $preset build failed"
