#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Compares this tree with a commit: builds both, runs them in turn, and prints a table with both
# medians, their ratio, and the smallest and largest ratio of a pair.
#
#   ./tests/benchmark/compare.sh COMMIT [--pairs N]
#                                [--only core|freerun|step|frame|publish|process|follow]
#
# N is 7 by default. The commit is built in build/compare/HASH, which is kept for the next run. Each
# figure is measured in the old tree and immediately afterwards in the new one, so the ratio of such
# a pair is valid even on a busy machine. For steps, frames and publication over DDS, the
# measuring programs of this tree run with the service of either tree. For process (a bench in the
# caller's process) and follow (start, and a client that follows 1,000 axes), program and service are
# of the same tree.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/tests/benchmark/spinners.sh"
pairs=7
only=
commit=

fail() {
  echo "compare: $*" >&2
  exit 2
}

while (($#)); do
  case $1 in
    --pairs | --only) (($# >= 2)) || fail "$1 needs a value" ;;&
    --pairs) pairs=$2 && shift ;;
    --only) only=$2 && shift ;;
    -*) fail "unknown option '$1'" ;;
    *) commit=$1 ;;
  esac
  shift
done
[[ -n $commit ]] || fail "name the commit to compare with"
[[ $pairs =~ ^[1-9][0-9]*$ ]] || fail "--pairs $pairs is not a number from 1 on"
[[ -z $only || $only =~ ^(core|freerun|step|frame|publish|process|follow)$ ]] || fail "--only $only is no part"
hash=$(git -C "$root" rev-parse --short=12 --verify --quiet "$commit^{commit}") ||
  fail "'$commit' is not a commit of this repository"

old=$root/build/compare/$hash
if [[ ! -e $old/deploy/build.sh ]]; then
  mkdir -p "$old"
  git -C "$root" archive "$hash" | tar -x -C "$old"
fi
for tree in "$old" "$root"; do
  "$tree/deploy/build.sh" --tests -D VDRIVE_BUILD_BENCHMARKS=ON --target vdrived \
    --target vdrive_core_benchmark --target vdrive_service_benchmark \
    --target vdrive_wire_benchmark --target vdrive_local_benchmark --target vdrive_follow_benchmark
done

figures=$root/build/compare/figures-$hash.jsonl
: >"$figures"
keep_awake

# run_both PROGRAM: calls PROGRAM with the build directory of each tree.
run_both() {
  local tree build
  for tree in old new; do
    [[ $tree == old ]] && build=$old/build/release || build=$root/build/release
    "$1" "$build" 2>>"$figures.log" | sed -n "s/^{\"figure\"/{\"pair\":$pair,\"tree\":\"$tree\",\"figure\"/p" \
      >>"$figures" || echo "compare: $1 failed in the $tree tree, see $figures.log" >&2
  done
}

core() { "$1/tests/benchmark/vdrive_core_benchmark" --benchmark_min_time=0.05; }
freerun() { "$1/tests/benchmark/vdrive_service_benchmark"; }
wire() {
  local build=$1
  shift
  "$root/build/release/tests/benchmark/vdrive_wire_benchmark" "$build/bin/vdrived" "$@"
}
step() { wire "$1" step --clock lockstep --axes 64; }
frame() { wire "$1" command --axes 64; }
publish() { wire "$1" publish --axes 1024; }
process() { "$1/tests/benchmark/vdrive_local_benchmark" "$1/bin/vdrived" 3; }

# The processor time is that of service and client together.
follow() {
  local TIMEFORMAT='{"figure":"follow_user_s","axes":1000,"value":%U}'
  { time "$1/tests/benchmark/vdrive_follow_benchmark" "$1/bin/vdrived" 5 1 --moving --axes 1000; } 2>&1
}

for ((pair = 1; pair <= pairs; ++pair)); do
  echo "compare: pair $pair of $pairs" >&2
  for part in core freerun step frame publish process follow; do
    if [[ -z $only || $only == "$part" ]]; then
      run_both "$part"
    fi
  done
done
"$root/tests/benchmark/figures.py" pairs "$figures"
