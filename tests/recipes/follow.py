#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows the recipes of CONTRIBUTING.md in a copy of the tree.

follow.py [--check] DIRECTORY

Copies the tree to DIRECTORY/tree, makes a scratch object, status member, topic, operating mode and
fault there, builds in DIRECTORY/build and runs the tests that the recipes name. An edit may change
only files that its recipe names, and each path of a recipe exists: a recipe that forgets a place
fails. With --check nothing is built. Without VDRIVE_NIGHTLY=1 and --check it is skipped (exit code
77): it builds the core, the wire and their tests. A second run in DIRECTORY builds what has changed.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77
TARGETS = ["core_test", "wire_parts_test", "gateway_parts_test"]

OBJECT_TABLE = "core/include/vdrive/dictionary/object_table.hpp"
OPERATING_MODE = "core/include/vdrive/cia402/operating_mode.hpp"
MODE_TABLE = "core/src/drive/mode_table.cpp"
AXIS_STATUS = "core/include/vdrive/axis_status.hpp"
IDL = "idl/vdrive_messages.idl"
TOPICS = "idl/include/vdrive/wire/topics.hpp"
CORE_TESTS = "tests/core/CMakeLists.txt"
DICTIONARY_TEST = "tests/core/dictionary_test.cpp"

MODE_HEADER = """// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

extern const Mode kScratch;

}  // namespace vdrive
"""
MODE_SOURCE = """// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/scratch.hpp"

#include "drive/stops.hpp"

namespace vdrive {
namespace {

using namespace vdrive::literals;

MotionRequest ask(const Drive& drive) {
  return ramp_stop(drive, "profile_dec"_object);
}

}  // namespace

constinit const Mode kScratch{
    .normal_ramp = "profile_dec"_object, .command = ignore_edge, .ask = ask};

}  // namespace vdrive
"""
MODE_TEST = """// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/operating_mode.hpp"

#include <gtest/gtest.h>

namespace vdrive {
namespace {

TEST(ScratchMode, IsSupported) {
  EXPECT_TRUE(is_operating_mode(5));
}

}  // namespace
}  // namespace vdrive
"""
DIGEST = re.compile(r"that version and the check (\d+)")


class Recipe:
    """One recipe: its heading in CONTRIBUTING.md and the edits that follow it."""

    def __init__(self, heading, *edits):
        self.heading = heading
        self.edits = edits


def after(path, anchor, text):
    """`text` behind the line that contains `anchor`."""
    return path, anchor, lambda line: line + "\n" + text


def before(path, anchor, text):
    return path, anchor, lambda line: text + "\n" + line


def instead(path, old, new):
    return path, old, lambda line: line.replace(old, new)


def whole(path, text):
    return path, None, text


def grown(path, pattern):
    """The number in the first group of `pattern` grows by one."""
    return path, re.compile(pattern), None


