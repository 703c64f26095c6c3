#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The demonstration: installs what is missing, builds, starts the service with its demo bench and
# runs the manual's two worked examples against it over DDS, live in this terminal.
#
#   deploy/demo.sh [--serve]
#
#   --serve   keep the service in the foreground instead of running the examples, and beside it the
#             gateway with its page, which may command the axes: http://127.0.0.1:8765/, or
#             VDRIVE_LISTEN=ADDRESS:PORT
#
# Meanwhile `build/release/bin/vdrive watch 1.1` shows the axis in a second terminal. The service
# runs as bench 1 on DDS domain 0, or on VDRIVE_DOMAIN; when bench 1 exists already it takes the
# next free number and reports it. No process is left running. Exit code 0: both examples passed.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
bin=$root/build/release/bin
domain=${VDRIVE_DOMAIN:-0}
listen=${VDRIVE_LISTEN:-127.0.0.1:8765}
highest_bench=9
serve=false

fail() {
  echo "demo: $*" >&2
  exit 1
}

while (($#)); do
  case $1 in
    --serve) serve=true ;;
    *) fail "unknown option '$1'; usage: deploy/demo.sh [--serve]" ;;
  esac
  shift
done

setup_options=()
targets=(--target vdrived --target vdrive)
if $serve; then
  setup_options+=(--page)
  targets+=(--target vdrive-gateway)
fi
"$root/deploy/setup.sh" "${setup_options[@]}"
"$root/deploy/build.sh" "${targets[@]}"

vdrive() {
  "$bin/vdrive" --domain "$domain" "$@"
}

# The benches on this domain, one number in each line.
taken_benches() {
  vdrive --timeout 1 --json list 2>/dev/null | sed -n 's/.*"bench":\([0-9]*\),.*/\1/p' | sort -un
}

bench=1
taken=$(taken_benches || true)
while grep -qx "$bench" <<<"$taken"; do
  bench=$((bench + 1))
  ((bench <= highest_bench)) || fail "benches 1 to $highest_bench are all taken on domain $domain"
done
((bench == 1)) || echo "demo: bench 1 exists already on domain $domain; this one is bench $bench"

domain_option=
if [[ $domain != 0 ]]; then
  domain_option=" --domain $domain"
fi
watch_command="build/release/bin/vdrive$domain_option watch $bench.1"

work=$(mktemp -d)
programs=()
# Ends every started process, however this script ends.
clean_up() {
  if ((${#programs[@]})); then
    kill "${programs[@]}" 2>/dev/null || true
    wait "${programs[@]}" 2>/dev/null || true
  fi
  rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 130' INT TERM HUP

if $serve; then
  echo "demo: bench $bench on domain $domain; in a second terminal: $watch_command"
  # Its first line is the address of the page.
  "$bin/vdrive-gateway" --domain "$domain" --listen "$listen" --control &
  programs+=($!)
  "$bin/vdrived" --domain "$domain" --bench "$bench" &
  programs+=($!)
  wait -n "${programs[@]}"
  exit
fi

"$bin/vdrived" --domain "$domain" --bench "$bench" --log-level warn 2>"$work/vdrived.log" &
programs+=($!)

# The service checks for a short time that its number is free before it announces itself.
if ! vdrive --timeout 10 status "$bench.1" >/dev/null 2>"$work/status.log"; then
  cat "$work/vdrived.log" "$work/status.log" >&2
  fail "the service did not start"
fi

echo "demo: bench $bench with two axes on DDS domain $domain, in real time"
echo "demo: in a second terminal: $watch_command"

results=()
failed=false
run_example() {
  local title=$1 file=$root/clients/scenarios/$2
  echo
  echo "== $title"
  if ((bench != 1)); then # the scenarios name bench 1
    sed "s/\b1\.\([12]\)\b/$bench.\1/g" "$file" >"$work/$2"
    file=$work/$2
  fi
  if vdrive run --live "$file"; then
    results+=("passed  $title")
  else
    results+=("FAILED  $title")
    failed=true
  fi
}

run_example "absolute position, forward: axis $bench.1 to 10000 UU in 10.17 s" absolute_forward.scn
run_example "absolute position, negative: axis $bench.2 to -10000 UU in 10.17 s" absolute_negative.scn

echo
echo "== what happened"
printf '%s\n' "${results[@]}"
vdrive list
if $failed; then
  exit 1
fi
