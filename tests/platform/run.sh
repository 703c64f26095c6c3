#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Creates a clean root of a Debian release, and follows the steps of a newcomer there.
#
#   tests/platform/run.sh bookworm|trixie [--full | --check | --wire] [--mirror URL] [--cache DIR]
#                         [--programs PRESET] [--keep]
#
# Without a mode: the two commands of the README, ./deploy/demo.sh and ./tests/run.sh.
#
#   --full        .ci/run instead of ./tests/run.sh
#   --wire        the part of .ci/run for the other Debian: builds idl/ and its unit tests with that
#                 system's clang, with warnings as errors, against its DDS library, and runs these
#                 tests
#   --check       the part of --nightly for the other Debian: builds the preset quick with that
#                 system's clang, with warnings as errors, runs the unit tests, the manual's two
#                 examples, and the tests across systems (tests/across) with the programs of this
#                 system
#   --programs PRESET   the programs of this system for --check: those in build/PRESET, default
#                       release
#   --mirror URL  source of the packages, default that of debootstrap
#   --cache DIR   keeps downloaded packages and compiled objects there; the root stays clean
#   --keep        keeps the root, and prints its path
#
# Needs root, debootstrap, and 5 GB in TMPDIR, more with --full. Mounts and processes are in namespaces
# of this run, and end with it. Standard output has a row for each
# step: release, step, result, time; standard error has the output of the steps. Exit code 0: every
# step passed; 77: skipped, because root or debootstrap is missing, or because tests/run.sh had no
# time for it; 2: wrong arguments.
set -euo pipefail

tree=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
usage="usage: tests/platform/run.sh bookworm|trixie [--full | --check | --wire] [--mirror URL] [--cache DIR] [--programs PRESET] [--keep]"

refuse() {
  echo "platform: $*" >&2
  exit 2
}

skip() {
  echo "platform: $*" >&2
  exit 77
}

# step NAME COMMAND...: runs the command and prints its row. The first failed step ends the run.
step() {
  local name=$1 begin=$SECONDS result=passed
  shift
  echo "$(date +%T) $release: $name" >&2
  "$@" >&2 || result="FAILED with exit code $?"
  printf '| %s | %s | %s | %d:%02d |\n' "$release" "$name" "$result" $(((SECONDS - begin) / 60)) $(((SECONDS - begin) % 60))
  [[ $result == passed ]]
}

# Runs a command in the root, as its administrator, with only the environment of a login.
inside() {
  chroot "$root" /usr/bin/env -i HOME=/root TERM="${TERM:-dumb}" PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
    ${JOBS:+JOBS="$JOBS"} ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
    bash -c "cd /vdrive && $1"
}

make_root() {
  debootstrap --variant=minbase ${cache:+--cache-dir="$cache/debootstrap"} "$release" "$root" ${mirror:+"$mirror"} &&
    printf '127.0.0.1 localhost\n::1 localhost\n' >"$root/etc/hosts" && # as Debian's installer does
    mkdir "$root/vdrive" &&
    tar -C "$tree" --exclude=./build --exclude=./.git --exclude=node_modules -c . | tar -C "$root/vdrive" -x
}

mount_in_root() {
  mount --bind "$root" "$root" # bubblewrap needs a mount at its /
  mount -t proc proc "$root/proc"
  mount --rbind /sys "$root/sys"
  mount --rbind /dev "$root/dev"
  mount -t tmpfs tmpfs "$root/dev/shm"
  mount -t tmpfs tmpfs "$root/run"
  [[ -n $cache ]] || return 0
  mkdir -p "$root/root/.cache/ccache"
  mount --bind "$cache/ccache" "$root/root/.cache/ccache"
  mount --bind "$cache/apt" "$root/var/cache/apt/archives"
}

