#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the images from build/packages, inspects them, and runs them with podman.
#
#   tests/deploy/check_images.sh [DIR]
#
#   DIR   the packages; default build/packages, which are built if they are missing
#
# Needs deploy/setup.sh --images. Where podman cannot run containers, the images are only
# inspected; the last line gives the reason.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
packages=${1:-$root/build/packages}
work=$(mktemp -d)
containers=()

podman() {
  command podman --storage-driver vfs --root "$work/storage" --runroot "$work/run" "$@" 2>>"$work/podman.log"
}

clean_up() {
  ((${#containers[@]} == 0)) || podman rm --force --time 0 "${containers[@]}" >/dev/null || true
  rm -rf "$work"
}
trap clean_up EXIT

fail() {
  echo "check_images: $*" >&2
  exit 1
}

# Repeats a command until its output contains $1, for at most 60 s.
soon() {
  local expected=$1 last=$((SECONDS + 60)) text
  shift
  while true; do
    : >"$work/podman.log"
    if text=$("$@") && text+=$(<"$work/podman.log") && [[ $text == *"$expected"* ]]; then return; fi
    ((SECONDS < last)) || fail "$* shows no '$expected': $text $(<"$work/podman.log")"
  done
}

compgen -G "$packages/*.deb" >/dev/null || "$root/deploy/package.sh" >/dev/null
mapfile -t images < <("$root/deploy/image.sh" --packages "$packages" --out "$work/first")
((${#images[@]} == 6)) || fail "expected six images: ${images[*]}"
again=$("$root/deploy/image.sh" --packages "$packages" --out "$work/second" bench)
cmp "${images[0]}" "$again" || fail "the same packages gave another image"

for image in "${images[@]}"; do
  name=$(basename "$image")
  layout=$work/layout/$name
  mkdir -p "$layout"
  tar --extract --file "$image" --directory "$layout"
  for blob in "$layout"/blobs/sha256/*; do
    [[ $(sha256sum <"$blob") == "$(basename "$blob")  -" ]] || fail "$name: $blob has another name"
  done
  # The layer is the largest blob; the configuration is the one with a user.
  layer=$(find "$layout/blobs" -type f -printf '%s %p\n' | sort -n | tail -n 1 | cut -d ' ' -f 2)
  tar --list --verbose --gzip --file "$layer" >"$work/list"
  shells=$(grep -E '/(ba|da|z|k|c|tc)?sh$|/(busybox|perl|python3?|dpkg|apt(-get)?)$' "$work/list" || true)
  [[ -z $shells ]] || fail "$name has a shell, an interpreter or a package manager: $shells"
  ! grep -qE '^...s|^......s' "$work/list" || fail "$name has a program with rights of its own"
  [[ $(grep -c '/bin/' "$work/list") == [234] ]] || fail "$name has programs that are not ours: $(grep /bin/ "$work/list")"
  grep -qh '"User":"65532:65532"' "$layout"/blobs/sha256/* || fail "$name runs as root"
  for label in version licenses base.name; do
    grep -qh "\"org.opencontainers.image.$label\":\"." "$layout"/blobs/sha256/* || fail "$name has no label $label"
  done
done
size=$(stat --format %s "${images[0]}")
((size <= 60000000)) || fail "the bench has $size bytes, more than 60 MB"

# An image that cannot be made is refused with a one-line message.
refused() {
  local expected=$1 text
  shift
  text=$("$root/deploy/image.sh" --out "$work/refused" "$@" 2>&1) && fail "$* was not refused"
  [[ ${text##*$'\n'} == "image: "*"$expected"* ]] || fail "$*: $text"
}
refused "run deploy/package.sh first" --packages "$work/nowhere"
refused "unknown argument 'benches'" benches
mkdir "$work/foreign" "$work/control" "$work/control/DEBIAN"
printf '%s\n' "Package: vdrived" "Version: 1" "Architecture: all" "Maintainer: none" \
  "Description: of another Debian" "Depends: libof-another-debian" >"$work/control/DEBIAN/control"
dpkg-deb --build "$work/control" "$work/foreign/vdrived_1_all.deb" >/dev/null
cp "$packages"/vdrive_*.deb "$work/foreign"
refused "are for this Debian" --packages "$work/foreign" bench

CONTAINERS_CONF=$(dirname "$(realpath "${BASH_SOURCE[0]}")")/containers.conf
export CONTAINERS_CONF
skip() {
  echo "check_images: the images are whole; podman runs no container here: $*"
  exit 0
}
command -v podman >/dev/null || skip "it is not installed (deploy/setup.sh --images)"
for image in "${images[@]}"; do
  podman load --quiet --input "$image" >/dev/null || skip "$(tail -n 1 "$work/podman.log")"
done
version=${images[0]##*/vdrive-bench_}
version=${version%%_*}
podman run --rm --read-only --network none "localhost/vdrive-bench:$version" --version >/dev/null ||
  skip "$(tail -n 1 "$work/podman.log")"

# Runs an image as a cluster would: without capabilities or writable files.
start() {
  containers+=("$1")
  podman run --detach --name "$1" --read-only --read-only-tmpfs=false --cap-drop all \
    --security-opt no-new-privileges "${@:2}" >/dev/null || fail "$(tail -n 1 "$work/podman.log")"
}
# Prints the message of a container that cannot run.
says() {
  : >"$work/podman.log"
  ! podman run --rm --read-only --network none "$@" >"$work/said" || fail "$*: runs without its settings"
  cat "$work/said" "$work/podman.log"
}
expect_line() {
  local text
  text=$(says "${@:2}")
  [[ $text == *"$1"* && $(wc -l <<<"$text") == 1 ]] || fail "${*:2}: $text"
}
expect_line "/etc/vdrive/vdrived.yaml: cannot be read" "localhost/vdrive-bench:$version"
expect_line "identity_ca.pem: cannot be read" --env VDRIVE_SECURITY=/etc/vdrive/security \
  "localhost/vdrive-bench:$version" --axes 2
expect_line "cannot read '/etc/vdrive/token'" "localhost/vdrive-gateway:$version"
expect_line "/etc/vdrive/canopen.yaml" "localhost/vdrive-canopen:$version"

# A bench with a configuration, the bridges next to it as in one pod, and the health of each.
echo "axes: [{number: 1, name: lift}]" >"$work/vdrived.yaml"
echo "0123456789abcdef" >"$work/token"
start bench --network none --volume "$work/vdrived.yaml:/etc/vdrive/vdrived.yaml:ro" \
  --volume state:/var/lib/vdrive --health-cmd '["/usr/bin/vdrive","status"]' --health-interval disable \
  "localhost/vdrive-bench:$version" --config /etc/vdrive/vdrived.yaml --state /var/lib/vdrive/bench
soon "" podman healthcheck run bench
soon "lift" podman exec bench /usr/bin/vdrive list
podman exec bench /usr/bin/vdrive store lift >/dev/null || fail "$(tail -n 1 "$work/podman.log")"
! podman exec bench /bin/sh -c true || fail "the bench has a shell"
start gateway --network container:bench --volume "$work/token:/etc/vdrive/token:ro" "localhost/vdrive-gateway:$version"
start canopen --network container:bench "localhost/vdrive-canopen:$version" --bench 1
start ros2 --network container:bench "localhost/vdrive-ros2:$version"
doctor=(podman exec bench /usr/bin/vdrive doctor)
soon "vdrive-gateway answers on http://127.0.0.1:8765" "${doctor[@]}"
soon "socketcand 127.0.0.1:29536" podman logs canopen
soon "ROS 2: vdrive-ros2" "${doctor[@]}"
before=$SECONDS
podman stop --time 20 ros2 canopen gateway bench >/dev/null
((SECONDS - before < 20)) || fail "the containers do not end by SIGTERM"
[[ $(podman inspect --format '{{.State.ExitCode}}' bench gateway) == $'0\n0' ]] || fail "bench or gateway did not end in order"

# The demo, accessed from outside.
start demo --publish 127.0.0.1::8765 "localhost/vdrive-demo:$version"
soon "open http://127.0.0.1:8765/?token=" podman logs demo
page=$(podman port demo 8765/tcp)
soon "<html" curl --silent --fail "http://$page/"
soon "" podman exec demo /usr/bin/vdrive wait 1.1 position '>' 7000
podman stop --time 20 demo >/dev/null
