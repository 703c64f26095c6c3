// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "output/report.hpp"
#include "output/watch_view.hpp"
#include "recording.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
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

  /// From now on one JSON object a line, or text.
  void set_json(bool is_json) noexcept { is_json_ = is_json; }

  /// Finds an axis, once. Its bench is one of those that `wait` lets time pass on.
  client::Result<client::Axis> axis(const std::string& name);

  /// Finds the axes that the names stand for, each once: 7.* is every axis of bench 7, * every axis
  /// of every bench.
  client::Result<std::vector<client::Axis>> axes(const std::vector<std::string>& names);

  /// Checks what can be checked of a command once its axes are known, before anything moves.
  /// @throws UsageError for a unit that an axis has not, and for a value that is out of range with
  ///         it.
  client::Outcome check(const Command& command);

  /// Runs before a position is commanded: who, and where to. For a progress display.
  void on_aim(std::function<void(const client::AxisId&, std::int64_t)> handler);

  /// Puts back what the commands have changed for everybody: clears every test-bench input that
  /// none has cleared, and gives each bench the rate that it had.
  /// @return what was put back, such as "test_blocked_load of 1.1 is 0".
  std::vector<std::string> put_back();

  /// What the last failed `expect` found; none for other failures.
  [[nodiscard]] const std::optional<Json>& found() const noexcept { return found_; }

 private:
  using Outcome = client::Outcome;
  class ValueObserver;
  using Statuses = std::map<client::AxisId, client::AxisSnapshot>;

  Outcome run(const ListCommand& command);
  Outcome run(const StatusCommand& command);
  Outcome run(const WatchCommand& command);
  Outcome run(const ActionCommand& command);
  Outcome run(const StopCommand& command);
  Outcome run(const MoveCommand& command);
  Outcome run(const HomeCommand& command);
  Outcome run(const VelocityCommand& command);
  Outcome run(const TorqueCommand& command);
  Outcome run(const JogCommand& command);
  Outcome run(const ReadCommand& command);
  Outcome run(const WriteCommand& command);
  Outcome run(const DisturbCommand& command);
  Outcome run(const DictionaryCommand& command);
  Outcome run(const StepCommand& command);
  Outcome run(const RecordCommand& command);
  Outcome run(const SnapshotCommand& command);
  Outcome run(const RateCommand& command);
  Outcome run(const EventsCommand& command);
  Outcome run(const ExpectCommand& typed);
  Outcome run(const WaitCommand& command);
  Outcome run(const AwaitCommand& command);
  Outcome run(const std::shared_ptr<const RefusedCommand>& command);

  /// Commands that need no session, or make their own.
  template <typename AnyCommand>

  requires(std::is_same_v<AnyCommand, ConvertCommand> ||
           std::is_same_v<AnyCommand, DoctorCommand> || std::is_same_v<AnyCommand, BenchCommand> ||
           std::is_same_v<AnyCommand, RunCommand> || std::is_same_v<AnyCommand, TestCommand> ||
           std::is_same_v<AnyCommand, ShellCommand>) static Outcome
      run(const AnyCommand& /*command*/) {
    return Outcome::failed("this command cannot be used here");
  }

  client::Result<std::vector<client::Axis>> axes_named(const std::string& name);
  client::Result<std::vector<client::Axis>> axes_of_bench(std::uint32_t bench);
  client::Result<std::vector<client::Axis>> axes_of_all_benches();
  Outcome show_status(const client::Axis& axis, bool is_only_one);
  client::Result<std::vector<client::Axis>> axes_to_record(const RecordCommand& command);
  void report_recording(const RecordCommand& command, std::size_t axes,
                        const recording::Summary& summary);
  Outcome follow(const std::map<std::uint32_t, std::vector<client::AxisId>>& benches,
                 WatchView& view, std::vector<client::Follower>& followers);
  Outcome watch(const std::map<std::uint32_t, std::vector<client::AxisId>>& benches,
                WatchView& view, std::uint64_t count);
  Outcome list_bench(const client::BenchInfo& bench);
  client::Result<client::Axis> axis_to_command(const std::string& name, bool take_over);
  std::vector<Outcome> carry_out(std::vector<client::Axis>& axes, const ActionCommand& command);
  Statuses statuses_of(const std::vector<client::Axis>& axes);
  /// Keeps the first failure for the caller, who prints it; prints each further one.
  void keep_first_failure(Outcome reported, Outcome& first_failure);
  void report_interrupted_move(client::Axis& axis, const MoveCommand& command,
                               const Outcome& moved);
  Outcome report_motion(const client::Axis& axis, std::string_view command, Outcome outcome,
                        bool has_arrived);
  Outcome report(const client::Axis& axis, std::string_view command, Outcome outcome,
                 const client::AxisSnapshot* status, bool has_arrived);
  [[nodiscard]] std::string next_step(const client::AxisId& axis, PowerState state) const;
  Outcome show_rates();
  Outcome list_snapshots(const SnapshotCommand& command);
  void print_snapshots(const client::BenchInfo& bench, std::span<const client::KeptSnapshot> kept);
  Outcome write(client::Axis& axis, const ObjectName& object, std::int64_t value);
  void note_disturbance(const client::Axis& axis, ObjectAddress object, std::int64_t value);
  void note_limits(const client::Axis& axis, ObjectAddress written);
  Outcome print_reading(const client::AxisId& axis, const ObjectName& object,
                        const client::ObjectReading& reading, std::uint64_t tick);
  Outcome judge(client::Axis& axis, const ExpectCommand& command);
  Outcome await(const client::Axis& axis, const std::string& condition, Duration limit);
  Outcome compare(client::Axis& axis, const ExpectCommand& command);
  Outcome expect_within(ValueObserver& observer, const ExpectCommand& command);
  Outcome expect_throughout(ValueObserver& observer, const ExpectCommand& command);
  Outcome check_control(const client::AxisSnapshot& axis);
  Outcome differs(const ExpectCommand& command, std::int64_t actual, std::uint64_t tick);
  Outcome report_clock(Json json, const std::string& text,
                       const client::Result<std::uint64_t>& tick);
  void check_values(const client::Axis& axis, const MoveCommand& move) const;
  void check_values(const client::Axis& axis, const HomeCommand& home) const;
  void check_values(const client::Axis& axis, const VelocityCommand& velocity) const;
  void check_values(const client::Axis& axis, const JogCommand& jog) const;
  void check_values(const client::Axis& axis, const WriteCommand& write) const;
  void check_values(const client::Axis& axis, const ExpectCommand& expect) const;
  void check_values(const client::Axis& axis, const AwaitCommand& await) const;

  template <typename Other>
  void check_values(const client::Axis& /*axis*/, const Other& /*other*/) const {}

  [[nodiscard]] std::int64_t user_units(const client::Axis& axis, const Quantity& quantity) const;
  [[nodiscard]] std::optional<std::uint32_t> limit(const client::Axis& axis,
                                                   const std::optional<Quantity>& quantity) const;
  [[nodiscard]] client::CallOptions call_options(client::Until until) const;
  [[nodiscard]] client::VelocityOptions ramps(const client::Axis& axis, const RunRamps& ramps,
                                              client::Until until) const;
  [[nodiscard]] ExpectCommand in_user_units(const client::Axis& axis, ExpectCommand command) const;
  client::Result<client::BenchInfo> bench_of(const client::AxisId& axis);
  client::Result<client::BenchInfo> find_bench(std::optional<std::uint32_t> number,
                                               std::string_view how_to_name);
  [[nodiscard]] std::string label_of(const client::AxisId& axis) const;
  [[nodiscard]] Outcome named(const Outcome& outcome) const;

  client::Session& session_;
  Terminal& terminal_;
  bool is_json_;
  const bool is_quiet_;
  std::optional<Duration> timeout_;
  std::map<std::string, client::Axis> axes_;
  std::map<client::AxisId, std::string> typed_names_;  ///< of axes that were not called by number
  std::map<std::pair<client::AxisId, ObjectAddress>, client::Axis> disturbed_;  ///< inputs not 0
  std::map<std::uint32_t, double> rates_before_;  ///< of benches whose rate a command has set
  std::set<std::uint32_t> benches_;
  std::map<client::AxisId, std::uint64_t> in_force_;  ///< tick of the last write
  std::set<client::AxisId> held_;                     ///< axes of which this session had control
  std::function<void(const client::AxisId&, std::int64_t)> on_aim_;
  std::optional<Json> found_;
};

/// @return the refusal of an object that no address is known of.
[[nodiscard]] client::Outcome unknown_object(const client::AxisId& axis, const ObjectName& object);

/// Writes the status of one recording as another, and prints what it was; needs no session.
client::Outcome convert_recording(const ConvertCommand& command, bool is_json, Terminal& terminal);

/// Prints the object dictionary; needs no session.
void print_dictionary(DictionaryCommand command, bool is_json, Terminal& terminal);

}  // namespace vdrive::tool
