#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows the recipes of CONTRIBUTING.md in a copy of the tree.

follow.py [--check] DIRECTORY

Copies the tree to DIRECTORY/tree, makes a scratch object, status member, event, topic, kind of
request, figure, operating mode and fault there, builds in DIRECTORY/build and runs the tests that
the recipes name. An edit may change only files that its recipe names, and each path in a recipe must
exist, so a recipe that forgets a place fails. So does one that edits more product files than MOST_FILES
allows: what several rooms need must be described in one place. With --check nothing is built. Without
--check it needs VDRIVE_NIGHTLY=1 and is otherwise skipped (exit code 77), because it builds core, wire,
engine, clients and their tests. A second run in DIRECTORY builds only what has changed.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77
TARGETS = ["core_test", "wire_parts_test", "service_engine_test", "service_parts_test",
           "gateway_parts_test", "vdrive_sessions"]

OBJECT_TABLE = "core/include/vdrive/dictionary/object_table.hpp"
OPERATING_MODE = "core/include/vdrive/cia402/operating_mode.hpp"
MODE_TABLE = "core/src/drive/mode_table.cpp"
AXIS_STATUS = "core/include/vdrive/axis_status.hpp"
EVENT_KINDS = "core/include/vdrive/event_kind.hpp"
IDL = "idl/vdrive_messages.idl"
REQUEST_KINDS = "idl/include/vdrive/wire/request_kinds.hpp"
REQUEST_HANDLERS = "service/src/engine/request_handlers.cpp"
COUNTERS = "service/src/base/counters.hpp"
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
# The number of product files that a recipe may edit. Tests do not count, nor do documents that are
# generated from tables or compared with them.
MOST_FILES = {
    "An object": 3,
    "A member of the status": 3,
    "An event": 2,
    "A topic": 3,
    "A kind of request": 4,
    "A figure of a bench": 2,
}
NO_PRODUCT = ("tests/", "docs/")
REQUEST_HANDLER = """Reason scratch(const RequestParts& parts, const msg::Request& request,
               msg::Reply& reply) {
  reply.tick = std::get<BenchClock&>(parts).tick() + request.snapshot;
  return msg::Reason::none;
}
"""
REQUEST_CALL = """inline msg::Request scratch(std::uint64_t snapshot) {
  return request<msg::RequestKind::scratch, &msg::Request::snapshot>(snapshot);
}
"""
DIGEST = re.compile(r"that version and the check (\d+)")


class Recipe:
    """One recipe: its heading in CONTRIBUTING.md and the edits that follow it."""

    def __init__(self, heading, *edits):
        self.heading = heading
        self.edits = edits