RECIPES = [
    Recipe(
        "An object",
        before(OBJECT_TABLE, "{{0x5E10, 0x01}",
               '    {{0x5E0B, 0x00}, "Scratch Input", "试验", "Test", "test_scratch",\n'
               "     DataType::unsigned8, Access::read_write, Storage::not_stored, "
               'Effective::immediately, 0, 1, 0, "-", Origin::companion, Role::test_input},'),
        after("tests/data/companion-objects.csv", "0x5E0A,0x00",
              "0x5E0B,0x00,Scratch Input,test_scratch,RW,N,UNS8,0,1,0,-,"),
        instead(OBJECT_TABLE, 'kDictionaryVersion = "1.4"', 'kDictionaryVersion = "1.4s"'),
        instead(DICTIONARY_TEST, 'kVersion = "1.4"', 'kVersion = "1.4s"'),
        instead(DICTIONARY_TEST, "index <= 0x5E0A)", "index <= 0x5E0B)"),
        grown(DICTIONARY_TEST, r"EXPECT_EQ\(test_inputs, (\d+)U\)"),
        after("tests/core/dictionary_effect_test.cpp", '"test_index_pulse_input",',
              '    "test_scratch",')),
    Recipe(
        "A member of the status",
        after(AXIS_STATUS, "std::uint32_t fault_count", "  std::uint32_t scratch_count = 0;"),
        grown(AXIS_STATUS, r"kStatusMembers = (\d+)"),
        after("core/src/status_member_table.hpp", '("fault_count")',
              '    status_member<&AxisStatus::scratch_count>("scratch_count"),'),
        after(IDL, "uint32 fault_count;", "  uint32 scratch_count;"),
        instead("idl/src/status_members.hpp", "message.fault_count();",
                "message.fault_count();\n                     }},\n"
                "    WireStatusMember{&AxisStatus::scratch_count, [](auto& message) -> "
                "decltype(auto) {\n                       return message.scratch_count();"),
        instead("idl/include/vdrive/wire/status_frame.hpp", "kAxisStatusSize = 112",
                "kAxisStatusSize = 116"),
        after("clients/python/vdrive/_vdrive.pyi", "def fault_count",
              "    @property\n    def scratch_count(self) -> int: ..."),
        instead("docs/reference/wire.md", "`ignored_set_points` and `fault_count` count",
                "`ignored_set_points`, `fault_count` and `scratch_count` count"),
        after("docs/reference/wire.md", "axes[0].fault_count = 0",
              "0094  00 00 00 00              axes[0].scratch_count = 0"),
        instead("tests/core/status_digest_test.cpp", 'member.name == "fault_count")',
                'member.name == "fault_count" ||\n'
                '                  member.name == "scratch_count")')),
    Recipe(
        "A topic",
        before(IDL, "@final struct StatusFrame {",
               "@final struct Scratch {\n  @key uint32 bench;\n  uint64 tick;\n};\n"),
        after("docs/reference/wire.md", "| `bench_state` |",
              "| `scratch` | Scratch | bench | best effort, volatile, keep last 1 | "
              "service to anyone |"),
        before(TOPICS, "TopicRow<msg::BenchState>",
               '    TopicRow<msg::Scratch>{.traits = {.name = "scratch",\n'
               '                                      .type_name = "vdrive::msg::Scratch",\n'
               "                                      .key = TopicKey::bench,\n"
               "                                      .instances = kBenchesInDomain}},"),
        instead("service/src/wire/wire_program.cpp", "Topic<msg::BenchState>::kId};",
                "Topic<msg::BenchState>::kId,\n                              "
                "Topic<msg::Scratch>::kId};"),
        before("deploy/security/permissions_service.xml", "<topic>vdrive/v1/bench_state</topic>",
               "            <topic>vdrive/v1/scratch</topic>"),
        before("deploy/security/permissions_viewer.xml", "<topic>vdrive/v1/bench_state</topic>",
               "            <topic>vdrive/v1/scratch</topic>"),
        before("deploy/security/permissions_controller.xml",
               "<topic>vdrive/v1/bench_state</topic>", "            <topic>vdrive/v1/scratch</topic>"),
        after("tests/vendor/vendor_peer.c", 'TOPIC("bench_state"',
              '    TOPIC("scratch", Scratch, .depth = 1, .instances = 1024),')),
    Recipe(
        "An operating mode",
        whole("core/src/drive/modes/scratch.hpp", MODE_HEADER),
        whole("core/src/drive/modes/scratch.cpp", MODE_SOURCE),
        before("core/CMakeLists.txt", "src/drive/modes/profile_torque.cpp",
               "    src/drive/modes/scratch.cpp"),
        after(MODE_TABLE, "#include \"drive/modes/profile_velocity.hpp\"",
              '#include "drive/modes/scratch.hpp"'),
        before(MODE_TABLE, "ModeRow{OperatingMode::homing",
               "    ModeRow{OperatingMode::scratch, &kScratch},"),
        after(OPERATING_MODE, "profile_torque = 4,", "  scratch = 5,"),
        before(OPERATING_MODE, "OperatingModeRow{.mode = OperatingMode::homing",
               '    OperatingModeRow{.mode = OperatingMode::scratch,\n'
               '                     .name = "scratch",\n'
               '                     .name_zh = "草稿"},'),
        whole("tests/core/scratch_test.cpp", MODE_TEST),
        before(CORE_TESTS, "cyclic_position_test.cpp", "          scratch_test.cpp"),
        instead("tests/core/cyclic_position_test.cpp", '"supported_drive_modes"), 0x3EF',
                '"supported_drive_modes"), 0x3FF'),
        instead("tests/core/cyclic_position_test.cpp",
                "array<std::int64_t, 10> kWorking{0, 1, 2, 3, 4, 6",
                "array<std::int64_t, 11> kWorking{0, 1, 2, 3, 4, 5, 6"),
        instead(DICTIONARY_TEST, "kWorkingModes{0, 1, 2, 3, 4, 6",
                "kWorkingModes{0, 1, 2, 3, 4, 5, 6"),
        instead(DICTIONARY_TEST, "0b11'1110'1111", "0b11'1111'1111"),
        instead(DICTIONARY_TEST, '"0, 1, 2, 3, 4, 6, 7', '"0, 1, 2, 3, 4, 5, 6, 7'),
        grown("tests/gateway/directory_test.cpp", r'\["modes"\]\.size\(\), (\d+)U')),
    Recipe(
        "A fault",
        after("core/include/vdrive/cia402/error_code.hpp", "sync_controller = 0x8700,",
              "  scratch_error = 0x8F00,"),
        after("core/src/cia402/error_code.cpp", '"sync controller error"',
              '    {ErrorCode::scratch_error, "scratch error", 1U << 5U, false},'),
        grown("core/src/cia402/error_code.cpp", r"array<ErrorRow, (\d+)>"),
        after("core/src/drive/faults.hpp", '"test_dc_link_loss"_object',
              '      {1U << 5U, "test_scratch"_object, ErrorCode::scratch_error},'),
        grown("tests/gateway/directory_test.cpp", r'\["error_codes"\]\.size\(\), (\d+)U'),
        grown("core/src/drive/faults.hpp", r"inline constexpr std::array<FaultCause, (\d+)>"),
        grown("core/src/drive/faults.hpp", r"return std::array<FaultCause, (\d+)>"),
        after("clients/include/vdrive/client/disturbance.hpp", "  connection_loss,", "  scratch,"),
        after("clients/include/vdrive/client/disturbance.hpp", "choose another reaction",
              '    DisturbanceRow{Disturbance::scratch, "scratch", "test_scratch"},')),
]


