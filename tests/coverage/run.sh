#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures how much of core/ its own tests reach, and fails below the promise of the project:
# 90 % of the lines and 80 % of the branches of core/, every branch of the power state machine.
#
#   tests/coverage/run.sh
#
# Prints a row for each file; build/coverage/report/index.html has the uncovered lines.
# Exit code 0: promise kept; 1: below it, a test failed, or nothing could be measured.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/coverage
jobs=${JOBS:-$(nproc)}
least_lines=90
least_branches=80
state_machine=core/src/cia402/power_state_machine.cpp

fail() {
  echo "coverage: $*" >&2
  exit 1
}

command -v gcovr >/dev/null || fail "no gcovr; run deploy/setup.sh --tests first"
# Counters add up over runs, those of listing the tests while building included: only the run below
# counts.
forget() {
  find "$build" -name '*.gcda' -delete
}
mkdir -p "$build/logs" "$build/report"
forget
"$root/tests/checks/build_preset.sh" coverage

forget
unset VDRIVE_FULL VDRIVE_NIGHTLY # the promise holds for the counts of a person's run
run_test() {
  local log=$1/logs/$(basename "$2").log
  "$2" >"$log" 2>&1 || {
    tail --lines 40 "$log" >&2
    return 1
  }
}
export -f run_test
xargs --max-args=1 --max-procs="$jobs" bash -c 'run_test "$0" "$1"' "$build" \
  <"$build/core_tests.txt" || fail "a test of core/ failed"

# Branches that the compiler adds are not counted: the branches into exception handling behind each call,
# and those that the code generator itself cannot reach.
cd "$root"
gcovr --root . --filter core/ --exclude-throw-branches --exclude-unreachable-branches \
  --json "$build/report/coverage.json" "$build/core"
gcovr --root . --add-tracefile "$build/report/coverage.json" --csv "$build/report/coverage.csv" \
  --html-details "$build/report/index.html"

# Columns: filename, line_total, line_covered, line_percent, branch_total, branch_covered, ...
awk -F , -v least_lines=$least_lines -v least_branches=$least_branches \
  -v state_machine=$state_machine '
  function percent(covered, total) { return total == 0 ? 100 : 100 * covered / total }
  function row(name, lines, covered_lines, branches, covered_branches) {
    printf "%-52s %5d %6.1f %%  %5d %6.1f %%\n", name, lines, percent(covered_lines, lines),
           branches, percent(covered_branches, branches)
  }
  function complain(text) { print "coverage: " text > "/dev/stderr"; bad = 1 }
  BEGIN { printf "%-52s %5s %8s  %5s %8s\n", "", "lines", "covered", "branches", "covered" }
  NR > 1 {
    row($1, $2, $3, $5, $6)
    lines += $2; covered_lines += $3; branches += $5; covered_branches += $6
    # The header holds no branches today; one that is added counts.
    if ($1 ~ /cia402\/power_state_machine\.[ch]pp$/) {
      machine_branches += $5; covered_machine_branches += $6
    }
  }
  END {
    row("core/", lines, covered_lines, branches, covered_branches)
    if (lines == 0 || branches == 0 || machine_branches == 0) complain("nothing was measured")
    if (percent(covered_lines, lines) < least_lines)
      complain("less than " least_lines " % of the lines of core/")
    if (percent(covered_branches, branches) < least_branches)
      complain("less than " least_branches " % of the branches of core/")
    if (covered_machine_branches < machine_branches)
      complain(machine_branches - covered_machine_branches " branches of " state_machine \
               " are not covered; all must be")
    exit bad
  }' "$build/report/coverage.csv"
