#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Shows that vdrive works: installs what is missing, builds, and runs the tests.
#
#   tests/run.sh [--bridges] [--full] [--presets-until MINUTES] [--nightly] [--retry-deadlines]
#                [ctest arguments...]
#
# Without an option: drive, service, client library and tool with their unit tests, the chosen tests
# over DDS and every scenario, in 8 minutes on two cores from scratch. Only the core is optimised as in a
# release (preset quick). docs/explanation/testing.md says which tests are chosen.
#
#   --bridges   also the bridges (label bridge): Python module, gateway, ROS 2 and CANopen
#   --full      what continuous integration checks, in 35 to 40 minutes: all of it as users get it (preset
#               release), the bridges, all tests over DDS (other vendors, other hosts, attackers: label
#               full), the sanitizers, clang-tidy, the format, the fuzzers, the coverage, the packages,
#               the sandbox, the conformance documents (each test that they name ran and passed),
#               clients that come and go, benchmarks that still compile, the page of the gateway in a
#               browser; and the full counts of property tests and of the fuzzers that are tests
#               (VDRIVE_FULL=1)
#   --presets-until MINUTES
#               begins no build of a preset later than this after the start, and skips its test; likewise, after
#               the builds, the test of the wire on the other Debian. For runs that are ended from outside: a
#               slow machine then shows less rather than nothing
#   --nightly   --full with the long counts (VDRIVE_NIGHTLY=1), fuzzers that search for new inputs, and a build and
#               tests on the other Debian (tests/platform)
#   --retry-deadlines
#               runs a test once more, alone, when it promises something about wall time (label
#               timed) and failed by a deadline; never after a signal, a report of a sanitizer, an
#               exception or a wrong value (tests/checks/failures.py judges). For machines that
#               others use, too. Both results are in the last lines
#
# The steps and their times are written to standard error. The last lines are ctest's summary, where a suite
# of unit tests is one test, and the number of single tests. A preset is a test too (label checks), so that the
# summary covers all of them. What was built and linted once is not done again.
#
# A failed test is red: nothing is tried twice, except with --retry-deadlines. tests/repeat.sh
# shows how often a test fails, also on a loaded machine. Exit code 0: each test passed.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
full=false
bridges=false
retry=false
whole=true # no argument chooses tests
last_begin=
ctest_arguments=()
while (($#)); do
  case $1 in
    --full) full=true ;;
    --bridges) bridges=true ;;
    --retry-deadlines) retry=true ;;
    --presets-until)
      if (($# < 2)) || ! [[ $2 =~ ^[0-9]+$ ]]; then
        echo "run.sh: --presets-until needs a whole number of minutes" >&2
        exit 2
      fi
      last_begin=$((60 * $2)) && shift ;;
    --nightly)
      full=true
      export VDRIVE_NIGHTLY=1
      ctest_arguments+=(--timeout 7200)
      ;;
    *)
      whole=false
      ctest_arguments+=("$1")
      ;;
  esac
  shift
done

steps=3
preset=quick
presets=()
setup_options=(--tests)
options=(-D VDRIVE_CHECK_PRESETS=OFF --target chosen_tests)
labels='^(unit|dds)$'
if $full; then
  export VDRIVE_FULL=1
  preset=release
  setup_options+=(--page --browser --judges --images)
  presets=(asan tsan tidy) # what is skipped first comes last
  [[ ${VDRIVE_NIGHTLY:-} == 1 ]] && presets=(asan tsan fuzz tidy)
  steps=$((3 + ${#presets[@]}))
  options=(-D VDRIVE_CHECK_PRESETS=ON -D VDRIVE_TESTS_BY_CLANG=ON)
else
  left_out='^bridge$'
  if $bridges; then
    left_out='^full$' # the label of some tests of bridges, too
    labels='^(unit|dds|bridge)$'
    options+=(--target bridge_tests)
  fi
  ctest_arguments=(--label-regex "$labels" --label-exclude "$left_out" "${ctest_arguments[@]}")
fi

step=0
begin() {
  step=$((step + 1))
  printf '%s step %d of %d: %s\n' "$(date +%T)" $step $steps "$*" >&2
}

begin "packages of the system"
"$root/deploy/setup.sh" "${setup_options[@]}"

begin "build of the preset $preset and its tests"
"$root/deploy/build.sh" --preset $preset --tests "${options[@]}"

# The presets and the modes of tests/platform/run.sh whose tests are skipped.
export VDRIVE_SKIPPED=
no_time_left() {
  [[ -n $last_begin ]] && ((SECONDS > last_begin))
}
for checked in "${presets[@]}"; do
  if no_time_left; then
    VDRIVE_SKIPPED+=" $checked"
    steps=$((steps - 1))
    echo "$(date +%T) no time is left for the preset $checked: its test is skipped" >&2
    continue
  fi
  begin "build of the preset $checked"
  # This shows the progress; the test of the preset reports a failure.
  "$root/tests/checks/build_preset.sh" "$checked" >&2 || true
done

# A complete build on the other Debian takes half an hour on two processors (tests/platform/run.sh).
if $full && [[ ${VDRIVE_NIGHTLY:-} != 1 ]]; then
  VDRIVE_SKIPPED+=" check"
fi
if no_time_left; then
  VDRIVE_SKIPPED+=" wire"
  echo "$(date +%T) no time is left for the wire on the other Debian: its test is skipped" >&2
fi

begin "tests"
cd "$root"
readonly judge=$root/tests/checks/failures.py results=$root/build/$preset/Testing
mkdir -p "$results"
rm -f "$results"/{first,again}.{xml,log}
ran=("$results/first.xml")
# A skipped test does not fail a run, but it proves no statement. Only a run of all tests is checked.
check_conformance() {
  if $full && $whole; then
    tests/conformance/check.py "${ran[@]/#/--results=}" >&2
  fi
}

code=0
ctest --preset $preset "${ctest_arguments[@]}" --output-junit "$results/first.xml" \
  --output-log "$results/first.log" || code=1
[[ -s $results/first.xml ]] || exit $code
# For ctest, a suite of GoogleTest is one test.
"$root/tests/checks/results.py" count "$results/first.xml" >&2
if ((code == 0)); then
  check_conformance
  exit
fi
$retry || exit 1
ctest --preset $preset --show-only=json-v1 >"$results/labels.json"
mapfile -t late < <("$judge" late "$results/first" "$results/labels.json")
readonly most=10 # if more tests are late, there is one reason for all
if ((${#late[@]} > most)); then
  printf '%d tests were late, more than %d: none is repeated\n' ${#late[@]} $most >&2
  exit 1
fi
if ((${#late[@]})); then
  steps=$((steps + 1))
  begin "the tests that were late, one at a time"
  printf -v names '%s|' "${late[@]//./\\.}"
  ctest --preset $preset --tests-regex "^(${names%|})$" --parallel 1 \
    --output-junit "$results/again.xml" --output-log "$results/again.log" || true
  ran+=("$results/again.xml")
fi
"$judge" second "$results/first" "$results/again" "$results/labels.json" >&2
check_conformance
