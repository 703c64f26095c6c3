#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the simulation and plays seeds: by default 10,000 of 60 s of drive time with 16 axes. Each
# seed has different masters, another network and other disturbances; all invariants are checked in
# every tick.
#
#   tests/simulation/run.sh [--seeds N] [arguments of vdrive_simulation...]
#
#   --seeds N   play the seeds 1 to N
#
# For each seed that fails, prints the command that plays it again up to the same tick; at the end,
# prints how much faster than real time the seeds ran. Exit code 0: no seed failed and it was at least 200
# times faster than real time; 1: a seed failed; 3: too slow (the machine may be busy).
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
aim=200
seeds=10000
arguments=()
while (($#)); do
  case $1 in
    --seeds)
      (($# >= 2)) && [[ $2 =~ ^[1-9][0-9]*$ ]] || { echo "run.sh: --seeds needs a whole number above 0" >&2; exit 2; }
      seeds=$2 && shift ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

"$root/deploy/setup.sh" --tests
"$root/deploy/build.sh" --tests --target vdrive_simulation

log=$(mktemp)
trap 'rm -f "$log"' EXIT
"$root/build/release/tests/simulation/vdrive_simulation" --seeds "1..$seeds" "${arguments[@]}" | tee "$log"
ratio=$(sed -n 's/.*: \([0-9]*\)[.0-9]* times real time.*/\1/p' "$log")
if ((ratio < aim)); then
  echo "run.sh: $ratio times real time, the aim is $aim; is the machine busy?" >&2
  exit 3
fi