# Builds with clang, in a third of gcc's time; gcc builds the demo of the README. Compute-bound
# work runs at idle priority, because tests with deadlines run at the same time.
build_for_check() {
  inside "chrt --idle 0 ./deploy/build.sh --preset quick --tests -D VDRIVE_WARNINGS_AS_ERRORS=ON \
    -D VDRIVE_CHECK_PRESETS=OFF -D VDRIVE_BUILD_BENCHMARKS=OFF ${*/#/--target }"
}

# Everything that this run does, in its namespace.
steps() {
  step "root by debootstrap" make_root
  mount_in_root
  case $mode in
    wire)
      step "packages of the tests" inside "./deploy/setup.sh --tests"
      step "build of idl/ and its tests" build_for_check wire_bytes_test wire_parts_test
      step "unit tests of idl/" inside "cd build/quick/tests/wire && chrt --idle 0 ./wire_bytes_test --gtest_brief=1 &&
        chrt --idle 0 ./wire_parts_test --gtest_brief=1"
      ;;
    check)
      step "packages of the tests" inside "./deploy/setup.sh --tests"
      step "build, quick" build_for_check vdrived vdrive unit_tests across_tests
      step "unit tests" inside "chrt --idle 0 ctest --preset quick --label-regex '^unit$'"
      step "the manual's examples, and the tests across" "$tree/tests/across/across.py" --a "$tree/build/$programs" \
        --b /vdrive/build/quick --root-b "$root"
      ;;
    *)
      step "./deploy/demo.sh" inside ./deploy/demo.sh
      if [[ $mode == full ]]; then
        step ".ci/run" inside .ci/run
      else
        step "./tests/run.sh" inside ./tests/run.sh
      fi
      ;;
  esac
}

release='' mode=readme mirror='' cache='' programs=release keep=false
while (($#)); do
  case $1 in
    bookworm | trixie) [[ -z $release ]] || refuse "one release at a time: '$release' or '$1'" && release=$1 ;;
    --full | --check | --wire) [[ $mode == readme ]] || refuse "--$mode and $1: one of them" && mode=${1#--} ;;
    --mirror | --cache | --programs)
      (($# > 1)) || refuse "$1 needs a value"
      declare "${1#--}=$2"
      shift
      ;;
    --keep) keep=true ;;
    *) refuse "'$1' is no release and no option; $usage" ;;
  esac
  shift
done
[[ -n $release ]] || refuse "which release? $usage"
[[ -z $mirror || $mirror =~ ^(https?|file):/ ]] || refuse "--mirror '$mirror': must be a URL, http, https or file"
[[ " ${VDRIVE_SKIPPED:-} " != *" $mode "* ]] || skip "--$mode is skipped by tests/run.sh"
((EUID == 0)) || skip "a root of $release needs the rights of root: debootstrap, chroot and mount"
command -v debootstrap >/dev/null || skip "no debootstrap here: deploy/setup.sh --tests installs it"
if [[ $mode == check && ! -x $tree/build/$programs/bin/vdrived ]]; then
  refuse "no program build/$programs/bin/vdrived: the tests across need it; deploy/build.sh --preset $programs"
fi
if [[ -n $cache ]]; then
  mkdir -p "$cache"/{debootstrap,ccache,apt/partial} || refuse "--cache '$cache': cannot be made"
  cache=$(cd "$cache" && pwd)
fi

root=$(mktemp -d "${TMPDIR:-/tmp}/vdrive-$release.XXXXXX")
chmod 755 "$root"
child=''
# The namespace and its mounts end with its first process; the root then consists only of files.
clean_up() {
  if [[ -n $child ]]; then
    kill -KILL "$child" 2>/dev/null || true
    wait "$child" 2>/dev/null || true
  fi
  if $keep; then
    echo "platform: the root is $root" >&2
  else
    rm -rf --one-file-system "$root"
  fi
}
trap clean_up EXIT
trap 'exit 130' INT TERM HUP

export -f step inside make_root mount_in_root build_for_check steps
export tree release mode mirror cache programs root
# In the background, because bash handles a signal during `wait`, but not while a command runs.
unshare --mount --pid --fork --kill-child bash -euo pipefail -c steps &
child=$!
wait "$child"
