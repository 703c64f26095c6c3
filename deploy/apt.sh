# SPDX-License-Identifier: Apache-2.0
# For scripts that install packages, which source this file.
#
#   as_root=(...)    what a command of the administrator begins with: nothing, or sudo
#   apt WORD...      apt-get with these words, whose output is shown only when it fails
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
