#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A fleet in pods of podman: a discovery server, six benches of 500 axes, a gateway, two masters.
#
#   tests/fleet/run.sh [--images DIR] [--client FILE] [--next VDRIVED] [--keep] [--nightly]
#
#   --images DIR     made by deploy/image.sh; default: made from build/packages, which is built if
#                    missing
#   --client FILE    the masters' program network_client; default: that of a build with tests
#   --next VDRIVED   a program of another version, to which the benches are upgraded; default: the
#                    same one in an image with another name
#   --keep           leaves the pods of a failed run, and prints how to inspect them
#   --nightly        skips unless VDRIVE_NIGHTLY=1
#
# The pods are those of deploy/kubernetes/bench/lab, each with an address, and without multicast. A
# group moves axes of three benches. A pod is killed in motion; all benches are upgraded one by one
# while a master uses the others; the discovery server is killed and returns with another address;
# a node's worth of pods is drained, and lost; mistakes are made; two benches run in closed mode.
# Prints each step and its duration, and finally the figures as a table. Needs deploy/setup.sh
# --tests --judges --images and root. Takes five minutes. Exit code 0: passed; 77: this machine cannot run pods.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
images=
client=
options=()
fail() {
  echo "fleet: $*" >&2
  exit 1
}
skip() {
  echo "fleet: $*" >&2
  exit 77
}
while (($#)); do
  case $1 in
    --images | --client | --next) (($# >= 2)) || fail "$1 needs a value" ;;&
    --images) images=$2 && shift ;;
    --client) client=$2 && shift ;;
    --next) options+=(--next "$2") && shift ;;
    --keep) options+=(--keep) ;;
    --nightly) [[ ${VDRIVE_NIGHTLY:-} == 1 ]] || skip "runs in the night" ;;
    *) fail "unknown option '$1'" ;;
  esac
  shift
done
for each in podman kubectl; do
  command -v "$each" >/dev/null || skip "$each is not installed"
done
((EUID == 0)) || skip "the networks of pods need root"
for each in release quick; do
  [[ -n $client || ! -x $root/build/$each/tests/network/network_client ]] ||
    client=$root/build/$each/tests/network/network_client
done
[[ -n $client ]] || fail "no network_client: deploy/build.sh --tests --target network_client"

work=$(mktemp -d)
[[ " ${options[*]-} " == *" --keep "* ]] || trap 'rm -rf "$work"' EXIT
if [[ -z $images ]]; then
  images=$work/images
  compgen -G "$root/build/packages/*.deb" >/dev/null || "$root/deploy/package.sh" >/dev/null
  "$root/deploy/image.sh" --out "$images" bench discovery gateway >/dev/null
fi
secret() {
  echo ---
  kubectl create secret generic "$@" --dry-run=client --output yaml
}
render() { # `bases` and `patchesStrategicMerge`, since the kubectl of Debian 12 knows nothing newer
  kubectl kustomize "$1" 2> >(grep -v deprecated >&2)
}
{
  render "$root/tests/fleet"
  secret vdrive-gateway --from-literal token=0123456789abcdef
} | "$root/deploy/kubernetes/pods.py" "$work/pods"
{
  "$root/deploy/security/make_authority.sh" "$work/authority"
  "$root/deploy/security/make_member.sh" "$work/authority" service benches
  "$root/deploy/security/make_member.sh" "$work/authority" viewer gateway
} 2>"$work/security.log" || fail "$(<"$work/security.log")"
{
  render "$root/deploy/kubernetes/bench/closed"
  secret vdrive-gateway --from-literal token=0123456789abcdef
  secret vdrive-bench-security --from-file "$work/authority/members/benches"
  secret vdrive-gateway-security --from-file "$work/authority/members/gateway"
} | "$root/deploy/kubernetes/pods.py" "$work/closed"
strip -o "$work/client" "$client"
python3 -B "$root/tests/fleet/fleet.py" --pods "$work/pods" --closed "$work/closed" --images "$images" \
  --client "$work/client" --work "$work" "${options[@]}"
