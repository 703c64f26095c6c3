// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "command.hpp"
#include "report.hpp"
#include "terminal.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "watch_view.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Carries commands out over one session, and prints what they answer. Success and failure are the
/// outcome; the caller prints the message of a failure.
class Executor {
 public:
  /// @param is_json one JSON object a line instead of text
  /// @param is_quiet only commands that read print; the others print nothing
  Executor(client::Session& session, Terminal& terminal, bool is_json, bool is_quiet);

  /// @param timeout drive time of motion, none = the default
  client::Outcome execute(const Command& command, std::optional<Duration> timeout);

  /// Finds an axis, once. Its bench is one of those that `wait` lets time pass on.
  client::Result<client::Axis> axis(const std::string& name);

  /// Runs before a position is commanded: who, and where to. For a progress display.
  void on_aim(std::function<void(const client::AxisId&, std::int64_t)> handler);

  /// What the last failed `expect` found; none for other failures.
  [[nodiscard]] const std::optional<Json>& found() const noexcept { return found_; }

 private:
  using Outcome = client::Outcome;
  class ValueObserver;

  Outcome run(const ListCommand& command);
  Outcome run(const StatusCommand& command);
  Outcome run(const WatchCommand& command);
  Outcome run(const ActionCommand& command);
  Outcome run(const StopCommand& command);
  Outcome run(const MoveCommand& command);
  Outcome run(const ReadCommand& command);
  Outcome run(const WriteCommand& command);
  Outcome run(const DisturbCommand& command);
  Outcome run(const DictionaryCommand& command);
  Outcome run(const StepCommand& command);
  Outcome run(const RecordCommand& command);
  Outcome run(const SnapshotCommand& command);
  Outcome run(const RateCommand& command);
  Outcome run(const DoctorCommand& command);
  Outcome run(const RunCommand& command);
  Outcome run(const ExpectCommand& command);
  Outcome run(const WaitCommand& command);
  Outcome run(const std::shared_ptr<const RefusedCommand>& command);

  client::Result<std::vector<client::Axis>> axes_to_record(const RecordCommand& command);
  Outcome watch(const std::vector<client::AxisId>& ids, WatchView& view, std::uint64_t count);
  Outcome list_bench(const client::BenchInfo& bench);
  client::Result<client::Axis> axis_to_command(const std::string& name, bool take_over);
  Outcome command_axis(client::Axis& axis, const ActionCommand& command);
  void report_interrupted_move(client::Axis& axis, const MoveCommand& command,
                               const Outcome& moved);
  Outcome report_motion(const client::Axis& axis, std::string_view word, const Outcome& outcome);
  Outcome write(client::Axis& axis, const ObjectName& object, std::int64_t value);
  Outcome print_reading(const client::AxisId& axis, const ObjectName& object,
                        const client::ObjectReading& reading, std::uint64_t tick);
  Outcome compare(client::Axis& axis, const ExpectCommand& command);
  Outcome expect_within(ValueObserver& observer, const ExpectCommand& command);
  Outcome expect_throughout(ValueObserver& observer, const ExpectCommand& command);
  Outcome differs(const ExpectCommand& command, std::int64_t actual, std::uint64_t tick);
  Outcome report_clock(Json json, const std::string& text,
                       const client::Result<std::uint64_t>& tick);
  client::Result<client::BenchInfo> bench_of(const client::AxisId& axis);

  client::Session& session_;
  Terminal& terminal_;
  const bool is_json_;
  const bool is_quiet_;
  std::optional<Duration> timeout_;
  std::map<std::string, client::Axis> axes_;
  std::set<std::uint32_t> benches_;
  std::map<client::AxisId, std::uint64_t> in_force_;  ///< tick of the last write
  std::function<void(const client::AxisId&, std::int64_t)> on_aim_;
  std::optional<Json> found_;
};

/// @return the refusal of an object that no address is known of.
[[nodiscard]] client::Outcome unknown_object(const client::AxisId& axis, const ObjectName& object);

/// Prints the object dictionary; needs no session.
void print_dictionary(DictionaryCommand command, bool is_json, Terminal& terminal);

}  // namespace vdrive::tool
