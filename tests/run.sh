#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Shows that vdrive works: installs what is missing, builds the release, and runs the tests.
#
#   tests/run.sh [--full] [--presets-until MINUTES] [--nightly] [ctest arguments...]
#
# Without an option: every unit test, every test over DDS and every scenario, in some 9 minutes on
# two cores from nothing.
#
#   --full      also what continuous integration checks, in 40 minutes: the sanitizers, clang-tidy,
#               the format, the fuzzers, the coverage, the packages, the sandbox, the conformance
#               document, clients that come and go, benchmarks that still compile, the page of the
#               gateway in a browser
#   --presets-until MINUTES
#               begins the build of no preset later than that after the start, and skips its test:
#               where a run is ended from outside, a slow machine shows less rather than nothing
#   --nightly   --full with the long counts of property, fuzz and soak tests (VDRIVE_NIGHTLY=1)
#
# The steps and their times are written to standard error, ctest's summary is written last. A preset
# is a test too (label checks), so that the summary covers all of them. What was built and
# linted once is not done again.
#
# The tests over DDS run beside each other and wait with deadlines, which a machine can miss whose
# processor is taken away. A test that fails is therefore run once more, with no other beside it.
# It is named at the end, also when it passes then: such a test has a fault to be found.
# Exit code 0: each test passed, in the first run or alone.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
full=false
last_begin=
ctest_arguments=()
while (($#)); do
  case $1 in
    --full) full=true ;;
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
    *) ctest_arguments+=("$1") ;;
  esac
  shift
done

steps=3
presets=()
setup_options=(--tests)
options=(-D VDRIVE_CHECK_PRESETS=OFF)
if $full; then
  setup_options+=(--page --browser)
  presets=(fuzz asan tidy tsan coverage) # what is skipped first comes last
  steps=$((3 + ${#presets[@]}))
  options=(-D VDRIVE_CHECK_PRESETS=ON -D VDRIVE_BUILD_BENCHMARKS=ON)
else
  ctest_arguments=(--label-regex '^(unit|dds)$' "${ctest_arguments[@]}")
fi

step=0
begin() {
  step=$((step + 1))
  printf '%s step %d of %d: %s\n' "$(date +%T)" $step $steps "$*" >&2
}

begin "packages of the system"
"$root/deploy/setup.sh" "${setup_options[@]}"

begin "build of the release and its tests, 6 minutes on two cores from nothing"
"$root/deploy/build.sh" --tests "${options[@]}"

export VDRIVE_SKIPPED_PRESETS=
for preset in "${presets[@]}"; do
  if [[ -n $last_begin ]] && ((SECONDS > last_begin)); then
    VDRIVE_SKIPPED_PRESETS+=" $preset"
    steps=$((steps - 1))
    echo "$(date +%T) no time is left for the preset $preset: its test is skipped" >&2
    continue
  fi
  begin "build of the preset $preset"
  # Here the progress is seen; a failure is reported by the test of that preset.
  "$root/tests/checks/build_preset.sh" "$preset" >&2 || true
done

begin "tests"
cd "$root"
readonly failed=$root/build/release/Testing/Temporary/LastTestsFailed.log
rm -f "$failed"
ctest --preset release "${ctest_arguments[@]}" && exit 0

readonly most=40 # more failures than these have a common cause
if [[ ! -s $failed ]] || (($(wc -l <"$failed") > most)); then
  exit 1
fi
unstable=$(sed 's/^[0-9]*://' "$failed")
steps=$((steps + 1))
begin "the tests that failed, one at a time"
ctest --preset release --rerun-failed --parallel 1
printf 'Failed beside other tests, passed alone:\n%s\n' "$unstable" >&2
