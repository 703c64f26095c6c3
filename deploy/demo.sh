#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The demonstration: installs missing packages, builds, starts the service with its demo bench and
# runs the two worked examples of the manual against it over DDS, live in this terminal.
#
#   deploy/demo.sh [--packages DIR|URL] [--serve]
#
#   --packages DIR|URL
#             do not build: install vdrived and vdrive with apt, from a folder of packages
#             (deploy/package.sh) or from a signed repository (deploy/repository.sh), which remains
#             configured for apt: /etc/apt/sources.list.d/vdrive.list
#   --serve   do not run the examples: keep the service in the foreground, together with the gateway
#             and its page, which may command the axes: http://127.0.0.1:8765/, or
#             VDRIVE_LISTEN=ADDRESS:PORT
#
# While it runs, `vdrive watch 1.1` (in build/release/bin, or installed) shows the axis in a second
# terminal. The service runs as bench 1 on DDS domain 0, or on VDRIVE_DOMAIN; if bench 1 already
# exists, it uses the next free number and reports it. No process is left running. Exit code 0: both
# examples passed.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
bin=$root/build/release/bin
scenarios=$root/clients/scenarios
domain=${VDRIVE_DOMAIN:-0}
listen=${VDRIVE_LISTEN:-127.0.0.1:8765}
highest_bench=9
serve=false
source=
readonly usage="usage: deploy/demo.sh [--packages DIR|URL] [--serve]"

fail() {
  echo "demo: $*" >&2
  exit 1
}

while (($#)); do
  case $1 in
    --serve) serve=true ;;
    --packages)
      (($# >= 2)) || fail "--packages needs a folder of packages or the URL of a repository; $usage"
      source=$2 && shift
      ;;
    *) fail "unknown option '$1'; $usage" ;;
  esac
  shift
done

# shellcheck source=deploy/apt.sh
source "$root/deploy/apt.sh"

# Adds a signed repository to the sources of apt. The key is fetched from the same place; if you do
# not trust that, install the key in another way first.
add_repository() {
  local url=${1%/} keyring=/etc/apt/keyrings/vdrive.asc fetched reason
  fetched=$(mktemp -d)
  if ! /usr/lib/apt/apt-helper download-file "$url/vdrive.asc" "$fetched/vdrive.asc" >"$fetched/log" 2>&1; then
    reason=$(sed -n 's/^E: Failed to fetch [^ ]* *//p' "$fetched/log")
    rm -r "$fetched"
    fail "no key at $url/vdrive.asc ($reason): repositories without a key are refused; deploy/repository.sh creates one with a key"
  fi
  "${as_root[@]}" install -D -m 644 "$fetched/vdrive.asc" "$keyring"
  rm -r "$fetched"
  "${as_root[@]}" tee /etc/apt/sources.list.d/vdrive.list >/dev/null \
    <<<"deb [signed-by=$keyring] $url $VERSION_CODENAME main"
}

install_packages() {
  local names=(vdrived vdrive) install=() name files found
  ! $serve || names+=(vdrive-gateway)
  # shellcheck source=/dev/null
  . /etc/os-release
  [[ $ID == debian && $VERSION_ID =~ ^(12|13)$ ]] ||
    fail "the packages are for Debian 12 and 13, and this is $PRETTY_NAME"
  if [[ -d $source/dists ]]; then
    source=file:$(realpath "$source")
  fi
  case $source in
    http://* | https://* | file:/*)
      add_repository "$source"
      install=("${names[@]}")
      ;;
    *)
      [[ -d $source ]] || fail "--packages: $source is neither a folder nor a URL (http://, https://, file:/)"
      for name in "${names[@]}"; do
        files="${name}_*~deb${VERSION_ID}_$(dpkg --print-architecture).deb"
        found=$(find "$(realpath "$source")" -maxdepth 1 -name "$files" | sort -V | tail -n 1)
        [[ -n $found ]] || fail "--packages: $source has no package $name for this Debian ($files)"
        install+=("$found")
      done
      ;;
  esac
  echo "demo: installing ${install[*]##*/}" >&2
  apt update || fail "apt-get update failed"
  apt install --yes --no-install-recommends "${install[@]}" || fail "apt-get install failed"
}

((EUID == 0)) || [[ -z $source ]] || command -v sudo >/dev/null || fail "--packages: run as root, or install sudo"
if [[ -n $source ]]; then
  bin=/usr/bin
  scenarios=/usr/share/vdrive/scenarios
  install_packages
else
  setup_options=()
  targets=(--target vdrived --target vdrive)
  if $serve; then
    setup_options+=(--page)
    targets+=(--target vdrive-gateway)
  fi
  "$root/deploy/setup.sh" "${setup_options[@]}"
  "$root/deploy/build.sh" "${targets[@]}"
fi

vdrive() {
  "$bin/vdrive" --domain "$domain" "$@"
}

# Prints the numbers of the benches on this domain, one per line.
taken_benches() {
  vdrive --timeout 1 --json list 2>/dev/null | sed -n 's/.*"bench":\([0-9]*\),.*/\1/p' | sort -un
}

bench=1
taken=$(taken_benches || true)
while grep -qx "$bench" <<<"$taken"; do
  bench=$((bench + 1))
  ((bench <= highest_bench)) || fail "all benches from 1 to $highest_bench are in use on domain $domain"
done
((bench == 1)) || echo "demo: bench 1 already exists on domain $domain; using bench $bench"

domain_option=
if [[ $domain != 0 ]]; then
  domain_option=" --domain $domain"
fi
watch_command="${bin#"$root/"}/vdrive$domain_option watch $bench.1"

work=$(mktemp -d)
programs=()
# Ends all started processes, however this script ends.
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

# Before the service announces itself, it takes a short time to check that its number is free.
if ! vdrive --timeout 10 status "$bench.1" >/dev/null 2>"$work/status.log"; then
  cat "$work/vdrived.log" "$work/status.log" >&2
  fail "the service did not start"
fi

echo "demo: bench $bench with two axes on DDS domain $domain, in real time"
echo "demo: in a second terminal: $watch_command"

results=()
failed=false
run_example() {
  local title=$1 file=$scenarios/$2
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
echo "== results"
printf '%s\n' "${results[@]}"
vdrive list
if $failed; then
  exit 1
fi
