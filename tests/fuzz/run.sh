#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the fuzzers and runs each over its kept corpus and then over new inputs.
#
#   tests/fuzz/run.sh [--seconds N] [--keep] [fuzzer...]
#
#   --seconds N   how long each fuzzer looks for new inputs, default 10
#   --keep        add inputs that reach new code to the kept corpus, minimised
#
# A failing input is left in build/fuzz/failures and named. Exit code 0: none was found.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
seconds=10
keep=false
fuzzers=()
while (($#)); do
  case $1 in
    --seconds) (($# >= 2)) || { echo "run.sh: --seconds needs a value" >&2; exit 2; }
      seconds=$2 && shift ;;
    --keep) keep=true ;;
    *) fuzzers+=("$1") ;;
  esac
  shift
done
((${#fuzzers[@]})) || fuzzers=(core_fuzz message_fuzz configuration_fuzz scenario_fuzz)

"$root/deploy/build.sh" --preset fuzz --target fuzzers

work=$root/build/fuzz
mkdir -p "$work/failures"
for fuzzer in "${fuzzers[@]}"; do
  corpus=$root/tests/fuzz/corpus/$fuzzer
  found=$work/corpus/$fuzzer
  mkdir -p "$corpus" "$found"
  echo "$fuzzer: $(find "$corpus" -type f | wc -l) kept inputs, then $seconds s"
  "$work/fuzz/$fuzzer" -max_total_time="$seconds" -timeout=20 -max_len=4096 -verbosity=0 \
    -print_final_stats=0 -artifact_prefix="$work/failures/$fuzzer-" "$found" "$corpus"
  if $keep; then
    "$work/fuzz/$fuzzer" -merge=1 -max_len=4096 -verbosity=0 "$corpus" "$found"
  fi
done
echo "no failing input"
