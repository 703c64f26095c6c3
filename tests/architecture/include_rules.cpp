// SPDX-License-Identifier: Apache-2.0
#include "architecture/include_rules.hpp"

#include "architecture/pattern.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::architecture {
namespace {

/// The origin of an included file.
enum class Origin {
  standard,     ///< <vector>
  system,       ///< <unistd.h>, <sys/socket.h>, and C's own <math.h>
  eigen,        ///< <Eigen/Core>, <unsupported/Eigen/MatrixFunctions>
  dds,          ///< Fast DDS, any other DDS
  cdr,          ///< "vdrive/wire/cdr.hpp", the encoding of samples: no network
  python,       ///< <pybind11/pybind11.h>, <Python.h>
  third_party,  ///< any other library: <spdlog/spdlog.h>
  core,         ///< "vdrive/axis_bank.hpp"
  wire,         ///< "vdrive/wire/topics.hpp"
  messages,     ///< the code generated from the .idl files
  client,       ///< "vdrive/client/session.hpp"
  bench,        ///< "vdrive/bench/bench.hpp"
  settings,     ///< "settings/yaml_reader.hpp", of the service
  beside,       ///< a private header of the same folder: "block.hpp"
  elsewhere,    ///< a path that leaves the folder, starts at the repository or does not exist:
                ///< "../x.hpp", "tests/x.hpp", "vdrive/service/x.hpp"
};

struct PrefixRow {
  std::string_view prefix;
  Origin origin;
};

// The first match counts.
constexpr std::array kPrefixes{
    PrefixRow{"vdrive/wire/cdr.hpp", Origin::cdr},
    PrefixRow{"vdrive/wire/", Origin::wire},
    PrefixRow{"vdrive/msg/", Origin::messages},
    PrefixRow{"vdrive_messages", Origin::messages},
    PrefixRow{"ros_messages", Origin::messages},
    PrefixRow{"vdrive/service/", Origin::elsewhere},  // the service has no public header
    PrefixRow{"vdrive/client/", Origin::client},
    PrefixRow{"vdrive/bench/", Origin::bench},
    PrefixRow{"vdrive/", Origin::core},
    PrefixRow{"settings/", Origin::settings},
    PrefixRow{"Eigen/", Origin::eigen},
    PrefixRow{"unsupported/Eigen/", Origin::eigen},
    PrefixRow{"fastdds/", Origin::dds},
    PrefixRow{"fastrtps/", Origin::dds},
    PrefixRow{"fastcdr/", Origin::dds},
    PrefixRow{"openssl/", Origin::dds},  // the cryptography of DDS Security
    PrefixRow{"dds/", Origin::dds},
    PrefixRow{"pybind11/", Origin::python},
    PrefixRow{"Python.h", Origin::python},
    PrefixRow{"ddsc/", Origin::dds},
    PrefixRow{"core/", Origin::elsewhere},
    PrefixRow{"idl/", Origin::elsewhere},
    PrefixRow{"service/", Origin::elsewhere},
    PrefixRow{"clients/", Origin::elsewhere},
    PrefixRow{"tests/", Origin::elsewhere},
    PrefixRow{"deploy/", Origin::elsewhere},
    PrefixRow{"sys/", Origin::system},
    PrefixRow{"linux/", Origin::system},
    PrefixRow{"net/", Origin::system},
    PrefixRow{"netinet/", Origin::system},
    PrefixRow{"arpa/", Origin::system},
};

struct Include {
  std::string name;
  bool quoted = false;
};

Origin origin_of(const Include& include) {
  if (include.name.find("..") != std::string::npos) return Origin::elsewhere;
  for (const PrefixRow& row : kPrefixes) {
    if (include.name.starts_with(row.prefix)) return row.origin;
  }
  if (include.quoted) return Origin::beside;
  if (include.name.find('/') != std::string::npos) return Origin::third_party;
  return include.name.ends_with(".h") ? Origin::system : Origin::standard;
}

/// A folder and what its files may include. The first folder that a path starts with applies.
struct RoomRow {
  std::string_view folder;
  std::span<const Origin> may_include;
  std::string_view reason;
};

constexpr std::array kCoreMay{Origin::standard, Origin::eigen, Origin::core, Origin::beside};
constexpr std::array kIdlMay{Origin::standard, Origin::system,   Origin::cdr,   Origin::core,
                             Origin::wire,     Origin::messages, Origin::beside};
// Participants that reach a network.
constexpr std::array kDdsMay{Origin::standard, Origin::system, Origin::cdr,      Origin::dds,
                             Origin::core,     Origin::wire,   Origin::messages, Origin::beside};
constexpr std::array kServiceMay{Origin::standard,    Origin::system, Origin::eigen,
                                 Origin::third_party, Origin::core,   Origin::wire,
                                 Origin::messages,    Origin::beside, Origin::settings};
constexpr std::array kClientHeaderMay{Origin::standard, Origin::eigen, Origin::core,
                                      Origin::client};
// A client without our library: a DDS and the code that its compiler generates from the IDL.
constexpr std::array kRawExampleMay{Origin::standard, Origin::system, Origin::dds,
                                    Origin::messages};
// The formats do not use DDS: they get a bench's data from the client library. Recorded messages
// are encoded like samples.
constexpr std::array kRecordingMay{Origin::standard, Origin::system, Origin::third_party,
                                   Origin::core,     Origin::cdr,    Origin::client,
                                   Origin::beside};
constexpr std::array kClientMay{Origin::standard,    Origin::system, Origin::eigen,
                                Origin::third_party, Origin::core,   Origin::wire,
                                Origin::messages,    Origin::client, Origin::beside};
// The tool creates its own benches for the scenarios that it runs.
constexpr std::array kToolMay{
    Origin::standard, Origin::system,   Origin::eigen,  Origin::third_party, Origin::core,
    Origin::wire,     Origin::messages, Origin::client, Origin::bench,       Origin::beside};
// A bridge reads a YAML file as the service does, with the same checks and the same messages.
constexpr std::array kBridgeMay{Origin::standard, Origin::system,      Origin::eigen,
                                Origin::core,     Origin::third_party, Origin::cdr,
                                Origin::wire,     Origin::messages,    Origin::client,
                                Origin::beside,   Origin::settings};
// Nodes are functions of frames, states and time.
constexpr std::array kCanopenNodeMay{Origin::standard, Origin::core, Origin::beside};
// The judge is a function of records. Only its exceptions/ also reads YAML.
constexpr std::array kJudgeMay{Origin::standard, Origin::core, Origin::beside};
constexpr std::array kJudgeFilesMay{Origin::standard, Origin::core, Origin::beside,
                                    Origin::settings};
constexpr std::array kJudgeReplayedMay{Origin::standard, Origin::core, Origin::messages,
                                       Origin::beside};
constexpr std::array kJudgeLiveMay{Origin::standard, Origin::core, Origin::client, Origin::beside};
// This bridge creates its own benches, for masters that are tested without a network.
constexpr std::array kCanopenMay{
    Origin::standard, Origin::system, Origin::eigen, Origin::core,   Origin::third_party,
    Origin::wire,     Origin::client, Origin::bench, Origin::beside, Origin::settings};
// The Python module is a client for Python programs. It sends nothing on the wire itself.
constexpr std::array kPythonMay{Origin::standard, Origin::system, Origin::eigen, Origin::python,
                                Origin::core,     Origin::client, Origin::bench, Origin::beside};
// The only room that knows both the engine and the client library.
constexpr std::array kBenchMay{Origin::standard, Origin::core,   Origin::wire,    Origin::client,
                               Origin::bench,    Origin::beside, Origin::settings};

constexpr std::string_view kDdsReason = "idl/ knows DDS and core/ only";
constexpr std::string_view kClientReason =
    "clients/ reaches DDS through vdrive/wire and no service";
constexpr std::string_view kBridgeReason =
    "a bridge reaches DDS through vdrive/wire, and of the service it includes settings/ only";

constexpr std::array kRooms{
    RoomRow{"core/", kCoreMay, "core/ knows the standard library and Eigen only"},
    RoomRow{"idl/src/dds/", kDdsMay, kDdsReason},
    RoomRow{"idl/src/guard/", kDdsMay, kDdsReason},
    RoomRow{"idl/src/ros/", kDdsMay, kDdsReason},
    RoomRow{"idl/", kIdlMay, "of idl/ only src/dds, src/guard and src/ros know the DDS library"},
    RoomRow{"service/", kServiceMay, "service/ reaches DDS through vdrive/wire and no client"},
    RoomRow{"clients/include/", kClientHeaderMay, "a public client header names no DDS type"},
    RoomRow{"clients/examples/06_raw_dds/", kRawExampleMay,
            "the raw example has nothing of ours but the IDL"},
    RoomRow{"clients/bench/", kBenchMay, "clients/bench/ puts the engine and a client together"},
    RoomRow{"clients/recording/", kRecordingMay,
            "clients/recording/ uses the client library, and no DDS"},
    RoomRow{"clients/python/", kPythonMay, "the Python module is a client and names no wire"},
    RoomRow{"clients/bridge/", kBridgeMay, kBridgeReason},
    RoomRow{"clients/canopen/src/node/", kCanopenNodeMay, "a node knows core/ only"},
    RoomRow{"clients/canopen/", kCanopenMay, kBridgeReason},
    RoomRow{"clients/gateway/", kBridgeMay, kBridgeReason},
    RoomRow{"clients/judge/src/exceptions/", kJudgeFilesMay,
            "exceptions/ reads YAML and knows no bench"},
    RoomRow{"clients/judge/src/replayed/", kJudgeReplayedMay,
            "replayed/ runs the engine again, and knows no wire"},
    RoomRow{"clients/judge/src/live/", kJudgeLiveMay, "live/ is a client, and knows no wire"},
    RoomRow{"clients/judge/", kJudgeMay, "the judge knows core/ only"},
    RoomRow{"clients/ros2/", kBridgeMay, kBridgeReason},
    RoomRow{"clients/tool/", kToolMay, kClientReason},
    RoomRow{"clients/", kClientMay, kClientReason},
    RoomRow{"deploy/", {}, "deploy/ has no code"},
};

/// A file of core/src/drive without its extension, or a folder of it ("modes/"), or the files of a
/// folder whose names end alike ("modes/*_state"); the first match applies. A file may include only
/// files of lower layers, not of its own layer, so there is no cycle.
struct LayerRow {
  std::string_view name;
  int layer;
};

constexpr std::array kDriveLayers{
    LayerRow{"modes/*_state", -1},  // state of a mode between ticks
    LayerRow{"habits_state", -1},   // state of the habits, 5E20h
    LayerRow{"probe_state", -1},    // state of the touch probes between two looks
    LayerRow{"state", 0},           // state of an axis
    LayerRow{"frame", 1},           // origin of its positions
    LayerRow{"block", 2},           // its steady ticks, in parallel with other axes
    LayerRow{"registers", 1},       // its objects
    LayerRow{"habits", 2},          // queries about 5E20h
    LayerRow{"faults", 2},          // causes that are present, the history
    LayerRow{"limits", 2},          // queries
    LayerRow{"stops", 2},           // queries
    LayerRow{"target", 2},          // reset or seeded
    LayerRow{"touch_probe", 2},     // latched edges of the inputs
    LayerRow{"window", 2},          // conditions that must last
    LayerRow{"vl_units", 2},        // queries: speeds in the units of 6042h
    LayerRow{"homing_search", 3},   // search for a switch or a mechanical stop
    LayerRow{"power", 3},           // transitions
    LayerRow{"modulo", 3},          // positions in the range 607Bh
    LayerRow{"demand", 4},          // requests, plans; no modes
    LayerRow{"interpolation", 4},   // streamed set-points; no modes
    LayerRow{"mode", 5},            // interface of a mode to the drive
    LayerRow{"modes/", 6},          // independent of each other
    LayerRow{"mode_table", 7},      // one row per mode
    LayerRow{"controlword", 8},     // obeyed immediately or later
    LayerRow{"tick", 9},           LayerRow{"objects", 10},
};

/// Which headers of clients/bridge, such as "reports.hpp", a room may include; they belong to no
/// room.
enum class UseOfKit { none, without_bench, whole };

/// The headers of clients/bridge that know no bench.
constexpr std::array<std::string_view, 2> kKitWithoutBench{"severity.hpp", "tcp_listen.hpp"};

/// A room inside a folder, and the other rooms of the folder that it may include. A new room is a
/// new row.
struct InnerRoomRow {
  std::string_view room;
  std::vector<std::string_view> may_include;
  std::string_view reason;
  UseOfKit kit = UseOfKit::none;
};

const std::vector<InnerRoomRow>& service_rooms() {
  static const std::vector<InnerRoomRow> rows{
      {"base", {}, "base/ is below every room"},
      {"settings", {}, "settings/ reads YAML and knows no bench"},
      {"configuration", {"base", "settings"}, "configuration/ is data"},
      {"seam", {"base", "configuration"}, "both halves include seam/, so it includes neither"},
      {"store", {"base", "settings", "configuration"}, "store/ is files"},
      {"journal", {"base", "settings", "configuration"}, "journal/ records and replays changes"},
      {"engine",
       {"base", "configuration", "seam", "store", "journal"},
       "engine/ has no clock, and nothing leaves it but by seam/"},
      {"publish", {"base", "configuration", "seam"}, "publish/ encodes what leaves; no engine"},
      {"clock",
       {"base", "configuration", "seam", "engine", "publish"},
       "clock/ drives the engine, and starts neither store, journal nor wire"},
      {"wire", {"base", "configuration", "seam"}, "the wire has no state of the bench"},
      {"run",
       {"base", "configuration", "seam", "store", "journal", "engine", "publish", "clock"},
       "run/ has the threads of a bench, and no wire of any kind"},
      {"supervision", {"base", "seam"}, "supervision/ starts the wire as a program"},
      {"program",
       {"base", "settings", "configuration", "seam", "store", "journal", "engine", "publish",
        "clock", "run", "wire", "supervision"},
       "program/ puts all together"},
  };
  return rows;
}

/// "" stands for the files next to the rooms: main, the table of commands, and the code that starts
/// a command.
const std::vector<InnerRoomRow>& tool_rooms() {
  static const std::vector<InnerRoomRow> rows{
      {"base", {}, "base/ is below every room"},
      {"terminal", {}, "terminal/ knows keys and lines only"},
      {"values", {"base"}, "values/ is what a person types, without commands"},
      {"language", {"base", "values"}, "language/ reads commands and carries none out"},
      {"output", {"base", "terminal", "values"}, "output/ shows what it is given"},
      {"diagnosis",
       {"base", "terminal", "values", "language", "output"},
       "diagnosis/ checks and measures this machine; it knows no command"},
      {"execution",
       {"base", "terminal", "values", "language", "output"},
       "execution/ is what commands share; it knows none of them"},
      {"scenarios",
       {"base", "terminal", "values", "language", "output", "execution"},
       "scenarios/ carries out the commands of a table that it is given"},
      {"commands",
       {"base", "terminal", "values", "language", "output", "diagnosis", "execution", "scenarios"},
       "a command does not know the program"},
      {"",
       {"base", "terminal", "values", "language", "execution"},
       "the program starts a command by its row"},
  };
  return rows;
}

const std::vector<InnerRoomRow>& client_rooms() {
  static const std::vector<InnerRoomRow> rows{
      {"base", {}, "base/ is below every room"},
      {"presence", {"base"}, "presence/ finds benches and commands none"},
      {"exchange", {"base", "presence"}, "exchange/ sends and waits for answers; no stream"},
      {"streams", {"base", "presence", "exchange"}, "streams/ shows benches and steps none"},
      {"clocks",
       {"base", "presence", "exchange", "streams"},
       "clocks/ is a part of the session, not a user of it"},
      {"session",
       {"base", "presence", "exchange", "streams", "clocks"},
       "session/ composes the parts and commands no axis"},
      {"calls", {"base", "session"}, "calls/ reaches the parts by their session; no groups"},
      {"groups", {"base", "calls"}, "groups/ commands axes by calls/"},
  };
  return rows;
}

const std::vector<InnerRoomRow>& canopen_rooms() {
  static const std::vector<InnerRoomRow> rows{
      {"node", {}, "node/ knows no bus and no bench"},
      {"bus", {"node"}, "bus/ carries frames and knows no bench", UseOfKit::without_bench},
      {"bridge", {"node", "bus"}, "bridge/ puts benches behind nodes", UseOfKit::whole},
  };
  return rows;
}

/// "node" is the room of clients/canopen for the CANopen encoding, in which a bus log is written.
const std::vector<InnerRoomRow>& judge_rooms() {
  static const std::vector<InnerRoomRow> rows{
      {"judge", {}, "judge/ is a function of records, whatever their source"},
      {"node", {}, "node/ knows no judge"},
      {"journal", {}, "journal/ is that of the service"},
      {"log", {"judge", "node"}, "log/ makes records of the frames of a bus"},
      {"exceptions", {"judge"}, "exceptions/ reads a file for the judge"},
      {"replayed",
       {"judge", "journal"},
       "replayed/ makes records of a journal, whose drives it runs again"},
      {"live", {"judge"}, "live/ makes records of a bench that runs"},
  };
  return rows;
}

/// A folder that is divided into rooms.
struct DividedFolder {
  std::string_view folder;
  const std::vector<InnerRoomRow>& rooms;
};

const std::array<DividedFolder, 4>& divided_folders() {
  static const std::array<DividedFolder, 4> folders{
      DividedFolder{"service/src/", service_rooms()},
      DividedFolder{"clients/src/", client_rooms()},
      DividedFolder{"clients/canopen/src/", canopen_rooms()},
      DividedFolder{"clients/judge/src/", judge_rooms()},
  };
  return folders;
}

/// The only files that may include the complete engine: its drivers, and what creates it.
constexpr std::array<std::string_view, 6> kKnowTheEngine{
    "engine/bench_engine.cpp",   "clock/freerun_driver.hpp", "clock/lockstep_driver.hpp",
    "clock/realtime_driver.hpp", "clock/shutdown.hpp",       "run/bench_run.hpp"};

/// Text that is forbidden in a folder ("" is every folder), as a regular expression.
struct TextRule {
  std::string_view folder;
  Pattern pattern;
  std::string_view reason;
  std::string_view except{};  ///< an exempt folder in it
};

/// Standard headers, matched in full.
const std::vector<TextRule>& forbidden_headers() {
  static const std::vector<TextRule> rules{
      {"core/",
       Pattern("thread|stop_token|mutex|shared_mutex|condition_variable|future|atomic|semaphore|"
               "barrier|latch"),
       "core/ has no threads and no locks"},
      {"core/", Pattern("fstream|istream|ostream|filesystem|cstdio|syncstream"),
       "core/ touches no file and writes no log"},
      {"core/", Pattern("random"), "noise is a hash of seed, axis and tick"},
      {"core/", Pattern("ctime|csignal"), "core/ has no clock and no signals"},
      {"core/", Pattern("iostream"), "core/ writes no log"},
      {"clients/judge/src/judge/",
       Pattern("thread|mutex|condition_variable|future|atomic|fstream|iostream|filesystem|random|"
               "ctime"),
       "the judge is a function: no thread, no file, no clock"},
  };
  return rules;
}

/// Code, searched without comments and string literals.
const std::vector<TextRule>& forbidden_code() {
  static const Pattern dds(R"(\b(eprosima|fastdds|fastrtps|fastcdr)\b)");
  static const std::vector<TextRule> rules{
      {"core/", Pattern(R"(\b(system|steady|high_resolution|utc|tai|gps|file)_clock\b)"),
       "time is an argument"},
      {"core/", Pattern(R"(\b(getenv|secure_getenv|rand|srand|printf|fopen)\s*\()"),
       "core/ has no environment, random source or file"},
      {"core/", Pattern(R"(\bthread_local\b)"), "core/ has no global state"},
      // The results of these differ in the last bit between libraries and vector widths. The rest
      // of <cmath> (abs, floor, round, sqrt, copysign, isfinite ...) is exact everywhere.
      {"core/",
       Pattern(R"(\bstd::(a?(sin|cos|tan)h?|atan2|exp2?|expm1|log(2|10|1p|b)?|pow|cbrt|hypot|)"
               R"(fma|[lt]gamma|erfc?)\s*\()"),
       "step and plan use + - * / sqrt and comparisons only"},
      {"core/", dds, "only idl/ names the DDS library"},
      {"service/", dds, "only idl/ names the DDS library"},
      {"", Pattern(R"(^namespace \w+::\w+::\w)"), "namespaces have two levels at most"},
      {"clients/", dds, "only idl/ names the DDS library"},
      {"clients/judge/", Pattern(R"(\b(system|steady|high_resolution)_clock\b)"),
       "time is a member of a record"},
      {"idl/", Pattern(R"(\bfastrtps\b)"), "only idl/src/dds/library/ knows which version it is",
       "idl/src/dds/library/"},
  };
  return rules;
}

std::vector<std::string> split_lines(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::optional<Include> parse_include(const std::string& line) {
  if (line.find("include") == std::string::npos)
    return std::nullopt;  // most lines, without a regex
  static const Pattern pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  const std::vector<std::string> parts = pattern.search(line);
  if (parts.empty()) return std::nullopt;
  return Include{parts[2], parts[1] == "\""};
}

/// The line without string literals and without a comment at its end. Block comments are not
/// recognised: the style does not allow them.
std::string code_of(const std::string& line) {
  static const Pattern literal(R"("([^"\\]|\\.)*")");
  std::string code;
  std::string rest = line;
  while (rest.find('"') != std::string::npos) {
    const std::vector<std::string> found = literal.search(rest);
    if (found.empty()) break;
    const std::size_t place = rest.find(found[0]);
    code += rest.substr(0, place) + "\"\"";
    rest.erase(0, place + found[0].size());
  }
  code += rest;
  return code.substr(0, code.find("//"));
}

std::string violation(std::string_view path, std::size_t line, std::string_view what,
                      std::string_view reason) {
  return std::string(path) + ":" + std::to_string(line) + ": " + std::string(what) + ": " +
         std::string(reason);
}

std::optional<std::string_view> refuse_include(std::string_view path, const RoomRow& room,
                                               const Include& include) {
  const Origin origin = origin_of(include);
  if (origin == Origin::elsewhere) return "included by the path of another folder";
  if (std::ranges::find(room.may_include, origin) == room.may_include.end()) return room.reason;
  if (origin != Origin::standard) return std::nullopt;
  for (const TextRule& rule : forbidden_headers()) {
    if (path.starts_with(rule.folder) && rule.pattern.is_all_of(include.name)) {
      return rule.reason;
    }
  }
  return std::nullopt;
}

std::string_view without_extension(std::string_view path) {
  return path.substr(0, path.rfind('.'));
}

bool matches(std::string_view name, std::string_view pattern) {
  const std::size_t star = pattern.find('*');
  if (star != std::string_view::npos) {
    return name.starts_with(pattern.substr(0, star)) && name.ends_with(pattern.substr(star + 1));
  }
  return pattern.ends_with('/') ? name.starts_with(pattern) : name == pattern;
}

/// @return the layer of `name`, a path below core/src/drive without extension.
std::optional<int> layer_of(std::string_view name) {
  const auto row = std::ranges::find_if(kDriveLayers, [name](const LayerRow& candidate) {
    return matches(name, candidate.name);
  });
  return row == kDriveLayers.end() ? std::nullopt : std::optional(row->layer);
}

/// Checks the layers of a drive. From outside, only the bank may include its files.
std::optional<std::string_view> refuse_layer(std::string_view path, const Include& include) {
  constexpr std::string_view kFolder = "core/src/drive/";
  constexpr std::string_view kPrefix = "drive/";
  if (!path.starts_with("core/") || !include.name.starts_with(kPrefix)) return std::nullopt;
  if (!path.starts_with(kFolder)) {
    if (path.starts_with("core/src/bank/")) return std::nullopt;
    return "only the bank includes the files of a drive";
  }
  const std::string_view from = without_extension(path.substr(kFolder.size()));
  const std::string_view to =
      without_extension(std::string_view(include.name).substr(kPrefix.size()));
  const std::optional<int> upper = layer_of(from);
  const std::optional<int> lower = layer_of(to);
  if (!upper || !lower) return "core/src/drive has a file without a layer";
  if (from == to || *lower < *upper) return std::nullopt;
  return "a file of core/src/drive includes lower layers only";
}

std::string_view first_folder(std::string_view path) {
  return path.substr(0, path.find('/'));
}

const InnerRoomRow* find_room(const std::vector<InnerRoomRow>& rooms, std::string_view path) {
  const auto row = std::ranges::find(rooms, first_folder(path), &InnerRoomRow::room);
  return row == rooms.end() ? nullptr : &*row;
}

bool may_use_of_kit(const InnerRoomRow& room, std::string_view name) {
  if (room.kit == UseOfKit::without_bench) return std::ranges::count(kKitWithoutBench, name) > 0;
  return room.kit == UseOfKit::whole && name.find('/') == std::string_view::npos;
}

/// The rooms inside a folder.
std::optional<std::string_view> refuse_inner_room(std::string_view path, const Include& include) {
  const auto divided = std::ranges::find_if(divided_folders(), [&](const DividedFolder& row) {
    return path.starts_with(row.folder);
  });
  if (divided == divided_folders().end()) return std::nullopt;
  const InnerRoomRow* const from = find_room(divided->rooms, path.substr(divided->folder.size()));
  if (from == nullptr) return "a file without a room in a folder that has rooms";
  const Origin origin = origin_of(include);
  const bool is_settings = origin == Origin::settings && divided->folder == "service/src/";
  if (!include.quoted || (origin != Origin::beside && !is_settings)) return std::nullopt;
  if (may_use_of_kit(*from, include.name)) return std::nullopt;
  const InnerRoomRow* const to = find_room(divided->rooms, include.name);
  if (to == nullptr) return "a file of a room includes another one by its room";
  if (to != from && std::ranges::count(from->may_include, to->room) == 0) return from->reason;
  return std::nullopt;
}

/// Checks who includes the complete engine.
std::optional<std::string_view> refuse_whole_engine(std::string_view path, const Include& include) {
  constexpr std::string_view kFolder = "service/src/";
  if (!path.starts_with(kFolder) || include.name != "engine/bench_engine.hpp") return std::nullopt;
  if (std::ranges::count(kKnowTheEngine, path.substr(kFolder.size())) > 0) return std::nullopt;
  return "only its drivers and the program know the whole engine";
}

/// The rooms of the tool. Headers without a folder belong to other libraries or lie next to main.
std::optional<std::string_view> refuse_tool_room(std::string_view path, const Include& include) {
  constexpr std::string_view kFolder = "clients/tool/";
  if (!path.starts_with(kFolder)) return std::nullopt;
  path.remove_prefix(kFolder.size());
  const bool has_room = path.find('/') != std::string_view::npos;
  const auto row =
      std::ranges::find(tool_rooms(), has_room ? first_folder(path) : "", &InnerRoomRow::room);
  if (row == tool_rooms().end()) return "clients/tool has a file without a room";
  const std::string_view name = include.name;
  if (name == "command_table.hpp" && has_room) {
    return "only the program knows the table of commands";
  }
  const std::string_view included = first_folder(name);
  const bool is_of_tool =
      included != name &&
      std::ranges::find(tool_rooms(), included, &InnerRoomRow::room) != tool_rooms().end();
  if (!include.quoted || !is_of_tool) return std::nullopt;
  if (included == "commands" && without_extension(name) != without_extension(path)) {
    return "the table of commands has a row of each; nothing includes one";
  }
  if (included != row->room && std::ranges::count(row->may_include, included) == 0) {
    return row->reason;
  }
  return std::nullopt;
}

std::optional<std::string_view> refuse_code(std::string_view path, const std::string& code) {
  for (const TextRule& rule : forbidden_code()) {
    const bool is_exempt = !rule.except.empty() && path.starts_with(rule.except);
    if (path.starts_with(rule.folder) && !is_exempt && rule.pattern.is_in(code)) return rule.reason;
  }
  return std::nullopt;
}

}  // namespace

Violations check_source(std::string_view path, std::string_view text) {
  Violations violations;
  const auto room = std::ranges::find_if(kRooms, [&](const RoomRow& row) {
    return path.starts_with(row.folder);
  });
  const std::vector<std::string> lines = split_lines(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (const auto include = parse_include(lines[i])) {
      if (room == kRooms.end()) continue;  // tests/ may include everything
      auto reason = refuse_include(path, *room, *include);
      if (!reason) reason = refuse_layer(path, *include);
      if (!reason) reason = refuse_inner_room(path, *include);
      if (!reason) reason = refuse_tool_room(path, *include);
      if (!reason) reason = refuse_whole_engine(path, *include);
      if (reason) violations.push_back(violation(path, i + 1, include->name, *reason));
    } else if (const auto reason = refuse_code(path, code_of(lines[i]))) {
      violations.push_back(violation(path, i + 1, lines[i], *reason));
    }
  }
  return violations;
}

bool reaches_private_header(std::string_view path, std::string_view included,
                            const std::vector<std::string>& headers) {
  const std::string ending = "/" + std::string(included);
  return std::ranges::any_of(headers, [&](const std::string& header) {
    if (!header.ends_with(ending)) return false;
    const bool is_shared = header.starts_with("service/src/settings/");
    const bool is_in_room = first_folder(header) == first_folder(path);
    // These run the engine: in a user's process, and for a judge's replay.
    const bool knows_engine =
        path.starts_with("clients/bench/") || path.starts_with("clients/judge/src/replayed/");
    const bool is_bench = knows_engine && header.starts_with("service/src/");
    return is_in_room || is_shared || is_bench;
  });
}

Violations check_top_level(const std::vector<std::string>& names) {
  constexpr std::array<std::string_view, 13> kAllowed{
      "CHANGELOG.md",    "CMakeLists.txt", "CMakePresets.json",
      "CONTRIBUTING.md", "LICENSE",        "README.md",
      "clients",         "cmake",          "core",
      "deploy",          "docs",           "idl",
      "service"};
  Violations violations;
  for (const std::string& name : names) {
    const bool ignored = name.starts_with('.') || name == "build" || name == "tests";
    if (!ignored && std::ranges::find(kAllowed, name) == kAllowed.end()) {
      violations.push_back(name + ": not one of the rooms and files of the top level");
    }
  }
  return violations;
}

}  // namespace vdrive::architecture
