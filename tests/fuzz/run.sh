#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the fuzzers and runs each over its kept corpus and its seed files from the tree, then over
# new inputs, one fuzzer per processor at a time.
#
#   tests/fuzz/run.sh [--seconds N] [--kept] [--keep] [fuzzer...]
#
#   --seconds N   how long each fuzzer searches for new inputs, default 6; 300 with VDRIVE_NIGHTLY=1
#   --kept        run only the kept inputs, in the preset asan, which cannot guide a search; with
#                 VDRIVE_NIGHTLY=1 search for new ones all the same
#   --keep        rebuild the kept corpus, tests/fuzz/corpus: the smallest set of the inputs found
#                 so far that reaches all the code that any of them reaches, and the files named
#                 fixed-...: inputs that once failed
#
# A failing input is stored in build/fuzz/failures and named. Exit code 0: none was found.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$root/tests/fuzz
work=$root/build/fuzz
# Inputs stay small, so that each runs in milliseconds and the kept corpus takes kilobytes.
declare -A max_length=(
  [core_fuzz]=512 [message_fuzz]=1024 [datagram_fuzz]=2048 [configuration_fuzz]=2048
  [scenario_fuzz]=1024 [gateway_fuzz]=1024 [recording_fuzz]=4096
  [ros_fuzz]=1024 [socketcand_fuzz]=512 [canopen_gateway_fuzz]=512 [canopen_frame_fuzz]=1024)

seconds=6
[[ ${VDRIVE_NIGHTLY:-} == 1 ]] && seconds=300
keep=false
kept_only=false
preset=fuzz
fuzzers=()

fail() {
  echo "run.sh: $*" >&2
  exit 2
}

searches=false
while (($#)); do
  case $1 in
    --seconds)
      searches=true
      (($# >= 2)) && [[ $2 =~ ^[1-9][0-9]*$ ]] || fail "--seconds needs a whole number above 0"
      seconds=$2 && shift ;;
    --kept)
      [[ ${VDRIVE_NIGHTLY:-} == 1 ]] || kept_only=true ;;
    --keep) searches=true && keep=true ;;
    *)
      [[ -n ${max_length[$1]:-} ]] || fail "'$1' is none of ${!max_length[*]}"
      fuzzers+=("$1") ;;
  esac
  shift
done
if $kept_only && $searches; then
  fail "--kept searches for no inputs: --seconds and --keep have no meaning with it"
fi
((${#fuzzers[@]})) || fuzzers=(core_fuzz message_fuzz datagram_fuzz configuration_fuzz
  scenario_fuzz gateway_fuzz recording_fuzz ros_fuzz socketcand_fuzz canopen_gateway_fuzz
  canopen_frame_fuzz)

# The files of the tree that a fuzzer starts from.
seed() {
  case $1 in
    configuration_fuzz)
      find "$root/deploy" -name '*.yaml' -exec cp --backup=numbered -t "$2" {} +
      # The example in the documentation names every key.
      sed -n '/^```yaml$/,/^```$/{/^```/d;p}' "$root/docs/guides/configuration.md" >"$2/documentation.yaml" ;;
    scenario_fuzz)
      # A few lines each: a complete scenario is longer than an input.
      cat "$root"/clients/scenarios/*.scn | sed 's/ *#.*//' | sort -u | sed '/^$/d' |
        split --lines 8 - "$2/lines-" ;;
  esac
}

# Prints the result; if something was found, the end of the output.
run() {
  local program=$1 log=$work/$1.log
  shift
  if ! "$root/build/$preset/fuzz/$program" "$@" >"$log" 2>&1; then
    tail --lines 100 "$log" >&2
    echo "$program found a failing input; its path is in the last lines" >&2
    exit 1
  fi
  echo "$program: $(grep --extended-regexp '^(Done|#[0-9]+.DONE)' "$log" | tail --lines 1)"
}

if $kept_only; then
  preset=asan
fi
"$root/tests/checks/build_preset.sh" $preset fuzzers

search() {
  local fuzzer=$1
  local kept=$here/corpus/$fuzzer found=$work/corpus/$fuzzer seeds=$work/seeds/$fuzzer
  local fresh=$work/merged/$fuzzer
  rm -rf "$seeds"
  mkdir -p "$kept" "$found" "$seeds"
  seed "$fuzzer" "$seeds"
  local options=(-max_len="${max_length[$fuzzer]}" -len_control=10 -timeout=20 -verbosity=1
    -print_funcs=0 -artifact_prefix="$work/failures/$fuzzer-")
  [[ -f $here/dictionary/$fuzzer.dict ]] && options+=(-dict="$here/dictionary/$fuzzer.dict")
  echo "$fuzzer: $(find "$kept" -type f | wc -l) kept inputs"
  # All kept inputs first, without a time limit; then, without --kept, new ones for the given time.
  run "$fuzzer" "${options[@]}" -runs=0 "$kept" "$seeds"
  $kept_only && return
  run "$fuzzer" "${options[@]}" -max_total_time="$seconds" "$found" "$kept" "$seeds"
  if $keep; then
    rm -rf "$fresh"
    mkdir -p "$fresh"
    # The merge counts which code is reached, not how often: a hundred files instead of five
    # hundred.
    run "$fuzzer" "${options[@]}" -use_counters=0 -merge=1 "$fresh" "$kept" "$seeds" "$found"
    find "$kept" -type f -name 'fixed-*' -exec cp -t "$fresh" {} +
    rm -rf "$kept"
    mv "$fresh" "$kept"
  fi
}

mkdir -p "$work/failures"
waiting=("${fuzzers[@]}")
running=0
failed=0
while ((${#waiting[@]} + running)); do
  if ((${#waiting[@]} && running < $(nproc))); then
    search "${waiting[0]}" &
    waiting=("${waiting[@]:1}")
    running=$((running + 1))
  else
    wait -n || failed=1
    running=$((running - 1))
  fi
done
((failed == 0)) || exit 1
echo "no failing input"
