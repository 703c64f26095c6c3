// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "format.hpp"
#include "values/units.hpp"
#include "values/value.hpp"
#include "vdrive/client/axis.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::tool {

using Duration = std::chrono::nanoseconds;

/// The axis, or the axes, that a command names are addresses such as 7.1 and 7.lift, names, and
/// where there may be several also 7.* and *.
///
/// The commands of the tool, one struct each. Plain data, made by the grammar only.

struct ListCommand {};

struct StatusCommand {
  std::vector<std::string> axes;  ///< none = all of all benches
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
  std::vector<std::string> axes;
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
  Quantity position;
  bool relative = false;
  std::optional<Quantity> velocity;
  std::optional<Quantity> acceleration;
  std::optional<Quantity> deceleration;
  bool queue = false;
  client::Until until = client::Until::done;
  bool take_over = false;
  bool stop_on_interrupt = false;
};

struct HomeCommand {
  std::string axis;
  std::optional<std::int8_t> method;  ///< 6098h
  std::optional<Quantity> offset;
  std::optional<Quantity> search_speed;
  std::optional<Quantity> creep_speed;
  std::optional<Quantity> acceleration;
  client::Until until = client::Until::done;
  bool take_over = false;
};

/// The ramps of profile velocity mode.
struct RunRamps {
  std::optional<Quantity> acceleration;
  std::optional<Quantity> deceleration;
};

struct VelocityCommand {
  std::string axis;
  Quantity velocity;
  RunRamps ramps;
  client::Until until = client::Until::done;
  bool take_over = false;
};

struct TorqueCommand {
  std::string axis;
  std::int16_t torque = 0;             ///< [‰ of rated torque]
  std::optional<std::uint32_t> slope;  ///< [‰ of rated torque a second]
  client::Until until = client::Until::done;
  bool take_over = false;
};

struct JogCommand {
  std::string axis;
  Quantity velocity;
  RunRamps ramps;
  std::optional<Duration> duration;  ///< none = until Enter or an interrupt
  bool take_over = false;
};

struct ReadCommand {
  std::string axis;
  std::vector<ObjectName> objects;
};

struct WriteCommand {
  std::string axis;
  ObjectName object;
  std::int64_t value = 0;
  std::optional<Quantity> quantity = std::nullopt;  ///< the value where it has a unit
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

struct RecordCommand {
  std::string file;               ///< - = standard output
  std::vector<std::string> axes;  ///< none = all of the only bench there is
  recording::Format format = recording::Format::csv;
  std::optional<Duration> duration;               ///< drive time; none = until interrupted
  std::uint64_t count = 0;                        ///< samples of each bench; 0 = until interrupted
  Duration lost_after = std::chrono::minutes(1);  ///< wall time without a sample that ends it
};

/// Writes the status of one recording as another.
struct ConvertCommand {
  std::string from;
  std::string to;
  std::optional<Duration> period;  ///< of a tick, where `from` has no such time
};

struct SnapshotCommand {
  enum class Action : std::uint8_t { take, restore, drop, list };

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

/// Measures what this machine can do, on benches of its own.
struct BenchCommand {
  std::string service;    ///< empty = found beside the tool or in PATH
  bool is_quick = false;  ///< short parts, at most 1,024 axes
};

struct RunCommand {
  std::vector<std::string> files;
  std::vector<std::string> settings;  ///< of variables, such as axis=7.1
  std::string junit;                  ///< empty = none
  bool live = false;
};

/// Runs scenarios on benches of their own.
struct TestCommand {
  std::vector<std::string> files;
  std::vector<std::string> settings;  ///< of variables, such as axis=7.1
  std::string junit;                  ///< empty = none
  std::string configuration;          ///< empty = the demo bench
  std::string service;                ///< empty = found beside the tool or in PATH
  std::size_t jobs = 1;               ///< files at the same time
};

struct EventsCommand {
  std::string of;  ///< a bench's number or an axis; empty = all benches
  bool follow = false;
};

/// Reads commands from standard input.
struct ShellCommand {};

/// How an actual value has to stand to the expected one.
enum class Comparison : std::uint8_t { equal, not_equal, less, at_most, more, at_least };

struct ExpectCommand {
  std::string axis;
  ObjectName object;
  Comparison comparison = Comparison::equal;
  std::int64_t value = 0;
  std::optional<Quantity> quantity;  ///< the value where it has a unit
  std::optional<std::uint64_t> mask;
  std::optional<std::uint64_t> tolerance;
  std::optional<Quantity> quantity_of_tolerance;
  std::optional<Duration> within;
  std::optional<Duration> throughout;

  /// @return whether `actual` is what is expected.
  [[nodiscard]] bool accepts(std::int64_t actual) const noexcept;

  /// @return the same for Comparison::equal: under the mask, or within the tolerance.
  [[nodiscard]] bool equals(std::int64_t actual) const noexcept;
};

struct WaitCommand {
  Duration duration{};
};

/// Waits until an axis shows something.
struct AwaitCommand {
  std::string axis;
  std::string condition;                     ///< one of condition_names(), or empty:
  std::optional<ExpectCommand> expectation;  ///< of an object
};

struct RefusedCommand;

using Command =
    std::variant<ListCommand, StatusCommand, WatchCommand, ActionCommand, StopCommand, MoveCommand,
                 HomeCommand, VelocityCommand, TorqueCommand, JogCommand, ReadCommand, WriteCommand,
                 DisturbCommand, DictionaryCommand, StepCommand, RateCommand, SnapshotCommand,
                 RecordCommand, ConvertCommand, DoctorCommand, BenchCommand, RunCommand,
                 TestCommand, EventsCommand, ShellCommand, ExpectCommand, WaitCommand, AwaitCommand,
                 std::shared_ptr<const RefusedCommand>>;

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

/// @return such as "<=".
[[nodiscard]] std::string_view to_string(Comparison comparison) noexcept;

/// @return the comparison that `text` is, if it is one.
[[nodiscard]] std::optional<Comparison> comparison_named(std::string_view text) noexcept;

/// @return "take", "restore", "drop" or "list".
[[nodiscard]] std::string_view to_string(SnapshotCommand::Action action) noexcept;

}  // namespace vdrive::tool
