#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the security directory of one member of a closed network: certificate, key, permissions.
#
#   deploy/security/make_member.sh DIR ROLE NAME [--days N] [--from TIME] [--to TIME]
#
#   DIR       directory of make_authority.sh; the member gets DIR/members/NAME
#   ROLE      service     vdrived: serves benches
#             controller  clients that command: vdrive, vdrive::client
#             viewer      clients that see everything and command nothing
#   NAME      letters, digits, '.', '_' and '-'
#   --days N  validity of certificate and permissions from now on, default 365
#   --from T, --to T   the start and end of validity instead, in UTC, such as 2026-01-31T00:00:00
#
# Move the directory to its host and give it to `vdrived --security` or `vdrive --security`; the
# authority stays where it is. An existing member is not replaced: remove its directory first.
set -euo pipefail
umask 077

usage="usage: make_member.sh DIR ROLE NAME [--days N] [--from TIME] [--to TIME]"
fail() {
  echo "make_member: $*" >&2
  exit 1
}

words=()
days=365
from=
to=
while (($#)); do
  case $1 in
    --days | --from | --to)
      (($# > 1)) || fail "$1 needs a value"
      declare "${1#--}=$2"
      shift
      ;;
    -*) fail "unknown option '$1'; $usage" ;;
    *) words+=("$1") ;;
  esac
  shift
done
((${#words[@]} == 3)) || fail "$usage"
directory=${words[0]} role=${words[1]} name=${words[2]}
[[ $role =~ ^(service|controller|viewer)$ ]] ||
  fail "role '$role': must be service, controller or viewer"
[[ $name =~ ^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$ ]] ||
  fail "name '$name': must be 1 to 63 letters, digits, '.', '_' or '-'"
[[ $days =~ ^[1-9][0-9]{0,4}$ ]] || fail "--days '$days': must be from 1 to 99999"
instant='^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}$'
from=${from:-$(date --utc +%FT%T)}
to=${to:-$(date --utc --date "+$days days" +%FT%T)}
[[ $from =~ $instant ]] || fail "--from '$from': must have the form 2026-01-31T00:00:00 (UTC)"
[[ $to =~ $instant ]] || fail "--to '$to': must have the form 2026-01-31T00:00:00 (UTC)"
[[ -r $directory/identity_ca_key.pem && -r $directory/permissions_ca_key.pem ]] ||
  fail "$directory contains no authority, or you may not read its keys; make_authority.sh creates an authority"

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
directory=$(cd "$directory" && pwd)
member=$directory/members/$name
[[ ! -e $member ]] || fail "$member already exists; remove it first to replace the member"
mkdir -p "$directory/members"
work=$(mktemp --directory "$directory/members/.$name.XXXXXX")
trap 'rm -rf "$work"' EXIT

run() {
  "$@" 2>"$work/log" || fail "$1: $(cat "$work/log")"
}

# Uses `openssl ca`, because no other command takes a start and an end date.
cat >"$work/ca.conf" <<END
[ca]
default_ca = identity
[identity]
database = $work/issued
new_certs_dir = $work
rand_serial = yes
default_md = sha256
policy = any
x509_extensions = leaf
unique_subject = no
email_in_dn = no
[any]
organizationName = supplied
organizationalUnitName = supplied
commonName = supplied
[leaf]
basicConstraints = critical,CA:FALSE
keyUsage = critical,digitalSignature
END
: >"$work/issued"
run openssl req -new -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -noenc \
  -subj "/O=vdrive/OU=$role/CN=$name" -keyout "$work/private_key.pem" -out "$work/request.pem"
compact() { # 2026-01-31T00:00:00 -> 20260131000000Z
  local digits=${1//[-:T]/}
  echo "${digits}Z"
}
run openssl ca -batch -notext -config "$work/ca.conf" -cert "$directory/identity_ca.pem" \
  -keyfile "$directory/identity_ca_key.pem" -startdate "$(compact "$from")" \
  -enddate "$(compact "$to")" -in "$work/request.pem" -out "$work/certificate.pem"
subject=$(openssl x509 -in "$work/certificate.pem" -noout -subject -nameopt RFC2253)

[[ -r $here/topics.txt ]] || fail "$here/topics.txt cannot be read"
section() { # publish or subscribe, the side that publishes these topics, one additional topic
  printf '        <%s>\n          <topics>\n' "$1"
  awk -v side="$2" -v more="${3-}" '$1 !~ /^#/ && ($2 == side || $1 == more) {
    print "            <topic>vdrive/v1/" $1 "</topic>" }' "$here/topics.txt"
  printf '          </topics>\n        </%s>\n' "$1"
}
case $role in
  # It also receives bench_state, to detect another service with its number.
  service) topics=$(section publish service && section subscribe client bench_state) ;;
  controller) topics=$(section publish client && section subscribe service) ;;
  viewer) topics=$(section subscribe service) ;;
esac
[[ $topics == *"<topic>"* ]] || fail "$here/topics.txt names no topic of a $role"
while IFS= read -r line; do
  if [[ $line == @TOPICS@ ]]; then echo "$topics"; else echo "$line"; fi
done <"$here/permissions.xml" |
  sed -e "s|@SUBJECT@|${subject#subject=}|; s|@NAME@|$name|" -e "s|@FROM@|$from|; s|@TO@|$to|" \
    >"$work/permissions.xml"
run openssl smime -sign -in "$work/permissions.xml" -text -out "$work/permissions.smime" \
  -signer "$directory/permissions_ca.pem" -inkey "$directory/permissions_ca_key.pem"

finished=$work/member
mkdir "$finished"
mv "$work"/{certificate.pem,private_key.pem,permissions.smime} "$finished"
cp "$directory"/{identity_ca.pem,permissions_ca.pem,governance.smime} "$finished"
chmod 644 "$finished"/*
chmod 600 "$finished/private_key.pem"
mv --no-target-directory "$finished" "$member"
echo "make_member: made $member, ${subject#subject=}, valid from $from to $to" >&2
