#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the tests of core/ in the preset asan, where the core counts the code that they reach, and
# fails below the project's promise: 90 % of the lines and 80 % of the branches of core/, and every
# branch of the power state machine.
#
#   tests/coverage/run.sh
#
# Prints a row for each file; build/asan/coverage/report/index.html shows the uncovered lines. A
# branch is one outcome of a condition in the source, true or false, or one case of a switch. A
# constant condition has none.
# Exit code 0: promise kept; 1: below it, a test failed, or nothing could be measured; 77:
# tests/run.sh had no time for this preset.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/asan
counts=$build/coverage
least_lines=90
least_branches=80
state_machine=core/src/cia402/power_state_machine.cpp

fail() {
  echo "coverage: $*" >&2
  exit 1
}

command -v llvm-cov >/dev/null || fail "no llvm-cov; run deploy/setup.sh --tests first"
"$root/tests/checks/build_preset.sh" asan core_tests

cd "$root"
rm -rf "$counts"
mkdir -p "$counts"
unset VDRIVE_FULL VDRIVE_NIGHTLY # the promise applies to an ordinary run
LLVM_PROFILE_FILE=$counts/%p.profraw chrt --idle 0 ctest --preset asan --tests-regex '^core_' >&2 ||
  fail "a test of core/ failed"

llvm-profdata merge --sparse --output "$counts/core.profdata" "$counts"/*.profraw
rm "$counts"/*.profraw
mapfile -t programs <"$build/core_tests.txt"
measured=(--instr-profile "$counts/core.profdata" "${programs[0]}" "${programs[@]/#/--object=}" core)
llvm-cov show --format html --output-dir "$counts/report" "${measured[@]}"
llvm-cov report "${measured[@]}" >"$counts/report.txt"

# A file that llvm-cov lists outside core/ would not be counted.
while read -r source; do
  grep --quiet "^[^ ]*${source#core/src/} " "$counts/report.txt" || fail "$source was not measured"
done < <(find core/src -name '*.cpp')

# Columns: file, then the total and missed regions, functions, lines and branches, each with a
# percentage.
awk -v least_lines=$least_lines -v least_branches=$least_branches -v state_machine=$state_machine '
  function percent(all, missed) { return all == 0 ? 100 : 100 * (all - missed) / all }
  function row(name, lines, missed_lines, branches, missed_branches) {
    printf "%-52s %5d %6.1f %%  %5d %6.1f %%\n", name, lines, percent(lines, missed_lines),
           branches, percent(branches, missed_branches)
  }
  function complain(text) { print "coverage: " text > "/dev/stderr"; bad = 1 }
  BEGIN { printf "%-52s %5s %8s  %5s %8s\n", "", "lines", "covered", "branches", "covered" }
  NF == 13 && $2 ~ /^[0-9]+$/ {
    row($1, $8, $9, $11, $12)
    if ($1 == "TOTAL") {
      lines = $8; branches = $11
      covered_lines = percent($8, $9); covered_branches = percent($11, $12)
    }
    # The header has no branches today; any that is added counts.
    if ($1 ~ /cia402\/power_state_machine\.[ch]pp$/) {
      machine_branches += $11; missed_machine_branches += $12
    }
  }
  END {
    if (lines == 0 || branches == 0 || machine_branches == 0) complain("nothing was measured")
    if (covered_lines < least_lines) complain("less than " least_lines " % of the lines of core/")
    if (covered_branches < least_branches)
      complain("less than " least_branches " % of the branches of core/")
    if (missed_machine_branches > 0)
      complain(missed_machine_branches " branches of " state_machine " are not covered; all must be")
    exit bad
  }' "$counts/report.txt"
