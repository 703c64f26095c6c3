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

/// What commands have changed of benches for everybody, and how it was before.
class BenchChanges {
 public:
  explicit BenchChanges(client::Session& session) : session_(session) {}

  /// An object of an axis was written: a test-bench input that is not 0 is a change.
  void note_write(const client::Axis& axis, ObjectAddress object, std::int64_t value);

  /// @param before the rate of the bench before the first command that set it
  void note_rate(std::uint32_t bench, double before) { rates_before_.emplace(bench, before); }

  /// Clears the test-bench inputs, and gives each bench the rate that it had.
  /// @param axes what the user calls them
  /// @return what was put back, such as "test_blocked_load of 1.1 is 0".
  std::vector<std::string> put_back(const AxisFinder& axes);

 private:
  client::Session& session_;
  std::map<std::pair<client::AxisId, ObjectAddress>, client::Axis> disturbed_;  ///< inputs not 0
  std::map<std::uint32_t, double> rates_before_;
};

class LiveView;

/// What the commands of one session share.
struct CommandContext {
  /// @param of_session the session, which has to stay as long as this
  /// @param commands those that `run` may find in its files
  CommandContext(client::Session& of_session, Output to, CommandTable commands)
      : session(of_session),
        output(to),
        table(commands),
        axes(of_session),
        judge(of_session),
        changes(of_session),
        progress(of_session, output) {}

  /// @return the options of a call that waits like this, with the limit of the command.
  [[nodiscard]] client::CallOptions call_options(client::Until until) const;

  client::Session& session;
  Output output;
  const CommandTable table;
  AxisFinder axes;
  ExpectationJudge judge;
  BenchChanges changes;
  CommandProgress progress;         ///< of the command that runs
  std::optional<Duration> timeout;  ///< of the command: drive time of motion; none = the default
  bool outlives_failures = false;   ///< further commands come after one that failed: a shell
  bool is_private = false;          ///< the bench ends with this program, and no other reaches it
  LiveView* live_view = nullptr;    ///< is told where a position is commanded; none = no view
};

/// Carries a command out, and prints what it answers. Success and failure are the outcome; the
/// caller prints the message of a failure.
/// @param timeout drive time of motion, none = the default
client::Outcome execute(const Command& command, CommandContext& context,
                        std::optional<Duration> timeout);

/// Tells the progress of a wait for an expectation; of one that waits for nothing nothing.
void tell_progress_of(const Expectation& expectation, const client::Axis& axis,
                      CommandContext& context);

/// Checks what can be checked of a command once its axes are known, before anything moves.
/// @throws UsageError for a unit that an axis has not, and for a value that is out of range with
///         it.
void check_units(const Command& command, CommandContext& context);

}  // namespace vdrive::tool
