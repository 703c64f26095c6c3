#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds vdrived and proves that a bench outlives its clients and its network library.
#
#   tests/churn/run.sh [--nightly] [--seconds N] [--kills N] [--service FILE] [arguments of churn.py...]
#
#   --seconds N     how long clients come and go next to 1,024 axes, default 180 (3 minutes)
#   --kills N       how many wire processes are killed, default 60; 0 = none
#   --nightly       an hour and 1,000 kills, also set by VDRIVE_NIGHTLY=1
#   --service FILE  another vdrived with the same IDL
#
# Other arguments are passed to churn.py: --axes, --clients, --allow-jumps and the bounds; see its
# --help. Exit code 0: both passed, 1: one failed. A vdrived without a wire process has nothing to
# kill.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
seconds=180
kills=60
service=
arguments=()

nightly() {
  seconds=3600
  kills=1000
}

if [[ -n ${VDRIVE_NIGHTLY:-} ]]; then
  nightly
fi
while (($#)); do
  case $1 in
    --seconds | --kills | --service) (($# >= 2)) || { echo "run.sh: $1 needs a value" >&2; exit 2; } ;;&
    --nightly) nightly ;;
    --seconds) seconds=$2 && shift ;;
    --kills) kills=$2 && shift ;;
    --service) service=$2 && shift ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

"$root/deploy/setup.sh" --tests
"$root/deploy/build.sh" --tests --target vdrived --target churn_client
programs=(--service "${service:-$root/build/release/bin/vdrived}"
  --client "$root/build/release/tests/churn/churn_client")

failed=0
python3 -B "$root/tests/churn/churn.py" "${programs[@]}" --seconds "$seconds" "${arguments[@]}" ||
  failed=1
if ((kills > 0)); then
  code=0
  python3 -B "$root/tests/churn/kills.py" "${programs[@]}" --kills "$kills" || code=$?
  ((code == 0 || code == 77)) || failed=1
fi
exit $failed
