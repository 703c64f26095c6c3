// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/axis_finder.hpp"
#include "execution/command_progress.hpp"
#include "execution/expectation_judge.hpp"
#include "language/command.hpp"
#include "output/record.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {

/// The changes that commands make for all users of a bench, and the previous values.
class BenchChanges {
 public:
  explicit BenchChanges(client::Session& session) : session_(session) {}

  /// An object of an axis was written. A test-bench input other than 0 counts as a change.
  void note_write(const client::Axis& axis, ObjectAddress object, std::int64_t value);

  /// @param before rate of the bench before the first command that set it
  void note_rate(std::uint32_t bench, double before) { rates_before_.emplace(bench, before); }

  /// Clears the test-bench inputs and restores the rate of each bench.
  /// @param axes has the names that the user has typed
  /// @return the restored values, such as "test_blocked_load of 1.1 is 0".
  std::vector<std::string> put_back(const AxisFinder& axes);

 private:
  client::Session& session_;
  std::map<std::pair<client::AxisId, ObjectAddress>, client::Axis> disturbed_;  ///< inputs other
                                                                                ///< than 0
  std::map<std::uint32_t, double> rates_before_;
};

class LiveView;

/// State shared by the commands of one session.
struct CommandContext {
  /// @param of_session must outlive this object
  /// @param commands those allowed in the files of `run`
  CommandContext(client::Session& of_session, Output to, CommandTable commands)
      : session(of_session),
        output(to),
        table(commands),
        axes(of_session),
        judge(of_session),
        changes(of_session),
        progress(of_session, output) {}

  /// @return the options of a call that returns as `until` says, with the time-out of the command.
  [[nodiscard]] client::CallOptions call_options(client::Until until) const;

  client::Session& session;
  Output output;
  const CommandTable table;
  AxisFinder axes;
  ExpectationJudge judge;
  BenchChanges changes;
  CommandProgress progress;         ///< of the current command
  std::optional<Duration> timeout;  ///< of the current command: drive time of motion; none = the
                                    ///< default
  bool outlives_failures = false;   ///< commands may follow a failed one: a shell
  bool is_private = false;          ///< the bench ends with this program, and no other program
                                    ///< reaches it
  LiveView* live_view = nullptr;    ///< is told the target positions of moves; nullptr = no view
};

/// Executes a command and prints its answer. The outcome reports success or failure; the caller
/// prints the message of a failure.
/// @param timeout drive time of motion, none = the default
client::Outcome execute(const Command& command, CommandContext& context,
                        std::optional<Duration> timeout);

/// Shows the progress while a command waits for an expectation; shows nothing if it does not wait.
void show_progress_of(const Expectation& expectation, const client::Axis& axis,
                      CommandContext& context);

/// Makes those checks of a command that need its axes, before anything moves.
/// @throws UsageError for a unit that an axis does not have, and for a value that is out of range
///         after conversion from its unit.
void check_units(const Command& command, CommandContext& context);

}  // namespace vdrive::tool
