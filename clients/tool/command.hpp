// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "value.hpp"
#include "vdrive/client/axis.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace vdrive::tool {

using Duration = std::chrono::nanoseconds;

/// The commands of the tool, one struct each. Plain data, made by the grammar only.

struct ListCommand {};

struct StatusCommand {
  std::string axis;
};

struct WatchCommand {
  std::vector<std::string> axes;
  std::uint64_t count = 0;  ///< samples an axis; 0 = until interrupted
};

/// What a command does that takes an axis and nothing else.
enum class AxisAction : std::uint8_t {
  enable,
  disable,
  halt,
  resume,
  quick_stop,
  reset,
  power_cycle,
  store,
  restore
};

struct ActionCommand {
  AxisAction action;
  std::string axis;
  client::Until until = client::Until::done;
  bool take_over = false;
};

/// Quick stop of every axis of a bench.
struct StopCommand {
  std::optional<std::uint32_t> bench;  ///< none = the only one there is
  client::Until until = client::Until::done;
};

struct MoveCommand {
  std::string axis;
  std::int32_t position = 0;
  bool relative = false;
  client::MoveOptions options;
  bool take_over = false;
  bool stop_on_interrupt = false;
};

struct ReadCommand {
  std::string axis;
  std::vector<ObjectName> objects;
};

struct WriteCommand {
  std::string axis;
  ObjectName object;
  std::int64_t value = 0;
  bool take_over = false;
};

/// One test-bench input.
struct Disturbance {
  ObjectName object;
  std::int64_t value = 0;
};

struct DisturbCommand {
  std::string axis;
  std::string kind;
  std::vector<Disturbance> inputs;  ///< several for `none`
  std::optional<Duration> duration;
};

enum class TableFormat : std::uint8_t { table, json, csv };
enum class Language : std::uint8_t { en, zh };

struct DictionaryCommand {
  TableFormat format = TableFormat::table;
  Language language = Language::en;
  std::vector<ObjectName> objects = {};  ///< rows of these; none = all
};

struct StepCommand {
  std::uint64_t ticks = 0;
  std::optional<std::uint32_t> bench;
};

enum class RecordFormat : std::uint8_t { csv, json_lines };

struct RecordCommand {
  std::string file;               ///< - = standard output
  std::vector<std::string> axes;  ///< none = all of the only bench there is
  RecordFormat format = RecordFormat::csv;
  std::optional<Duration> duration;  ///< drive time; none = until interrupted
  std::uint64_t count = 0;           ///< samples of each bench; 0 = until interrupted
};

struct SnapshotCommand {
  enum class Action : std::uint8_t { take, restore, drop };

  Action action = Action::take;
  std::uint64_t snapshot = 0;  ///< restore, drop: its number
  std::optional<std::uint32_t> bench;
};

struct RateCommand {
  std::optional<double> rate;  ///< none = show those of all benches
  std::optional<std::uint32_t> bench;
};

/// Checks this machine and finds the benches on the domain.
struct DoctorCommand {};

struct RunCommand {
  std::string file;
  std::string junit;  ///< empty = none
  bool live = false;
};

/// Commands of scenarios.

struct ExpectCommand {
  std::string axis;
  ObjectName object;
  std::int64_t value = 0;
  std::optional<std::uint64_t> mask;
  std::optional<std::uint64_t> tolerance;
  std::optional<Duration> within;
  std::optional<Duration> throughout;

  /// @return whether `actual` is what is expected.
  [[nodiscard]] bool accepts(std::int64_t actual) const noexcept;
};

struct WaitCommand {
  Duration duration{};
};

struct RefusedCommand;

using Command =
    std::variant<ListCommand, StatusCommand, WatchCommand, ActionCommand, StopCommand, MoveCommand,
                 ReadCommand, WriteCommand, DisturbCommand, DictionaryCommand, StepCommand,
                 RateCommand, SnapshotCommand, RecordCommand, DoctorCommand, RunCommand,
                 ExpectCommand, WaitCommand, std::shared_ptr<const RefusedCommand>>;

struct RefusedCommand {
  std::uint32_t code = 0;
  Command command;
};

/// @return the axes that the command names.
[[nodiscard]] std::vector<std::string> axes_of(const Command& command);

/// @return the bench that the command names, if it names one.
[[nodiscard]] std::optional<std::uint32_t> bench_of(const Command& command);

/// @return the name of the command, such as "quick-stop".
[[nodiscard]] std::string_view to_string(AxisAction action) noexcept;

/// @return "take", "restore" or "drop".
[[nodiscard]] std::string_view to_string(SnapshotCommand::Action action) noexcept;

}  // namespace vdrive::tool
