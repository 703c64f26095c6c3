#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Lints our sources with clang-tidy.
#
#   tests/checks/lint.sh          lints what was not found clean before
#   tests/checks/lint.sh --keep   then notes in tests/checks/linted.txt what is clean: before each landing
#   tests/checks/lint.sh COMPILER ARGUMENT... -o OBJECT -c SOURCE
#                                 in place of the compiler (VDRIVE_LINT): lints this source
#
# What clang-tidy sees of a source is its text behind the preprocessor with comments and macros, the options
# of the compiler, the rules, and its own version. linted.txt has the check sums of all of these together
# that were found clean; the same input has the same result, and is not read again. Paths are written from
# the root of the tree. A linted object has the line of its source in linted.txt.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
linted=$root/tests/checks/linted.txt

if [[ ${1:-} != */* ]]; then
  "$root/tests/checks/build_preset.sh" tidy
  if [[ ${1:-} == --keep ]]; then
    xargs cat <"$root/build/tidy/linted_objects.txt" | sort --key 2 >"$linted"
  fi
  exit
fi

compile=("$@")
preprocess=()
while (($#)); do
  case $1 in
    -o) object=$2 && shift ;;
    -c) preprocess+=(-E -C -dD) ;;
    *) preprocess+=("$1") ;;
  esac
  shift
done

sum=$({ "${preprocess[@]}" && printf '%s\n' "${preprocess[@]}" && clang-tidy --version &&
  cat "$root/.clang-tidy"; } | sed "s|$root|.|g" | sha256sum | cut --delimiter ' ' --fields 1)
grep --quiet --no-messages "^$sum " "$linted" || clang-tidy --quiet "${compile[-1]}" -- "${compile[@]}"
echo "$sum $object" >"$object"
