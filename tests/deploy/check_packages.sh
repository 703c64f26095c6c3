#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the Debian packages and checks them: their contents, that the programs run from where
# they are unpacked, that an external program builds against the library, that the programs are
# hardened, and that man pages and completion agree with the programs.
#
#   tests/deploy/check_packages.sh
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "check_packages: $*" >&2
  exit 1
}

list=$("$root/deploy/package.sh")
mapfile -t packages <<<"$list"
((${#packages[@]} == 8)) || fail "expected eight packages: ${packages[*]}"

unpacked=$work/root
for package in "${packages[@]}"; do
  dpkg-deb --extract "$package" "$unpacked"
done

expected=(
  etc/vdrive/vdrived.yaml
  usr/bin/vdrive
  usr/bin/vdrive-canopen
  usr/bin/vdrive-gateway
  usr/bin/vdrive-ros2
  usr/bin/vdrived
  usr/include/vdrive/bench/bench.hpp
  usr/include/vdrive/client/session.hpp
  usr/include/vdrive/dictionary/dictionary.hpp
  usr/lib/cmake/vdrive/vdriveConfig.cmake
  usr/lib/libvdrive_bench.a
  usr/lib/libvdrive_core.a
  usr/lib/libvdrive_dds.a
  usr/lib/libvdrive_sessions.a
  usr/lib/libvdrive_wire.a
  usr/lib/python3/dist-packages/vdrive-*.dist-info/entry_points.txt
  usr/lib/python3/dist-packages/vdrive/__init__.py
  usr/lib/python3/dist-packages/vdrive/_vdrive.cpython-*.so
  usr/lib/python3/dist-packages/vdrive/libvdrive_dds.so
  usr/lib/python3/dist-packages/vdrive/py.typed
  usr/lib/systemd/system/vdrive-canopen.service
  usr/lib/systemd/system/vdrive-gateway.service
  usr/lib/systemd/system/vdrive-ros2.service
  usr/lib/systemd/system/vdrived.service
  usr/lib/systemd/system/vdrived@.service
  usr/share/bash-completion/completions/vdrive
  usr/share/bash-completion/completions/vdrive-canopen
  usr/share/bash-completion/completions/vdrive-gateway
  usr/share/bash-completion/completions/vdrive-ros2
  usr/share/doc/libvdrive-dev/changelog.gz
  usr/share/doc/libvdrive-dev/copyright
  usr/share/doc/python3-vdrive/changelog.gz
  usr/share/doc/python3-vdrive/copyright
  usr/share/doc/vdrive-doc/README.md
  usr/share/doc/vdrive-doc/changelog.gz
  usr/share/doc/vdrive-doc/clients/examples/01_enable_and_move.cpp
  usr/share/doc/vdrive-doc/clients/examples/06_raw_dds/raw_dds.c
  usr/share/doc/vdrive-doc/clients/python/examples/two_joint_arm.py
  usr/share/doc/vdrive-doc/copyright
  usr/share/doc/vdrive-doc/docs/guides/configuration.md
  usr/share/doc/vdrive-doc/idl/vdrive_messages.idl
  usr/share/doc/vdrive-canopen/changelog.gz
  usr/share/doc/vdrive-canopen/copyright
  usr/share/doc/vdrive-gateway/changelog.gz
  usr/share/doc/vdrive-gateway/copyright
  usr/share/doc/vdrive-ros2/changelog.gz
  usr/share/doc/vdrive-ros2/copyright
  usr/share/doc/vdrive/changelog.gz
  usr/share/doc/vdrive/copyright
  usr/share/doc/vdrived/changelog.gz
  usr/share/doc/vdrived/copyright
  usr/share/fish/vendor_completions.d/vdrive.fish
  usr/share/man/man1/vdrive.1.gz
  usr/share/man/man5/vdrived.yaml.5.gz
  usr/share/man/man8/vdrive-canopen.8.gz
  usr/share/man/man8/vdrive-gateway.8.gz
  usr/share/man/man8/vdrive-ros2.8.gz
  usr/share/man/man8/vdrived.8.gz
  usr/share/vdrive/axes/ball-screw.yaml
  usr/share/vdrive/axes/conveyor.yaml
  usr/share/vdrive/axes/geared-elastic.yaml
  usr/share/vdrive/axes/habits/old-servo.yaml
  usr/share/vdrive/axes/habits/slow-brake.yaml
  usr/share/vdrive/axes/habits/stepper.yaml
  usr/share/vdrive/axes/linear-motor.yaml
  usr/share/vdrive/axes/nema23-belt.yaml
  usr/share/vdrive/axes/pick-and-place.yaml
  usr/share/vdrive/axes/rotary-table.yaml
  usr/share/vdrive/axes/scara-joint.yaml
  usr/share/vdrive/axes/vertical.yaml
  usr/share/vdrive/axes/winder.yaml
  usr/share/vdrive/realtime.conf
  usr/share/vdrive/scenarios/absolute_forward.scn
  usr/share/zsh/vendor-completions/_vdrive
)
for pattern in "${expected[@]}"; do
  compgen -G "$unpacked/$pattern" >/dev/null || fail "$pattern is in no package"
done
[[ ! -e $unpacked/usr/etc ]] || fail "configuration below /usr"

package_of() {
  local package
  for package in "${packages[@]}"; do
    [[ $(dpkg-deb --field "$package" Package) == "$1" ]] && echo "$package" && return
  done
  fail "no package $1"
}
version=$(dpkg-deb --field "${packages[0]}" Version)
# shellcheck source=/dev/null
[[ $version == *-1~deb$(. /etc/os-release && echo "$VERSION_ID") ]] || fail "version $version is of no Debian"
contents=$root/build/packages/vdrive_${version}_$(dpkg --print-architecture).spdx.json
"$root/tests/deploy/check_contents.py" "$contents" "${packages[@]}" >"$work/log" 2>&1 || fail "$contents: $(cat "$work/log")"

control() {
  dpkg-deb --field "$(package_of "$1")" "$2"
}
readonly dds="libfast(rtps|dds)" # of Debian 12, of Debian 13
[[ $(control vdrive Recommends) == vdrived ]] || fail "the tool brings no service"
[[ $(control vdrived Depends) =~ $dds ]] || fail "vdrived depends on no DDS"
[[ $(control vdrived Depends) == *libseccomp2* ]] || fail "vdrived depends on no filter of system calls"
[[ $(control libvdrive-dev Depends) == *libeigen3-dev* ]] || fail "libvdrive-dev needs Eigen"
[[ ! $(control libvdrive-dev Depends) =~ $dds ]] || fail "libvdrive-dev needs DDS for a program without DDS"
[[ $(control libvdrive-dev Recommends) =~ $dds-dev ]] || fail "libvdrive-dev recommends no DDS"
[[ $(control python3-vdrive Depends) == *python3-numpy* ]] || fail "python3-vdrive needs numpy"
[[ $(control python3-vdrive Depends) =~ $dds ]] || fail "python3-vdrive depends on no DDS"
dpkg-deb --ctrl-tarfile "$(package_of vdrived)" | tar -xO ./conffiles |
  grep -qx /etc/vdrive/vdrived.yaml || fail "the configuration would be overwritten"

# Documents named by a configuration or a unit are in a package; the news is about this version.
manuals() {
  { grep -o 'man [a-z][a-z0-9.-]*' "$unpacked"/etc/vdrive/*.yaml || true
    grep -oh 'man:[a-z0-9.-]*' "$unpacked"/usr/lib/systemd/system/*; } | sed 's/^.*man[ :]//; s/\.$//' | sort -u
}
[[ -n $(manuals) ]] || fail "neither configuration nor units name a manual page"
for page in $(manuals); do
  compgen -G "$unpacked/usr/share/man/man?/$page.?.gz" >/dev/null || fail "man $page is in no package"
done
if grep -rn 'docs/' "$unpacked/etc" "$unpacked/usr/lib/systemd"; then
  fail "the lines above name a document that no package installs there"
fi
for news in "$unpacked"/usr/share/doc/*/NEWS.gz; do
  zgrep -qi unreleased "$news" && fail "$news: a package is released"
  zgrep -q "^## ${version%-1~deb*}\b" "$news" ||
    fail "$news does not name the version of the package"
done

# Builds in two folders yield the same bytes only if no file contains the name of its folder.
if grep -rlF "$root" "$unpacked"; then
  fail "the files above name $root"
fi

# The programs run.
"$unpacked/usr/bin/vdrived" --check "$unpacked/etc/vdrive/vdrived.yaml" >"$work/check"
"$unpacked/usr/bin/vdrived" --version | grep -q '^vdrived ' || fail "vdrived --version"
"$unpacked/usr/bin/vdrive-gateway" --version | grep -q '^vdrive-gateway ' || fail "vdrive-gateway --version"
"$unpacked/usr/bin/vdrive-canopen" --version | grep -q '^vdrive-canopen ' || fail "vdrive-canopen --version"
"$unpacked/usr/bin/vdrive-ros2" --version | grep -q '^vdrive-ros2 ' || fail "vdrive-ros2 --version"
"$unpacked/usr/bin/vdrive" --version | grep -q '^vdrive ' || fail "vdrive --version"

# The Python module, on its own and with the packaged service.
PYTHONPATH=$unpacked/usr/lib/python3/dist-packages VDRIVE_SERVICE=$unpacked/usr/bin/vdrived /usr/bin/python3 -B \
  >"$work/log" 2>&1 <<'END' || fail "import vdrive: $(cat "$work/log")"
import vdrive
for over in ("local", "dds"):
    with vdrive.Bench(over=over) as bench, bench.session() as session:
        axis = session.axis("1.1")
        axis.enable()
        axis.move_to(1000)
        assert axis.status().position == 1000
END

# The units name existing files.
for unit in vdrived.service vdrived@.service vdrive-gateway.service vdrive-ros2.service vdrive-canopen.service; do
  program=$(sed -n 's/^ExecStart=\([^ ]*\).*/\1/p' "$unpacked/usr/lib/systemd/system/$unit")
  [[ -x $unpacked$program ]] || fail "$unit starts $program, which is in no package"
done
grep -q '^ExecStart=.*--config /etc/vdrive/%i.yaml$' "$unpacked/usr/lib/systemd/system/vdrived@.service" ||
  fail "each instance needs its own configuration"
grep -q '^StateDirectory=vdrive-%i$' "$unpacked/usr/lib/systemd/system/vdrived@.service" ||
  fail "each instance needs its own state"

# Position-independent code, read-only relocations bound at start, stack protector, fortified
# functions.
for file in "$unpacked"/usr/bin/* "$unpacked"/usr/lib/python3/dist-packages/vdrive/*.so; do
  program=$(basename "$file")
  readelf --file-header "$file" | grep -q 'Type:.*DYN' || fail "$program: no PIE"
  readelf --program-headers --wide "$file" | grep -q GNU_RELRO || fail "$program: no RELRO"
  readelf --dynamic "$file" | grep -q BIND_NOW || fail "$program: not bound at the start"
  symbols=$(readelf --dyn-syms --wide "$file")
  grep -q __stack_chk_fail <<<"$symbols" || fail "$program: no stack protector"
  # The part with DDS makes no copy that could be fortified, that is, to a buffer whose size the
  # compiler knows and the copy might exceed.
  [[ $program == libvdrive_dds.so ]] || grep -q '_chk@' <<<"$symbols" || fail "$program: no fortified functions"
  readelf --program-headers --wide "$file" | grep GNU_STACK | grep -q RWE && fail "$program: executable stack"
done

# Man pages without a warning, with every command and option of the programs.
options_of() {
  "$@" | grep -o -- '--[a-z][a-z-]*' | sort -u
}
for page in man1/vdrive.1.gz man8/vdrived.8.gz man8/vdrive-gateway.8.gz man8/vdrive-ros2.8.gz \
  man8/vdrive-canopen.8.gz; do
  text=$(LC_ALL=C.UTF-8 MANWIDTH=200 man --warnings --local-file "$unpacked/usr/share/man/$page" 2>"$work/warnings" | col -b)
  [[ ! -s $work/warnings ]] || fail "$page: $(cat "$work/warnings")"
  program=$unpacked/usr/bin/$(basename "${page%.?.gz}")
  # Between the group titles and the examples, each line begins with a command.
  words=$("$program" --help | sed -n '/^Benches and axes:/,/^Examples:/s/^  \([a-z][a-z-]*\) .*/\1/p')
  [[ $program != */vdrive || -n $words ]] || fail "the help of vdrive lists no command"
  for word in $words; do
    grep -qw -- "$word" <<<"$text" || fail "$page does not know $word"
    for option in $(options_of "$program" "$word" --help); do
      grep -q -- "$option" <<<"$text" || fail "$page does not know $option of $word"
    done
  done
  for option in $(options_of "$program" --help); do
    grep -q -- "$option" <<<"$text" || fail "$page does not know $option"
  done
done

declare -A completions=([bash]=bash-completion/completions/vdrive [zsh]=zsh/vendor-completions/_vdrive
  [fish]=fish/vendor_completions.d/vdrive.fish)
for shell in "${!completions[@]}"; do
  cmp --silent <("$unpacked/usr/bin/vdrive" completion "$shell") \
    "$unpacked/usr/share/${completions[$shell]}" || fail "the completion for $shell is of another build"
done

# An example, with the installed CMakeLists.txt next to it.
cmake -S "$unpacked/usr/share/doc/vdrive-doc/clients/examples" -B "$work/examples" -G Ninja \
  -DCMAKE_PREFIX_PATH="$unpacked/usr" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
cmake --build "$work/examples" --target 01_enable_and_move >"$work/log" 2>&1 || fail "$(cat "$work/log")"

# External programs, one for each component.
cmake -S "$root/tests/package/consumer" -B "$work/consumer" -G Ninja \
  -DCMAKE_PREFIX_PATH="$unpacked/usr" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
cmake --build "$work/consumer" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
ctest --test-dir "$work/consumer" --output-on-failure >"$work/log" 2>&1 || fail "$(cat "$work/log")"
