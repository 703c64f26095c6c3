# SPDX-License-Identifier: Apache-2.0
# To be sourced by scripts that install packages.
#
#   as_root=(...)    prefix of commands that need root: empty, or sudo
#   apt WORD...      runs apt-get with these words and shows its output only if it fails
# shellcheck shell=bash

as_root=()
if ((EUID != 0)); then
  as_root=(sudo)
fi

# sudo resets the environment, so the variable is passed as an argument.
apt() {
  local output
  if ! output=$("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get --quiet \
    --option DPkg::Lock::Timeout=300 --option Acquire::Retries=3 "$@" 2>&1); then
    printf '%s\n' "$output" >&2
    return 1
  fi
}
