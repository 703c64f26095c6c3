#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Puts packages into a signed apt repository: a folder that any static web server can serve.
#
#   deploy/repository.sh DIR --key KEYID [DEB...]
#
#   --key KEYID   the gpg key that signs: a fingerprint, or the e-mail address of its user
#   DEB           packages of deploy/package.sh, default build/packages/*.deb
#
# Creates DIR, or adds the packages to those in it. Packages for Debian 12 are in the suite
# bookworm, those for Debian 13 in trixie. DIR/vdrive.asc is the public key; DIR/README.txt has the
# commands for users, which are also printed. A failure leaves DIR unchanged. Needs gpg.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
readonly maintainer="vdrive maintainers <maintainers@vdrive.invalid>" # as in VdrivePackages.cmake
readonly usage="usage: deploy/repository.sh DIR --key KEYID [DEB...]"
declare -A suites=([12]=bookworm [13]=trixie)
directory=
key=
debs=()

fail() {
  echo "repository: $*" >&2
  exit 1
}

while (($#)); do
  case $1 in
    --key)
      (($# >= 2)) || fail "--key needs the id of a key; $usage"
      key=$2 && shift
      ;;
    -*) fail "unknown option '$1'; $usage" ;;
    *) if [[ -z $directory ]]; then directory=$1; else debs+=("$1"); fi ;;
  esac
  shift
done
[[ -n $directory ]] || fail "the folder of the repository is missing; $usage"
[[ -n $key ]] || fail "no signing key is given (--key KEYID), and apt refuses an unsigned repository; 'gpg --list-secret-keys' lists yours, 'gpg --quick-generate-key NAME' creates one"
command -v gpg >/dev/null || fail "needs gpg, of the package gnupg"
gpg --batch --list-secret-keys -- "$key" >/dev/null 2>&1 || fail "gpg has no secret key '$key'; 'gpg --list-secret-keys' lists yours"
if ((${#debs[@]} == 0)); then
  debs=("$root"/build/packages/*.deb)
  [[ -f ${debs[0]} ]] || fail "no packages in $root/build/packages; deploy/package.sh makes them"
fi

# Prints the suite of one of our packages.
suite_of() {
  local version
  [[ -f $1 ]] || fail "$1: no such file"
  version=$(dpkg-deb --field "$1" Version 2>/dev/null) || fail "$1 is not a Debian package"
  [[ $(dpkg-deb --field "$1" Maintainer) == "$maintainer" ]] || fail "$1 is not a package of deploy/package.sh"
  if [[ ! $version =~ ~deb([0-9]+)$ || -z ${suites[${BASH_REMATCH[1]}]:-} ]]; then
    fail "$1: version $version is neither of Debian 12 (...~deb12) nor of Debian 13 (...~deb13)"
  fi
  echo "${suites[${BASH_REMATCH[1]}]}"
}

for deb in "${debs[@]}"; do
  suite_of "$deb" >/dev/null
  # Users who have this version would never get the changed package.
  kept=$directory/pool/$(basename "$deb")
  [[ ! -e $kept ]] || cmp --silent "$deb" "$kept" ||
    fail "$kept already exists with different contents: a changed package needs a new version"
done

# Everything is written to a temporary folder and renamed when it is complete.
umask 022 # the web server has to read the files
mkdir -p "$directory"
directory=$(realpath "$directory")
new=$(mktemp -d "$directory/.new.XXXXXX")
clean_up() {
  local code=$?
  rm -rf "$new"
  ((code == 0)) || echo "repository: nothing was published; $directory is unchanged" >&2
}
trap clean_up EXIT
mkdir -p "$new/pool" "$directory/pool"
for deb in "${debs[@]}"; do
  [[ -e $directory/pool/$(basename "$deb") ]] || cp "$deb" "$new/pool/"
done

shopt -s nullglob
for deb in "$directory"/pool/*.deb "$new"/pool/*.deb; do
  suite=$(suite_of "$deb")
  entry=$(
    dpkg-deb --field "$deb" | sed '/^$/d' # CPack's output ends with an empty line
    printf 'Filename: pool/%s\nSize: %d\n' "$(basename "$deb")" "$(stat -c %s "$deb")"
    sum=$(sha256sum <"$deb")
    printf 'SHA256: %s\n' "${sum%% *}"
  )
  architecture=$(dpkg-deb --field "$deb" Architecture)
  mkdir -p "$new/dists/$suite/main"
  printf '%s\n\n' "$entry" >>"$new/dists/$suite/main/$architecture"
done

for suite in "$new"/dists/*; do
  cd "$suite"
  # Packages for all architectures are listed with each.
  all=
  if [[ -e main/all ]]; then
    all=$(<main/all)$'\n\n'
    rm main/all
    touch "main/$(dpkg --print-architecture)"
  fi
  architectures=(main/*)
  architectures=("${architectures[@]#main/}")
  for architecture in "${architectures[@]}"; do
    mkdir "main/binary-$architecture"
    { cat "main/$architecture" && printf '%s' "$all"; } >"main/binary-$architecture/Packages"
    rm "main/$architecture"
  done
  {
    printf 'Origin: vdrive\nLabel: vdrive\nSuite: %s\nCodename: %s\n' "${suite##*/}" "${suite##*/}"
    LC_ALL=C date -u '+Date: %a, %d %b %Y %H:%M:%S UTC'
    printf 'Architectures: %s\nComponents: main\nSHA256:\n' "${architectures[*]}"
    for index in main/binary-*/Packages; do
      sum=$(sha256sum <"$index")
      printf ' %s %d %s\n' "${sum%% *}" "$(stat -c %s "$index")" "$index"
    done
  } >Release
  gpg --batch --quiet --local-user "$key" --clearsign --output InRelease Release
  rm Release
  cd - >/dev/null
done
gpg --batch --armor --export --output "$new/vdrive.asc" -- "$key"
cat >"$new/README.txt" <<'END'
Repository of vdrive, for Debian 12 and 13. Where this folder is https://apt.example.org/vdrive:

  sudo /usr/lib/apt/apt-helper download-file https://apt.example.org/vdrive/vdrive.asc /etc/apt/keyrings/vdrive.asc
  echo "deb [signed-by=/etc/apt/keyrings/vdrive.asc] https://apt.example.org/vdrive $(. /etc/os-release; echo $VERSION_CODENAME) main" | sudo tee /etc/apt/sources.list.d/vdrive.list
  sudo apt update && sudo apt install vdrive
END

for deb in "$new"/pool/*.deb; do
  mv "$deb" "$directory/pool/"
done
[[ ! -e $directory/dists ]] || mv "$directory/dists" "$new/old"
mv "$new/dists" "$new/vdrive.asc" "$new/README.txt" "$directory/"
cat "$directory/README.txt"