def section_of(text, heading):
    """@return the recipe with that heading: from there to the next heading in bold."""
    begin = text.index(f"**{heading}")
    end = text.find("\n**", begin + 1)
    return text[begin:end]


def paths_in(section):
    """Paths in backticks; a list like `NAME.hpp` and `NAME.cpp` has the folder of the first."""
    folder = ""
    for word in re.findall(r"`([^`\s]+\.(?:hpp|cpp|idl|csv|md|c|xml|pyi|txt|ts|py|dict))`", section):
        if "/" in word:
            folder = word.rsplit("/", 1)[0]
            yield word
        elif (ROOT / folder / word).exists() or "NAME" in word:
            yield f"{folder}/{word}"


def is_named(path, names):
    for name in names:
        pattern = re.escape(name).replace("NAME", "[a-z_]+").replace(r"\*", "[a-z_]+")
        if re.fullmatch(pattern, path):
            return True
    return False


def findings_in_recipes(text):
    findings = []
    for recipe in RECIPES:
        names = set(paths_in(section_of(text, recipe.heading)))
        for name in sorted(names):
            if not list(ROOT.glob(name.replace("NAME", "*"))):
                findings.append(f"{recipe.heading}: there is no {name}")
        for path in sorted({edit[0] for edit in recipe.edits}):
            if not is_named(path, names):
                findings.append(f"{recipe.heading}: {path} is edited and not named")
    return findings


