// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "calls/axes_call.hpp"
#include "vdrive/client/axis.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::client {

/// A command that enables, disables, halts, resumes, stops, resets or switches axes off and on.
///
/// With Caller::axis, of one bench, each is for itself: one that refuses the command or fails does
/// not keep it from the others. With Caller::group all take it or none: the first refusal is that
/// of all, and an axis that is not enabled where it has to be stops the others. All axes have the
/// same time-out.
///
/// Its steps are called in their order; several commands, for more axes than fit into a frame, wait
/// together. A command that stops axes does so to those of other sessions, whose owners keep them,
/// and after an interrupt of the session.
class AxesCommand {
 public:
  /// @param layout at most msg::MAX_AXES_PER_FRAME axes of a bench, save for a stop
  AxesCommand(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
              EachCommand command, const CallOptions& options,
              ObservedAxes::Progress progress = {});

  /// Connects, without waiting for the status of the axes.
  void open();

  /// Observes the axes, takes control of them, and judges which of them can take the command.
  void begin();

  /// Waits for what has to end before the command.
  /// @return whether a tick has passed.
  bool await_before();

  /// Others have waited since begin(): observes the axes as they are now, and judges them again.
  void refresh();

  /// Sends the command where that needs no answer before it; else await_in_force() does.
  void send();

  /// Waits until the command is in force.
  /// @param stepped benches in lock-step of which another one has let a tick pass since send();
  ///        that of this one is added when it does
  void await_in_force(std::set<std::uint32_t>& stepped);

  /// Ends the status of the axes when none of them waits for it any more.
  void close_unless_pending();

  /// Waits until every axis that took it has done what was commanded.
  void finish();

  /// The steps after begin().
  void carry_out();

  /// Before await_in_force(), of EachCommand::resume: the axes at these places follow a stream only
  /// with the bits of kReleaseStream.
  void release_streams_of(std::vector<std::size_t> places) { streams_ = std::move(places); }

  /// @return whether an axis has no outcome yet.
  [[nodiscard]] bool has_pending() const;

  /// By place.
  [[nodiscard]] const std::vector<Outcome>& outcomes() const noexcept { return outcomes_; }

  /// @return the first failure.
  [[nodiscard]] Outcome outcome() const;

  [[nodiscard]] AxesCall& call() noexcept { return call_; }

 private:
  /// What a command is; one row a command.
  struct Row;

  static const std::array<Row, 7> kRows;
  static const Row& row_of(EachCommand command);

  [[nodiscard]] bool is_group() const { return call_.axes().caller() == Caller::group; }

  Outcome begin_call();
  Outcome begin_stop();
  Outcome acquire();
  [[nodiscard]] bool refuses_any() const;
  void judge();
  void await_end_of_reaction();

  [[nodiscard]] bool goes_ahead() const;

  /// A halt that loses a bench would leave the others on their way.
  [[nodiscard]] bool stops_if_lost() const;

  [[nodiscard]] std::vector<Round> rounds() const;
  Outcome put_in_force();
  Answers exchange();
  Outcome acquire_free(BenchPart& part);
  Answers exchange_stop(const Round& round, Timing timing);
  [[nodiscard]] std::vector<Round> held_of(const Round& round) const;
  void stop_others(BenchPart& part, const Round& round, Answers& answers);
  Outcome power_cycle();
  Outcome power_cycle(const BenchPart& part);

  void judge_in_force();
  void judge_enabling(std::size_t place);
  void judge_reset(std::size_t place, bool is_over);
  void await_operation();
  void await_reset();
  void await_standstill();
  void await_targets();
  void await_end_of_stop();
  void await_end_state();
  void await_quick_stops();
  template <typename Done>
  void await_each(std::string_view awaited, std::uint64_t from, const Done& done);
  void end_late(std::string_view awaited, const Outcome& seen, const std::vector<bool>& has_come);
  void conclude();
  void conclude_group();
  void end_if_faulty();
  [[nodiscard]] Outcome still_faulty(const AxisSnapshot& axis) const;

  [[nodiscard]] std::vector<std::size_t> pending_places() const;
  void end(std::size_t place, Outcome outcome);
  void end_all(const Outcome& outcome);

  std::shared_ptr<SessionCore> core_;
  AxesCall call_;
  const Row& row_;
  std::optional<Wakeup::StopInProgress> stop_;
  CallOptions options_;
  std::vector<std::size_t> streams_;
  std::vector<Outcome> outcomes_;     ///< by place
  std::vector<bool> is_pending_;      ///< by place: the outcome is still open
  std::vector<bool> is_held_;         ///< by place, of a stop: this session owns the axis
  bool is_left_out_ = false;          ///< an axis that cannot take the command of a group
  std::uint64_t from_ = 0;            ///< tick from which on the axes show the command
  std::vector<AxisSnapshot> at_end_;  ///< by place: when the last wait for the axis ended
};

/// Gives a command to axes of any benches, each for itself: first to all of them, then waits for
/// all.
/// @return one outcome an axis, in their order
[[nodiscard]] std::vector<Outcome> command_each(const std::shared_ptr<SessionCore>& core,
                                                std::span<const AxisId> axes, EachCommand command,
                                                const CallOptions& options);

}  // namespace vdrive::client
