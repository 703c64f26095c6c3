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
#include <string_view>
#include <utility>
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

  /// Sets every test-bench input back that a command has set and none has cleared.
  /// @return what was cleared, such as "test_blocked_load of 1.1".
  std::vector<std::string> clear_disturbances();

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
  Outcome report_motion(const client::Axis& axis, std::string_view word, Outcome outcome,
                        bool has_arrived);
  [[nodiscard]] std::string next_step(const client::AxisId& axis, PowerState state) const;
  Outcome show_rates();
  Outcome write(client::Axis& axis, const ObjectName& object, std::int64_t value);
  void note_disturbance(const client::Axis& axis, ObjectAddress object, std::int64_t value);
  void note_limits(const client::Axis& axis, ObjectAddress written);
  Outcome print_reading(const client::AxisId& axis, const ObjectName& object,
                        const client::ObjectReading& reading, std::uint64_t tick);
  Outcome compare(client::Axis& axis, const ExpectCommand& command);
  Outcome expect_within(ValueObserver& observer, const ExpectCommand& command);
  Outcome expect_throughout(ValueObserver& observer, const ExpectCommand& command);
  Outcome differs(const ExpectCommand& command, std::int64_t actual, std::uint64_t tick);
  Outcome report_clock(Json json, const std::string& text,
                       const client::Result<std::uint64_t>& tick);
  client::Result<client::BenchInfo> bench_of(const client::AxisId& axis);
  client::Result<client::BenchInfo> find_bench(std::optional<std::uint32_t> number,
                                               std::string_view how_to_name);
  [[nodiscard]] std::string label_of(const client::AxisId& axis) const;
  [[nodiscard]] Outcome named(const Outcome& outcome) const;

  client::Session& session_;
  Terminal& terminal_;
  const bool is_json_;
  const bool is_quiet_;
  std::optional<Duration> timeout_;
  std::map<std::string, client::Axis> axes_;
  std::map<client::AxisId, std::string> typed_names_;  ///< of axes that were not called by number
  std::map<std::pair<client::AxisId, ObjectAddress>, client::Axis> disturbed_;  ///< inputs not 0
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
