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

/// A command that enables, disables, halts, resumes, stops, resets or power-cycles axes.
///
/// With Caller::axis the axes are on one bench and independent: one that refuses the command or
/// fails does not affect the others. With Caller::group all axes take the command or none: the
/// first refusal is the outcome for all, and if an axis is not in Operation enabled when the
/// command should leave it there, the others are stopped. All axes have the same time-out.
///
/// The steps must be called in order. Axes that do not fit in one frame are spread over several
/// commands, which wait together. A command that stops axes also works after an interrupt of the
/// session, and on axes of other sessions, which keep their owners.
class AxesCommand {
 public:
  /// @param layout at most msg::MAX_AXES_PER_FRAME axes per bench, except for a stop
  AxesCommand(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
              EachCommand command, const CallOptions& options,
              ObservedAxes::Progress progress = {});

  /// Connects, without waiting for the status of the axes.
  void open();

  /// Observes the axes, takes control of them, and determines which of them can take the command.
  void begin();

  /// Waits for anything that must end before the command.
  /// @return whether a tick has passed.
  bool await_before();

  /// If other commands have waited since begin(): observes and evaluates the axes again.
  void refresh();

  /// Sends the command if no answer is needed first; otherwise await_in_force() does.
  void send();

  /// Waits until the command is in force.
  /// @param stepped benches in lock-step on which another command has stepped a tick since send();
  ///        this command adds its own if it steps
  void await_in_force(std::set<std::uint32_t>& stepped);

  /// Stops receiving the status of the axes once none of them needs it.
  void close_unless_pending();

  /// Waits until every axis that took the command has completed it.
  void finish();

  /// The steps after begin().
  void carry_out();

  /// For EachCommand::resume, before await_in_force(): the axes at these places follow a stream
  /// only with the bits of kReleaseStream.
  void release_streams_of(std::vector<std::size_t> places) { streams_ = std::move(places); }

  /// @return whether an axis has no outcome yet.
  [[nodiscard]] bool has_pending() const;

  /// By place.
  [[nodiscard]] const std::vector<Outcome>& outcomes() const noexcept { return outcomes_; }

  /// @return the first failure.
  [[nodiscard]] Outcome outcome() const;

  [[nodiscard]] AxesCall& call() noexcept { return call_; }

 private:
  /// The properties of a command; one row per command.
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

  [[nodiscard]] bool sends_before_answers() const;

  /// If a halt loses a bench, the other axes must not keep moving.
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
  std::vector<bool> is_held_;         ///< by place, for a stop: this session owns the axis
  bool is_left_out_ = false;          ///< an axis of the group cannot take the command
  std::uint64_t from_ = 0;            ///< tick from which on the axes show the effect
  std::vector<AxisSnapshot> at_end_;  ///< by place: the axis when the last wait for it ended
};

/// Gives a command to axes on any benches, independently: sends it to all of them, then waits for
/// all.
/// @return one outcome per axis, in their order
[[nodiscard]] std::vector<Outcome> command_each(const std::shared_ptr<SessionCore>& core,
                                                std::span<const AxisId> axes, EachCommand command,
                                                const CallOptions& options);

}  // namespace vdrive::client
