#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes OCI images from the Debian packages.
#
#   deploy/image.sh [--packages DIR] [--out DIR] [bench|gateway|canopen|ros2|discovery|demo ...]
#
#   --packages DIR   folder of the packages from deploy/package.sh; default build/packages
#   --out DIR        folder for the images; default build/images
#
# Without names, makes all images. Each is a file that `podman load -i FILE` loads as
# localhost/vdrive-NAME:VERSION. An image contains the programs of its packages, the libraries that
# the loader finds for them in Debian's packages, and nothing else: no shell and no package manager.
# The maintainer scripts of the packages are not run: they handle users, units and caches, which no
# program in an image uses. The same packages give the same image: dates are those of the package of
# the tool.
#
# Needs apt with the package lists of the Debian for which the packages were built, but not root.
# Prints the names of the files.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
packages=$root/build/packages
out=$root/build/images
names=()
usage="usage: deploy/image.sh [--packages DIR] [--out DIR] [bench|gateway|canopen|ros2|discovery|demo ...]"
readonly user=65532 # otherwise unused, and common in images that run without root

fail() {
  echo "image: $*" >&2
  exit 1
}

while (($#)); do
  case $1 in
    --packages | --out) (($# >= 2)) || fail "$1 needs a folder; $usage" ;;&
    --packages) packages=$2 && shift ;;
    --out) out=$2 && shift ;;
    bench | gateway | canopen | ros2 | discovery | demo) names+=("$1") ;;
    *) fail "unknown argument '$1'; $usage" ;;
  esac
  shift
