#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a node program in the directory where the page of the gateway was built.
#
#   tests/browser/check_page.sh DIRECTORY PROGRAM [ARGUMENTS...]
#
# Exit code: that of the program; 77: the page was not built, because npm or its registry was
# missing.
set -euo pipefail

if [[ ! -d $1/node_modules || ! -f $1/page.stamp ]]; then
  echo "the page was not built here: npm or its registry was missing"
  exit 77
fi
cd "$1"
shift
exec node "$@"
