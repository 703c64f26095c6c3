#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs every unit test and every test over DDS again and again and counts what fails.
#
#   tests/repeat.sh N [--load none|compiler|spin:K] [--markdown] [ctest arguments...]
#
#   N            the number of runs; the build is made once
#   --load       what else the machine does:
#                none       nothing, the default
#                compiler   a compiler on each processor, which compiles one source of the build
#                           again and again
#                spin:K     K busy loops
#   --markdown   prints the table in the format of docs/explanation/testing.md
#
# Nothing is tried twice. Each run leaves build/repeat/RUN.xml and RUN.log with the output of each test, and
# build/repeat/table.txt says what failed, how often and how; tests/checks/failures.py has the kinds. The
# first line says whether the machine stood still during the runs (tests/checks/standstill.py):
# tests then miss deadlines through no fault of ours. The load ends with this script, however that ends.
# Exit code 0: nothing failed.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$root/build/repeat
judge=$root/tests/checks/failures.py
runs=
load=none
table_options=()
ctest_arguments=()

fail() {
  echo "repeat.sh: $*" >&2
  exit 2
}

while (($#)); do
  case $1 in
    --load)
      (($# >= 2)) && [[ $2 =~ ^(none|compiler|spin:[1-9][0-9]*)$ ]] ||
        fail "--load needs none, compiler or spin:K, K a whole number above 0; it has '${2:-}'"
      load=$2 && shift ;;
    --markdown) table_options=(--markdown) ;;
    *)
      if [[ -z $runs ]]; then
        [[ $1 =~ ^[1-9][0-9]*$ ]] || fail "the number of runs is a whole number above 0, not '$1'"
        runs=$1
      else
        ctest_arguments+=("$1")
      fi ;;
  esac
  shift
done
[[ -n $runs ]] || fail "usage: tests/repeat.sh N [--load none|compiler|spin:K] [--markdown] [ctest arguments...]"

# Each loop is a process group: its compiler ends with it. The kernel ends the loop when this
# script is killed.
loads=()
stop_load() {
  local group tries
  for group in "${loads[@]}"; do
    kill -KILL -- "-$group" 2>/dev/null || true
  done
  # On a busy machine a killed process runs for another moment; one that nobody waits for remains.
  for group in "${loads[@]}"; do
    for ((tries = 0; tries < 500; ++tries)); do
      kill -0 -- "-$group" 2>/dev/null || break
      sleep 0.01
    done
  done
  loads=()
  rm -f "$work"/load-*.o
}
trap stop_load EXIT
trap 'exit 130' INT TERM HUP

begin_load() {
  local body=$1 count=$2 number
  for ((number = 0; number < count; ++number)); do
    setsid setpriv --pdeathsig KILL bash -c "$body" "$work/load-$number.o" >/dev/null 2>&1 </dev/null &
    loads+=($!)
    disown
  done
}

# The command that compiles one source of the library for clients, without the cache and with its
# output in $0.
compile_command() {
  python3 - "$root/build/release/compile_commands.json" <<'PYTHON'
import json, shlex, sys
row = next(row for row in json.load(open(sys.argv[1]))
           if "/vdrive_sessions.dir/" in row["command"] and "cmake_pch" not in row["file"])
words, kept = shlex.split(row["command"]), []
while words:
    word = words.pop(0)
    if word in ("-o", "-MF", "-MT"):
        words.pop(0)
    elif word != "-MD" and not word.endswith("ccache"):
        kept.append(word)
print("cd", shlex.quote(row["directory"]), "&& while :; do", shlex.join(kept), '-o "$0"; done')
PYTHON
}

"$root/deploy/build.sh" --tests
rm -rf "$work"
mkdir -p "$work"
cd "$root"

setpriv --pdeathsig KILL python3 -B "$root/tests/checks/standstill.py" watch >"$work/standstill.txt" &
watch=$!

case $load in
  compiler) begin_load "$(compile_command)" "$(nproc)" ;;
  spin:*) begin_load 'while :; do :; done' "${load#spin:}" ;;
esac

done_runs=()
for ((run = 1; run <= runs; ++run)); do
  ctest --preset release --label-regex '^(unit|dds|full)$' --quiet "${ctest_arguments[@]}" \
    --output-junit "$work/$run.xml" --output-log "$work/$run.log" >/dev/null || true
  grep --quiet '<testcase' "$work/$run.xml" || fail "no test ran; $work/$run.log says why"
  done_runs+=("$work/$run")
  printf '%s run %d of %d: %s\n' "$(date +%T)" $run "$runs" "$("$judge" table "$work/$run" | head --lines 1)" >&2
done
stop_load
kill -TERM $watch
wait $watch

failed=0
{
  cat "$work/standstill.txt"
  echo "load: $load"
  "$judge" table "${table_options[@]}" "${done_runs[@]}"
} >"$work/table.txt" || failed=1
cat "$work/table.txt"
exit $failed
