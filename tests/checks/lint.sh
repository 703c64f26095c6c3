#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Lints our sources with clang-tidy.
#
#   tests/checks/lint.sh          lints what was not found clean before
#   tests/checks/lint.sh --keep   then notes in tests/checks/linted.txt what is clean: before each landing
#   tests/checks/lint.sh COMPILER ARGUMENT... -o OBJECT -MF DEPENDENCIES -c SOURCE
#                                 in place of the compiler (VDRIVE_LINT): lints this source
#
# What clang-tidy sees of a source are the source and those of our headers that it includes, its text
# behind the preprocessor with comments and macros (the headers of others), the options of the compiler, and
# the rules. linted.txt has the check sums of all of that together, with this script and the version of
# clang-tidy, that were found clean. The same input has the same result, and is not read again.
# Paths are written from the root of the tree. A linted object has the line of its source in linted.txt.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
linted=$root/tests/checks/linted.txt

if [[ ${1:-} != */* ]]; then
  if (($# > 1)) || [[ -n ${1:-} && $1 != --keep ]]; then
    echo "lint.sh: unknown '$*'; usage: tests/checks/lint.sh [--keep]" >&2
    exit 2
  fi
  "$root/tests/checks/build_preset.sh" tidy
  if [[ ${1:-} == --keep ]]; then
    list=$(xargs cat <"$root/build/tidy/linted_objects.txt" | sort --key 2)
    printf '%s\n' "$list" >"$linted"
  fi
  exit
fi

compile=("$@")
preprocess=()
while (($#)); do
  case $1 in
    -o) object=$2 && shift ;;
    -c) preprocess+=(-E -C -dD) ;;
    -MF) dependencies=$2 && preprocess+=("$1" "$2") && shift ;;
    *) preprocess+=("$1") ;;
  esac
  shift
done

input() {
  "${preprocess[@]}"
  grep --only-matching "$root/[^ \\]*" "$dependencies" | sort --unique | xargs cat
  printf '%s\n' "${compile[@]}"
  clang-tidy --version | grep 'LLVM version'
  cat "$root/.clang-tidy" "${BASH_SOURCE[0]}"
}
sum=$(set -e && input | sed "s|$root|.|g" | sha256sum | cut --delimiter ' ' --fields 1)
grep --quiet --no-messages "^$sum " "$linted" || clang-tidy --quiet "${compile[-1]}" -- "${compile[@]}"
echo "$sum $object" >"$object"
