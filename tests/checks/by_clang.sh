#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The compiler launcher for tests if VDRIVE_TESTS_BY_CLANG is on:
# by_clang.sh GCC CLANG [LAUNCHER...] GCC ARGUMENT...
# CLANG compiles instead of GCC, without the options that it does not know.
set -euo pipefail

gcc=$1
clang=$2
shift 2
command=()
for argument in "$@"; do
  case $argument in
    "$gcc") command+=("$clang") ;;
    -fpch-preprocess | --param=* | -Wno-subobject-linkage) ;;
    *.gch) # -include would read the old precompiled header instead of the header
      rm -f "$argument"
      command+=("$argument") ;;
    *) command+=("$argument") ;;
  esac
done
exec "${command[@]}"
