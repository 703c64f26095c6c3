#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the authority of a closed network: a CA that signs identities, another CA that signs
# permissions, and the signed rules of the domain.
#
#   deploy/security/make_authority.sh DIR [--days N]
#
#   DIR       new directory; do not keep it on hosts that run benches and clients
#   --days N  validity of both CAs, default 3650
#
# Safe to repeat: an existing authority is not changed. Next step: make_member.sh.
set -euo pipefail
umask 077

fail() {
  echo "make_authority: $*" >&2
  exit 1
}

directory=
days=3650
while (($#)); do
  case $1 in
    --days) days=${2-} && shift ;;
    -*) fail "unknown option '$1'; usage: make_authority.sh DIR [--days N]" ;;
    *) [[ -z $directory ]] || fail "more than one directory: '$1'" && directory=$1 ;;
  esac
  shift || fail "--days needs a number"
done
[[ -n $directory ]] || fail "usage: make_authority.sh DIR [--days N]"
[[ $days =~ ^[1-9][0-9]{0,4}$ ]] || fail "--days '$days': must be from 1 to 99999"

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if [[ -e $directory/governance.smime ]]; then
  echo "make_authority: $directory already contains an authority; nothing changed" >&2
  exit 0
fi
[[ ! -e $directory ]] || [[ -z $(ls -A "$directory") ]] ||
  fail "$directory is not empty and does not contain a complete authority"

# Built next to its place and moved there when complete, so that an interrupted run leaves no part
# of it.
mkdir -p "$(dirname "$directory")"
work=$(mktemp --directory "$(dirname "$directory")/.authority.XXXXXX")
trap 'rm -rf "$work"' EXIT

make_ca() { # name, subject
  openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -noenc -sha256 \
    -days "$days" -subj "$2" -addext basicConstraints=critical,CA:TRUE,pathlen:0 \
    -addext keyUsage=critical,digitalSignature,keyCertSign,cRLSign \
    -keyout "$work/$1_key.pem" -out "$work/$1.pem" 2>"$work/log" ||
    fail "openssl: $(cat "$work/log")"
}

number=$(openssl rand -hex 4) # tells authorities apart
make_ca identity_ca "/O=vdrive/CN=identity CA $number"
make_ca permissions_ca "/O=vdrive/CN=permissions CA $number"
openssl smime -sign -in "$here/governance.xml" -text -out "$work/governance.smime" \
  -signer "$work/permissions_ca.pem" -inkey "$work/permissions_ca_key.pem" 2>"$work/log" ||
  fail "openssl: $(cat "$work/log")"
rm "$work/log"
chmod 644 "$work"/identity_ca.pem "$work"/permissions_ca.pem "$work"/governance.smime
if [[ -d $directory ]]; then rmdir "$directory"; fi
mv --no-target-directory "$work" "$directory"
echo "make_authority: created $directory; keep its two *_key.pem secret: whoever has them can admit members" >&2