def after(path, anchor, text):
    """`text` after the line that contains `anchor`."""
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
               '    {{0x5E0D, 0x00}, "Scratch Input", "试验", "Test", "test_scratch",\n'
               "     DataType::unsigned8, Access::read_write, Storage::not_stored, "
               'Effective::immediately, 0, 1, 0, "-", Origin::companion, Role::test_input},'),
        after("tests/data/companion-objects.csv", "0x5E0C,0x00",
              "0x5E0D,0x00,Scratch Input,test_scratch,RW,N,UNS8,0,1,0,-,"),
        instead(OBJECT_TABLE, 'kDictionaryVersion = "1.5"', 'kDictionaryVersion = "1.5s"'),
        instead(DICTIONARY_TEST, 'kVersion = "1.5"', 'kVersion = "1.5s"'),
        instead(DICTIONARY_TEST, "index <= 0x5E0C)", "index <= 0x5E0D)"),
        grown(DICTIONARY_TEST, r"EXPECT_EQ\(test_inputs, (\d+)U\)"),
        after("tests/core/dictionary_effect_test.cpp", '"test_index_pulse_input",',
              '    "test_scratch",')),
    Recipe(
        "A member of the status",
        after(AXIS_STATUS, "std::uint32_t fault_count", "  std::uint32_t scratch_count = 0;"),
        before(AXIS_STATUS, 'StatusField{"fault_count"',
               '    StatusField{"scratch_count", &AxisStatus::scratch_count},'),
        after(IDL, "uint32 fault_count;", "  uint32 scratch_count;"),
        instead("docs/reference/wire.md", "`ignored_set_points` and `fault_count` count",
                "`ignored_set_points`, `fault_count` and `scratch_count` count"),
        instead("tests/core/status_digest_test.cpp", 'member.name == "fault_count")',
                'member.name == "fault_count" ||\n'
                '                  member.name == "scratch_count")')),
    Recipe(
        "An event",
        after(IDL, "const uint32 EVENT_STOPPED", "/// a scratch\nconst uint32 EVENT_SCRATCH = 20;"),
        after(EVENT_KINDS, "stopped = 19,", "  scratch = 20,"),
        after(EVENT_KINDS, "{EventKind::stopped,",
              '    {EventKind::scratch, "scratch", EventSeverity::info},'),
        after("docs/reference/wire.md", "| 19 | `EVENT_STOPPED`",
              "| 20 | `EVENT_SCRATCH` | info | |")),
    Recipe(
        "A topic",
        before(IDL, "@final struct StatusFrame {",
               "@final struct Scratch {\n  @key uint32 bench;\n  uint64 tick;\n};\n"),
        after("docs/reference/wire.md", "| `bench_state` |",
              "| `scratch` | Scratch | bench | live |"),
        before(TOPICS, "TopicRow<msg::BenchState>",
               '    TopicRow<msg::Scratch>{"scratch", Publisher::service, '
               "{.instances = kBenchesInDomain}},"),
        after("deploy/security/topics.txt", "bench_state ", "scratch        service"),
        before("tests/wire/bytes_test.cpp", "OfTopic<msg::BenchState",
               "    OfTopic<msg::Scratch, fast::Scratch>,"),
        after("tests/vendor/vendor_peer.c", 'TOPIC("bench_state"',
              '    TOPIC("scratch", Scratch, .depth = 1, .instances = 1024),')),
    Recipe(
        "A kind of request",
        after(IDL, "REQUEST_READ_WINDOW = 20;", "const uint32 REQUEST_SCRATCH = 21;"),
        after(REQUEST_KINDS, "Row{Kind::read_window",
              "      Row{Kind::scratch, Uses{&Asked::session, &Asked::snapshot}, By::session, At::standing},"),
        before(REQUEST_HANDLERS, "struct HandlerRow {", REQUEST_HANDLER),
        after(REQUEST_HANDLERS, "HandlerRow{msg::RequestKind::read_writes",
              "    HandlerRow{msg::RequestKind::scratch, scratch},"),
        before("clients/src/base/ask.hpp", "}  // namespace vdrive::ask",
               REQUEST_CALL),
        after("docs/reference/wire.md", "`REQUEST_READ_WINDOW`",
              "| 21 | `REQUEST_SCRATCH` | `session`, `snapshot` | session | standing | nothing |")),
    Recipe(
        "A figure of a bench",
        after(IDL, "uint64 longest_silence_us;",
              "  /// @figure counter headline\n  /// Scratches\n  uint64 scratches;"),
        after(COUNTERS, "  Counter master_losses;", "  Counter scratches;"),
        after(COUNTERS, "FigureRow{&msg::BenchState::longest_silence_us,",
              "    FigureRow{&msg::BenchState::scratches, &Counters::scratches},")),
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
        after("clients/include/vdrive/client/disturbance.hpp", "select another reaction",
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
    for word in re.findall(r"`([^`\s]+\.(?:hpp|cpp|idl|csv|md|c|xml|txt|py|dict))`", section):
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


def product_files(recipe):
    paths = {edit[0] for edit in recipe.edits}
    return sorted(path for path in paths if not path.startswith(NO_PRODUCT))


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
        files = product_files(recipe)
        print(f"{recipe.heading}: {len(files)} product files: {', '.join(files)}")
        if len(files) > MOST_FILES.get(recipe.heading, len(files)):
            findings.append(f"{recipe.heading}: edits {len(files)} product files; "
                            f"{MOST_FILES[recipe.heading]} are allowed")
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
    """The last step for an object: the test prints the check of the new rows, which is written into it."""
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
    if not build(tree, built):
        return 1
    tests = [built / "tests/core/core_test", built / "tests/wire/wire_parts_test",
             built / "tests/service/service_engine_test",
             built / "tests/service/service_parts_test",
             built / "tests/gateway/gateway_parts_test"]
    # The scratch members change something that is fixed for a released version.
    kept = "--gtest_filter=-IdlOf1_0.HasEveryStruct*:FilesOf1_0.AJournal*"
    return max(run(test, "--gtest_brief=1", kept, cwd=built).returncode for test in tests)


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
