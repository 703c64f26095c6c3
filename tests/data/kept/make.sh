#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the kept files of a version with its own programs, from bench.yaml and moves.scn there.
#
#   tests/data/kept/make.sh BIN VERSION      such as build/release/bin 1.0
#
# Once for each minor version, at its release: later versions read what this one wrote
# (docs/reference/compatibility.md). Before the release of VERSION it may be run again.
set -euo pipefail

bin=$(cd "$1" && pwd)
kept=$(cd "$(dirname "$0")/$2" && pwd)
work=$(mktemp -d)
export VDRIVE_DOMAIN=${VDRIVE_DOMAIN:-97}
service=
finish() {
  [[ -z $service ]] || kill "$service" 2>/dev/null || true
  wait
  rm -rf "$work"
}
trap finish EXIT

"$bin/vdrived" --config "$kept/bench.yaml" --state "$work/state" --journal "$work/run.journal" \
  --log-level warn &
service=$!
"$bin/vdrive" list --timeout 30 >/dev/null
"$bin/vdrive" write 7.2 profile_velocity 1234 >/dev/null
"$bin/vdrive" store 7.2 >/dev/null
"$bin/vdrive" run "$kept/moves.scn" >/dev/null
for ending in mcap csv jsonl; do
  "$bin/vdrive" record "$work/run.$ending" 7.1 7.2 --count 21 >/dev/null &
  recorder=$!
  # In lock-step a recorder sees steps only: single ones, until it has what it counts.
  while kill -0 "$recorder" 2>/dev/null; do "$bin/vdrive" step 1 >/dev/null; done
  wait "$recorder"
done
kill "$service"
wait "$service"
service=
cp "$work"/run.* "$work/state/bench-7.parameters" "$kept/"
