#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the benchmarks and runs them; prints one JSON line a figure on standard output:
#   {"figure":"axis_tick_ns","axes":1024,"value":...}
# Everything else goes to standard error. Arguments are passed on to the benchmark of the core.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
"$root/deploy/setup.sh" --tests
"$root/deploy/build.sh" --tests -D VDRIVE_BUILD_BENCHMARKS=ON --target vdrive_core_benchmark \
  --target vdrive_service_benchmark --target vdrive_parameter_benchmark

# A virtual processor that falls asleep wakes up late and slow. One spinner each keeps it awake; at
# idle priority it gives way to the benchmark at once.
spinners=()
stop_spinners() {
  if ((${#spinners[@]})); then
    kill "${spinners[@]}" 2>/dev/null || true
  fi
}
trap stop_spinners EXIT
if command -v chrt >/dev/null && chrt -i 0 true 2>/dev/null; then
  for ((i = 0; i < $(nproc); ++i)); do
    chrt -i 0 sh -c 'while :; do :; done' &
    spinners+=($!)
  done
fi

{
  "$root/build/release/tests/benchmark/vdrive_core_benchmark" "$@"
  "$root/build/release/tests/benchmark/vdrive_service_benchmark"
  "$root/build/release/tests/benchmark/vdrive_parameter_benchmark" "$root/build"
} |
  awk '/^\{"figure"/ { print; fflush(); next } { print > "/dev/stderr" }'