done
((${#names[@]})) || names=(bench gateway canopen ros2 discovery demo)

# The tool is in each image, to check whether the program of the image works.
declare -A packages_of=([bench]="vdrived vdrive" [gateway]="vdrive-gateway vdrive"
  [canopen]="vdrive-canopen vdrive" [ros2]="vdrive-ros2 vdrive"
  [discovery]="vdrive" [demo]="vdrived vdrive-gateway vdrive")
# Programs from packages of Debian, with our own configuration file.
declare -A debian_of=([discovery]="fastdds-tools") program_of=([discovery]=/usr/bin/fast-discovery-server)
declare -A settings_of=([discovery]=deploy/network/discovery-server.xml)
declare -A title_of=([bench]="a bench of virtual servo drives"
  [gateway]="the gateway of virtual servo drives to browsers and dashboards"
  [canopen]="the bridge of virtual servo drives to CANopen"
  [ros2]="the bridge of virtual servo drives to ROS 2"
  [discovery]="a discovery server, through which virtual servo drives and their clients find each other"
  [demo]="virtual servo drives that move, and a page that shows them")
declare -A entry_of=([bench]='"/usr/bin/vdrived"' [gateway]='"/usr/bin/vdrive-gateway"'
  [canopen]='"/usr/bin/vdrive-canopen"' [ros2]='"/usr/bin/vdrive-ros2"'
  [discovery]='"/usr/bin/fast-discovery-server"'
  [demo]='"/usr/bin/vdrive","demo"')
# Default arguments, which the arguments of a container replace.
declare -A command_of=([bench]='"--config","/etc/vdrive/vdrived.yaml"'
  [gateway]='"--listen","0.0.0.0:8765","--token","/etc/vdrive/token"'
  [canopen]='"--config","/etc/vdrive/canopen.yaml"' [ros2]=''
  [discovery]='"--xml-file","/etc/vdrive/discovery-server.xml","--server-id","0","--port","11811"'
  [demo]='"--listen","0.0.0.0:8765"')

[[ -d $packages ]] || fail "no folder '$packages': run deploy/package.sh first"
packages=$(realpath "$packages")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Prints the file of our package $1.
package() {
  local found=("$packages/$1"_*.deb)
  [[ -f ${found[0]} ]] || fail "no package $1 in '$packages': run deploy/package.sh first"
  ((${#found[@]} == 1)) || fail "more than one package $1 in '$packages': ${found[*]##*/}"
  printf '%s\n' "${found[0]}"
}

declare -A files=()
debian=()
for name in "${names[@]}"; do
  debian+=(${debian_of[$name]:+"${debian_of[$name]}"})
  for each in ${packages_of[$name]}; do
    files[$each]=$(package "$each")
  done
done
tool=${files[vdrive]}
version=$(dpkg-deb --field "$tool" Version)
version=${version%%-*} # without the Debian revision, whose ~ is not allowed in a tag
architecture=$(dpkg-deb --field "$tool" Architecture)
date=$(dpkg-deb --fsys-tarfile "$tool" | tar --list --verbose --full-time --utc |
  awk '{ print $4, $5 }' | sort | tail -n 1)
epoch=$(date --utc --date "$date" +%s)
created=$(date --utc --date "$date" +%Y-%m-%dT%H:%M:%SZ)

# Downloads all packages that ours depend on, as if none were installed.
mkdir -p "$work/debian/partial" "$work/tree"
touch "$work/status"
if ! apt-get --quiet --yes --no-install-recommends --download-only \
  --option Dir::State::status="$work/status" --option Dir::Cache::archives="$work/debian/" \
  --option Debug::NoLocking=1 --option APT::Sandbox::User= --option Acquire::Retries=3 \
  install base-files "${debian[@]}" "${files[@]}" >"$work/apt" 2>&1; then
  cat "$work/apt" >&2
  fail "apt cannot download the dependencies of the packages: check that they are for this Debian, and run apt-get update"
fi
for each in "$work"/debian/*.deb; do
  dpkg-deb --vextract "$each" "$work/tree" | sed "s|^\./|/|; s|\$| $each|" >>"$work/index"
done

loader=$(find "$work/tree" -name 'ld-linux*.so.*' -type f -print -quit)
[[ -n $loader ]] || fail "the packages depend on no C library"
c_library=$(find "$work/tree" -name libc.so.6 -print -quit)
folders=lib/$(basename "$(dirname "$c_library")")
folders=$work/tree/usr/$folders:$work/tree/$folders

# Copies the libraries of program $2 into image $1, each with the record of its package, and the
# loader to the path that the program expects.
add_libraries() {
  local image=$1 program=$2 listed name file place each
  listed=$("$loader" --inhibit-cache --library-path "$folders" --list "$program" 2>&1) ||
    fail "$(basename "$program"): $listed"
  while read -r name file; do
    [[ $file == "$work/tree"/* ]] || fail "$(basename "$program"): $name is not in any package"
    place=${file#"$work/tree"}
    each=$(awk -v place="$place" '$1 == place { print $2; exit }' "$work/index")
    [[ $name != /* ]] || place=$name
    [[ ! -e $image$place ]] || continue
    install -D --mode 755 "$file" "$image$place"
    add_origin "$image" "$each"
  done < <(sed -n 's/^\t\([^ ]*\) => \([^ ]*\).*$/\1 \2/p' <<<"$listed")
}

# Adds the licence of a package, and its record in the place where image scanners look for it.
add_origin() {
  local image=$1 file=$2 name licence
  name=$(dpkg-deb --field "$file" Package)
  mkdir -p "$image/var/lib/dpkg/status.d"
  dpkg-deb --field "$file" >"$image/var/lib/dpkg/status.d/$name"
  licence=usr/share/doc/$name/copyright
  [[ -e $image/$licence ]] || install -D --mode 644 "$work/tree/$licence" "$image/$licence"
}

make_tree() {
  local image=$1 name=$2 each program
  mkdir -p "$image/etc/vdrive" "$image/tmp" "$image/var/lib/vdrive"
  for each in ${packages_of[$name]}; do
    dpkg-deb --extract "${files[$each]}" "$image"
    add_origin "$image" "${files[$each]}"
  done
  if [[ -n ${program_of[$name]:-} ]]; then
    install -D --mode 755 "$work/tree${program_of[$name]}" "$image${program_of[$name]}"
    add_origin "$image" "$(find "$work/debian" -name "${debian_of[$name]}_*.deb")"
    install --mode 644 "$root/${settings_of[$name]}" "$image/etc/vdrive/"
  fi
  rm -rf "$image"/usr/{lib/systemd,share/man,share/bash-completion,share/zsh,share/fish}
  # Without the default configuration, a container that nobody has configured fails with a message.
  rm -f "$image/etc/vdrive/vdrived.yaml"
  find "$image/usr/share/doc" ! -type d ! -name copyright -delete
  for program in "$image"/usr/bin/*; do
    add_libraries "$image" "$program"
  done
  install --mode 644 "$work/tree/usr/lib/os-release" "$image/etc/os-release" # for the same scanners
  echo "vdrive:x:$user:$user:vdrive:/var/lib/vdrive:/" >"$image/etc/passwd"
  echo "vdrive:x:$user:" >"$image/etc/group"
  chmod -R u=rwX,go=rX "$image"
  # Writable for whichever user a cluster chooses, if the root is not read-only.
  chmod 1777 "$image/tmp" "$image/var/lib/vdrive"
}

# Moves a file to the blobs of a layout. Prints its OCI descriptor (JSON) without the closing brace,
# so that the caller can add members.
add_blob() {
  local layout=$1 file=$2 type=$3 sum
  sum=$(sha256sum "$file" | cut -d ' ' -f 1)
  printf '{"mediaType":"application/vnd.oci.image.%s","digest":"sha256:%s","size":%d' \
    "$type" "$sum" "$(stat --format %s "$file")"
  mv "$file" "$layout/blobs/sha256/$sum"
}

# Writes a tar archive that depends only on names, contents and modes.
pack() {
  tar --create --directory "$1" --sort name --format gnu --mtime "@$epoch" --owner 0 --group 0 \
    --numeric-owner .
}

make_image() {
  local name=$1 image=$work/$1 layout=$work/$1.layout
  local layer config manifest sum revision
  mkdir -p "$image" "$layout/blobs/sha256"
  make_tree "$image" "$name"
  revision=$("$loader" --library-path "$folders" "$image/usr/bin/vdrive" --version | sed -n 's/^.*(commit \([0-9a-f]*\),.*/\1/p')
  pack "$image" >"$work/layer"
  sum=$(sha256sum "$work/layer" | cut -d ' ' -f 1)
  gzip --no-name "$work/layer"
  layer=$(add_blob "$layout" "$work/layer.gz" layer.v1.tar+gzip)
  cat >"$work/config" <<END
{"created":"$created","architecture":"$architecture","os":"linux","config":{"User":"$user:$user",
"Env":["PATH=/usr/bin"],"Entrypoint":[${entry_of[$name]}],"Cmd":[${command_of[$name]}],"WorkingDir":"/",
"Labels":{"org.opencontainers.image.title":"vdrive-$name",
"org.opencontainers.image.description":"${title_of[$name]}",
"org.opencontainers.image.version":"$version","org.opencontainers.image.revision":"$revision",
"org.opencontainers.image.created":"$created","org.opencontainers.image.licenses":"Apache-2.0",
"org.opencontainers.image.base.name":"scratch"}},
"rootfs":{"type":"layers","diff_ids":["sha256:$sum"]},
"history":[{"created":"$created","created_by":"deploy/image.sh $name"}]}
END
  config=$(add_blob "$layout" "$work/config" config.v1+json)
  printf '{"schemaVersion":2,"mediaType":"application/vnd.oci.image.manifest.v1+json","config":%s},"layers":[%s}]}' \
    "$config" "$layer" >"$work/manifest"
  manifest=$(add_blob "$layout" "$work/manifest" manifest.v1+json)
  printf '{"schemaVersion":2,"manifests":[%s,"annotations":{"org.opencontainers.image.ref.name":"localhost/vdrive-%s:%s"}}]}' \
    "$manifest" "$name" "$version" >"$layout/index.json"
  printf '{"imageLayoutVersion":"1.0.0"}' >"$layout/oci-layout"
  pack "$layout" >"$out/vdrive-${name}_${version}_$architecture.tar"
  rm -rf "$image" "$layout"
  echo "$out/vdrive-${name}_${version}_$architecture.tar"
}

mkdir -p "$out"
for name in "${names[@]}"; do
  make_image "$name"
done
