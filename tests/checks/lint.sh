#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Lints our sources with clang-tidy.
#
#   tests/checks/lint.sh          lints every source that linted.txt does not list as clean
#   tests/checks/lint.sh --keep   also lists the clean sources in tests/checks/linted.txt: before each merge
#   tests/checks/lint.sh COMPILER ARGUMENT... -o OBJECT -MF DEPENDENCIES -c SOURCE
#                                 called in place of the compiler (VDRIVE_LINT): lints this source
#
# The result for a source depends on the source and our headers that it includes, on its preprocessed text
# with comments and macros (for other headers), on the compiler options, the rules, this script and the
# version of clang-tidy. linted.txt has a checksum of all this for each source that was found clean. A source
# with the same checksum is not linted again. Paths are relative to the root of the tree. The object file of a
# linted source contains its line of linted.txt.
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
