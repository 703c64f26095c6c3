#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the benchmarks of the parts below and runs them, which takes some 14 minutes. Prints one
# JSON line for each figure on standard output (figures.py table FILE turns them into a table):
#   {"figure":"axis_tick_ns","axes":1024,"value":...}
# Everything else goes to standard error. Figures of the network are printed next to those of the
# DDS library alone, from the same run. Needs an otherwise idle machine and permission to use the
# loopback interface. The gateway has gateway.py.
#
#   ./tests/benchmark/run.sh [--quick]
#                            [--only core|service|steps|status|start|bench|python|canopen|lateness]
#
#   --quick    short runs, for a first estimate
#   --only     one part: ticks of the bank; ticks, threads, stores and publication of the engine;
#              steps over DDS; status that clients receive, and recordings; start and list; a bench in
#              the process and one over DDS, from C++, Python, pytest and `vdrive test`; the Python
#              module and C++; CANopen nodes, alone and on a socketcand server; how late ticks begin
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/tests/benchmark/spinners.sh"
rounds=21
follow_seconds=20
longest_seconds=60
steps=3
few_rounds=5
only=
while (($#)); do
  case $1 in
    --quick) rounds=5 follow_seconds=4 longest_seconds=10 steps=1 few_rounds=1 ;;
    --only)
      only=${2-} && shift
      if ! [[ $only =~ ^(core|service|steps|status|start|bench|python|canopen|lateness)$ ]]; then
        echo "run: --only '$only' is no part" >&2 && exit 2
      fi ;;
    *) echo "run: unknown option '$1'" >&2 && exit 2 ;;
  esac
  shift
done

"$root/deploy/setup.sh" --tests
"$root/deploy/build.sh" --tests -D VDRIVE_BUILD_BENCHMARKS=ON --target vdrived --target vdrive \
  --target vdrive_core_benchmark --target vdrive_service_benchmark \
  --target vdrive_parameter_benchmark --target vdrive_publication_benchmark \
  --target vdrive_bare_benchmark --target vdrive_wire_benchmark --target vdrive_follow_benchmark \
  --target vdrive_threads_benchmark --target vdrive_lateness_benchmark \
  --target vdrive_local_benchmark --target vdrive_step_benchmark --target vdrive_python \
  --target vdrive-canopen --target vdrive_canopen_benchmark

build=$root/build/release
programs=$build/tests/benchmark
service=$build/bin/vdrived
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

figure() {
  printf '{"figure":"%s","axes":%s,"value":%s}\n' "$1" "$2" "$3"
}

# The time of `vdrive list` with one bench.
measure_list() {
  local axes=$1 domain=19 attempt begin end
  "$service" --axes "$axes" --domain $domain --log-level error &
  local bench=$!
  "$build/bin/vdrive" --domain $domain --timeout 20 list >"$work/list"
  for attempt in 1 2 3 4 5; do
    begin=$(date +%s%N)
    "$build/bin/vdrive" --domain $domain list >"$work/list"
    end=$(date +%s%N)
    figure list_ms "$axes" $(((end - begin) / 1000000))
  done
  kill $bench
  wait $bench || true
}

follow() {
  "$programs/vdrive_follow_benchmark" "$service" "$@"
}

core() {
  "$programs/vdrive_core_benchmark" --benchmark_min_time=0.1
}

service() {
  "$programs/vdrive_service_benchmark"
  "$programs/vdrive_threads_benchmark" 2048 $rounds
  "$programs/vdrive_threads_benchmark" 16384 $rounds
  "$programs/vdrive_parameter_benchmark" "$root/build"
  "$programs/vdrive_publication_benchmark" 1024 $rounds
  "$programs/vdrive_publication_benchmark" 4096 $rounds
}

steps() {
  local step
  for ((step = 0; step < steps; ++step)); do
    "$programs/vdrive_bare_benchmark" round-trip 10000
    "$programs/vdrive_wire_benchmark" "$service" step --clock lockstep --axes 64
  done
}

# All axes move unless the name of the figure excludes it, because a bench of resting axes takes
# next to no time.
status() {
  local axes
  for axes in 256 1024 2048; do
    follow $follow_seconds 1 --moving --axes $axes
  done
  follow $longest_seconds 1 --moving --axes 4096
  follow $follow_seconds 2 --moving --axes 4096 | sed 's/"figure":"/&two_clients_/'
  printf 'status:\n  every_ticks: 10\n' >"$work/decimated.yaml"
  follow $follow_seconds 1 --config "$work/decimated.yaml" --axes 16384 |
    sed 's/"figure":"/&at_rest_/'
  printf 'clock:\n  realtime_priority: 50\nstatus:\n  every_ticks: 10\n' >"$work/realtime.yaml"
  follow $follow_seconds 1 --config "$work/realtime.yaml" --axes 16384 |
    sed 's/"figure":"/&at_rest_realtime_/'
  printf 'clock:\n  threads: 2\n  realtime_priority: 50\nstatus:\n  every_ticks: 10\n' \
    >"$work/threads.yaml"
  follow $follow_seconds 1 --moving --config "$work/threads.yaml" --axes 12288 |
    sed 's/"figure":"/&two_threads_realtime_/'
  "$root/tests/benchmark/record.py" --axes 1024 --seconds $follow_seconds
}

start() {
  follow 1 1 --axes 10000
  measure_list 1024
}

# The time of `vdrive test` for the project's scenarios, in turn without and with DDS.
measure_scenarios() {
  local over aim attempt begin end
  for ((attempt = 0; attempt < few_rounds; ++attempt)); do
    for over in local dds; do
      [[ $over == local ]] && aim=',"aim":2000' || aim=
      begin=$(date +%s%N)
      "$build/bin/vdrive" test --over $over "$root"/clients/scenarios/*.scn >"$work/scenarios"
      end=$(date +%s%N)
      printf '{"figure":"scenarios_ms","over":"%s","value":%d%s}\n' $over \
        $(((end - begin) / 1000000)) "$aim"
    done
  done
}

python_figures() {
  "$root/tests/benchmark/python_figures.py" --rounds $few_rounds --seconds $follow_seconds --only "$@"
}

bench() {
  "$programs/vdrive_local_benchmark" "$service" $rounds
  python_figures bench fixture
  measure_scenarios
}

python() {
  python_figures bank steps stream
}

canopen() {
  "$programs/vdrive_canopen_benchmark" --benchmark_min_time=0.1
  "$root/tests/benchmark/canopen.py" --seconds $((follow_seconds / 2)) --rounds $few_rounds
}

lateness() {
  local priority clients
  for priority in 0 50; do
    for clients in 0 4; do
      "$programs/vdrive_lateness_benchmark" "$service" $follow_seconds $clients $priority --axes 256
    done
  done
}

# Parts that use both processors run without the spinners. With them, a step occasionally took 1 to
# 2 ms, a client of 4,096 axes missed 1.3 and 1.9 % of the ticks in two of three runs, and a call of
# the tool took seconds; without them, none of this happened.
run_part() {
  case $1 in
    steps | status | start | bench | python | canopen) "$1" ;;
    *)
      keep_awake
      "$1"
      stop_spinners
      ;;
  esac
}

for part in core service steps status start bench python canopen lateness; do
  if [[ -z $only || $only == "$part" ]]; then
    run_part "$part"
  fi
done |
  awk '/^\{"figure"/ { print; fflush(); next } { print > "/dev/stderr" }'
