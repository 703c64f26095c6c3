#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the packages as a user does, in a clean root of this Debian: a signed repository, the demo
# from it, an upgrade, the README's commands, a purge that leaves nothing behind.
#
#   tests/deploy/check_repository.sh
#
# The packages are those of build/packages (deploy/package.sh). Fetches the root (debootstrap) and
# the dependencies of the packages from Debian's mirror. Without root or debootstrap: exit code 77,
# skipped.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

fail() {
  echo "check_repository: $*" >&2
  exit 1
}

# Runs everything in a namespace for mounts and processes, so its mounts and processes end with it.
if [[ ${1:-} != --inside ]]; then
  if ((EUID != 0)) || ! command -v debootstrap >/dev/null; then
    echo "check_repository: skipped, needs root and debootstrap" >&2
    exit 77
  fi
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  chmod 755 "$work" # apt reads as its own user
  # A domain reserved for this test as long as this shell keeps the pipe.
  coproc domain { exec python3 -B "$root/tests/support/test_domain.py"; }
  read -r number <&"${domain[0]}"
  VDRIVE_DOMAIN=$number unshare --mount --pid --fork --kill-child "${BASH_SOURCE[0]}" --inside "$work"
  exit
fi

work=$2
clean=$work/root
# shellcheck source=/dev/null
. /etc/os-release
declare -A other=([12]=13 [13]=12) dds=([12]=libfastrtps2.9 [13]=libfastdds3.1)
shopt -s nullglob
packages=("$root"/build/packages/*"~deb${VERSION_ID}_"*.deb)
((${#packages[@]} == 8)) || fail "expected eight packages of Debian $VERSION_ID in build/packages, deploy/package.sh makes them: ${packages[*]}"
current=$(dpkg-deb --field "${packages[0]}" Version)
file_of() {
  echo "$root/build/packages/$1_$current"_*.deb
}

# repack DEB SED-SCRIPT: repacks the package with an edited control file.
repack() {
  dpkg-deb --raw-extract "$1" "$work/repacked"
  sed -i "$2" "$work/repacked/DEBIAN/control"
  dpkg-deb --root-owner-group -Znone --build "$work/repacked" "$work" >/dev/null
  rm -r "$work/repacked"
}
repack "$(file_of vdrived)" "s/^Version: .*/Version: 0.0.1-1~deb${VERSION_ID}/"
repack "$(file_of vdrived)" "s/^\(Version: .*~deb\).*/\1${other[$VERSION_ID]}/; s/${dds[$VERSION_ID]} /${dds[${other[$VERSION_ID]}]} /"
before=$(echo "$work"/vdrived_0.0.1-*.deb)
of_other=$(echo "$work"/*"~deb${other[$VERSION_ID]}_"*.deb)

# A refused package leaves the repository unchanged.
repository=$root/deploy/repository.sh
refused() {
  local expected=$1
  shift
  "$@" >"$work/log" 2>&1 && fail "not refused: $*"
  grep -q -- "$expected" "$work/log" || fail "'$expected' is not what $* says: $(cat "$work/log")"
}
export GNUPGHOME=$work/gnupg
mkdir --mode=700 "$GNUPGHOME"
gpg --batch --quiet --passphrase '' --quick-generate-key 'Lab <lab@example.org>' ed25519 sign never 2>"$work/log" ||
  fail "$(cat "$work/log")"
refused "no signing key is given" "$repository" "$work/debs"
refused "gpg has no secret key 'nobody'" "$repository" "$work/debs" --key nobody "$before"
refused "/bin/sh is not a Debian package" "$repository" "$work/debs" --key lab@example.org /bin/sh
repack "$before" 's/~deb.*//'
refused "neither of Debian 12 .* nor of Debian 13" "$repository" "$work/debs" --key lab@example.org "$work"/vdrived_0.0.1-1_*.deb
mkdir "$work/small"
mount -t tmpfs -o size=16m none "$work/small"
"$repository" "$work/small/debs" --key lab@example.org "$(file_of vdrive-doc)" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
sums() {
  find "$work/small/debs" -type f -exec sha256sum {} + | sort
}
sums >"$work/sums"
head -c 16m /dev/zero >"$work/small/full" 2>/dev/null || true
refused "No space left on device" "$repository" "$work/small/debs" --key lab@example.org "$before"
sums | cmp --silent - "$work/sums" || fail "a full disk changes the repository"

debootstrap --variant=minbase "$VERSION_CODENAME" "$clean" >"$work/log" 2>&1 || fail "$(tail "$work/log")"
mount -t proc proc "$clean/proc"
mount -t tmpfs none "$clean/dev/shm"
in_root() {
  chroot "$clean" /usr/bin/env -i PATH="$PATH" HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    VDRIVE_DOMAIN="$VDRIVE_DOMAIN" "$@" </dev/null >"$work/log" 2>&1
}
version_of() {
  chroot "$clean" dpkg-query --show --showformat='${Version}' "$1"
}

# The demo from a repository with an earlier version; without the key it installs nothing.
mkdir -p "$clean/tree/deploy" "$clean/repository"
cp "$root"/deploy/{demo,apt}.sh "$clean/tree/deploy/"
others=()
for package in "${packages[@]}"; do
  [[ $package == "$(file_of vdrived)" ]] || others+=("$package")
done
"$repository" "$clean/repository" --key lab@example.org "$before" "${others[@]}" "$of_other" >"$work/log" 2>&1 ||
  fail "$(cat "$work/log")"
mv "$clean/repository/vdrive.asc" "$work/"
refused "no key at file:/repository/vdrive.asc" in_root /tree/deploy/demo.sh --packages file:/repository
mv "$work/vdrive.asc" "$clean/repository/"
in_root /tree/deploy/demo.sh --packages file:/repository || fail "$(cat "$work/log")"
[[ $(grep -c '^passed  absolute' "$work/log") == 2 ]] || fail "two examples pass: $(cat "$work/log")"
[[ $(version_of vdrived) == 0.0.1-* ]] || fail "vdrived is $(version_of vdrived)"
cp "$of_other" "$clean/tree/"
refused "vdrived : Depends: ${dds[${other[$VERSION_ID]}]} .* but it is not installable" \
  in_root apt-get install --yes "/tree/$(basename "$of_other")"

# An upgrade keeps the user's changes.
echo "# of the user" >>"$clean/etc/vdrive/vdrived.yaml"
"$repository" "$clean/repository" --key lab@example.org "$(file_of vdrived)" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
in_root apt-get update || fail "$(cat "$work/log")"
in_root apt-get upgrade --yes || fail "$(cat "$work/log")"
[[ $(version_of vdrived) == "$current" ]] || fail "upgraded to $(version_of vdrived), not to $current"
grep -q "# of the user" "$clean/etc/vdrive/vdrived.yaml" || fail "the upgrade has overwritten the configuration"

# The README's commands after those of the installation.
sed -n '/^## Twelve lines/,/^## [^T]/p' "$root/README.md" | sed -n '/^vdrived &/,/^```/{/^```/d;p}' |
  sed 's|clients/scenarios|/usr/share/vdrive/scenarios|' >"$work/lines"
(($(wc -l <"$work/lines") == 10)) || fail "the README has $(wc -l <"$work/lines") lines for an installed vdrive, not ten"
cat >"$clean/tree/follow.sh" <<'END'
mapfile -t lines
for line in "${lines[@]}"; do
  echo "$ $line"
  code=0
  eval "$line" || code=$?
  expected=0
  [[ $line != *"ends in fault"* ]] || expected=$code
  ((code == expected)) && { ((code)) || [[ $line != *"ends in fault"* ]]; } || exit 1
done
kill %1
wait
END
chroot "$clean" /usr/bin/env VDRIVE_DOMAIN="$VDRIVE_DOMAIN" bash /tree/follow.sh <"$work/lines" >"$work/log" 2>&1 ||
  fail "the README's lines: $(cat "$work/log")"

# A purge leaves nothing behind, not even directories made by systemd for the services.
mkdir -p "$clean/var/lib/private/vdrive" "$clean/etc/systemd/system/multi-user.target.wants"
ln -s private/vdrive "$clean/var/lib/vdrive"
ln -s /lib/systemd/system/vdrived.service "$clean/etc/systemd/system/multi-user.target.wants/"
in_root apt-get install --yes --no-install-recommends vdrive-gateway vdrive-ros2 vdrive-canopen libvdrive-dev \
  python3-vdrive vdrive-doc || fail "$(cat "$work/log")"
in_root apt-get purge --yes --autoremove '?name(vdrive)' || fail "$(cat "$work/log")"
rm -r "$clean/tree" "$clean/repository" "$clean/etc/apt/sources.list.d/vdrive.list" "$clean/etc/apt/keyrings/vdrive.asc"
in_root apt-get update
left=$(find "$clean" -xdev -name '*vdrive*' -not -path "$clean/var/cache/apt/*")
[[ -z $left ]] || fail "a purge leaves $left"