def edited(text, edit):
    path, anchor, change = edit
    if anchor is None:
        return change
    if isinstance(anchor, re.Pattern):
        match = anchor.search(text)
        if match is None:
            raise SystemExit(f"{path}: no place for {anchor.pattern}")
        return text[:match.start(1)] + str(int(match[1]) + 1) + text[match.end(1):]
    lines = text.split("\n")
    for number, line in enumerate(lines):
        if anchor in line:
            lines[number] = change(line)
            return "\n".join(lines)
    raise SystemExit(f"{path}: no place for {anchor}")


def write_if_changed(path, data):
    if path.exists() and path.read_bytes() == data:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def make_tree(tree):
    """The files of the tree with the edits; a file that stays the same keeps its time."""
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", "-co", "--exclude-standard"],
                            check=True, capture_output=True, text=True).stdout
    names = [name for name in listed.split("\0") if name and (ROOT / name).is_file()]
    edits = {}
    for recipe in RECIPES:
        for edit in recipe.edits:
            edits.setdefault(edit[0], []).append(edit)
    for name in {*names, *edits}:
        source = ROOT / name
        data = source.read_bytes() if source.exists() else b""
        if name in edits:
            text = data.decode()
            for edit in edits[name]:
                text = edited(text, edit)
            data = text.encode()
        write_if_changed(tree / name, data)
        if source.exists():
            (tree / name).chmod(source.stat().st_mode)


def run(*command, **options):
    print("+", *command, flush=True)
    return subprocess.run([str(part) for part in command], check=False, **options)


def build(tree, directory):
    configured = run("cmake", "-S", tree, "-B", directory, "-G", "Ninja",
                     "-DCMAKE_BUILD_TYPE=RelWithDebInfo", "-DVDRIVE_UNITY_BUILD=ON",
                     stdout=subprocess.DEVNULL)
    return configured.returncode == 0 and (
        run("cmake", "--build", directory, "--target", *TARGETS).returncode == 0)


def take_check(tree, directory):
    """The last step of an object: the test names the check of the new rows."""
    said = run(directory / "tests/core/core_test", "--gtest_filter=ObjectTable.HasANewVersion*",
               capture_output=True, text=True).stdout
    match = DIGEST.search(said)
    if match is None:
        raise SystemExit(f"{DICTIONARY_TEST} does not name the check of the new rows")
    test = tree / DICTIONARY_TEST
    text = re.sub(r"kCheck = 0x[0-9A-F]+", f"kCheck = 0x{int(match[1]):08X}", test.read_text())
    write_if_changed(test, text.encode())


def follow(directory):
    tree, built = directory / "tree", directory / "build"
    make_tree(tree)
    if not build(tree, built):
        return 1
    take_check(tree, built)
    write_tables = {**os.environ, "VDRIVE_WRITE_PAGE_TABLES": "1"}
    gateway_test = built / "tests/gateway/gateway_parts_test"
    run(gateway_test, "--gtest_filter=PageTables.*", "--gtest_brief=1", env=write_tables)
    if not build(tree, built):
        return 1
    tests = [built / "tests/core/core_test", built / "tests/wire/wire_parts_test", gateway_test]
    return max(run(test, "--gtest_brief=1", cwd=built).returncode for test in tests)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--check", action="store_true", help="only the paths of the recipes")
    parser.add_argument("directory", type=pathlib.Path, nargs="?")
    arguments = parser.parse_args()
    findings = findings_in_recipes((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"))
    for finding in findings:
        print(finding)
    if findings or arguments.check:
        return 1 if findings else 0
    if arguments.directory is None:
        parser.error("a directory for the copy is needed")
    if os.environ.get("VDRIVE_NIGHTLY") != "1":
        print("skipped: it builds core and wire anew; VDRIVE_NIGHTLY=1 runs it")
        return SKIPPED
    return follow(arguments.directory.resolve())


if __name__ == "__main__":
    sys.exit(main())
