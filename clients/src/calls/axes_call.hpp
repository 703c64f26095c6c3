// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/drive_words.hpp"
#include "calls/observed_axes.hpp"
#include "vdrive/quantity.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdrive::client {

/// @return the refusal of an action that the state of a drive does not allow.
[[nodiscard]] Outcome not_in_this_state(std::string message);

/// @return the refusal of a command that the power state of the axis does not allow; for a fault,
///         with its cause.
[[nodiscard]] Outcome refused_in_state(const AxisSnapshot& axis, std::string_view command,
                                       std::string_view hint);

/// @return failed, with the error, if any, and the state that the axis shows instead of the awaited
///         one.
[[nodiscard]] Outcome failed_instead_of(std::string_view awaited, const AxisSnapshot& axis);

/// @return timed_out, with the state that the axis shows instead of the awaited one.
[[nodiscard]] Outcome timed_out_for(std::string_view awaited, const AxisSnapshot& axis);

/// The contents of one frame per bench: commands to axes, by their place in the group.
struct Round {
  struct Entry {
    std::size_t place;
    msg::AxisCommand command;
  };

  std::vector<Entry> entries;
  std::uint32_t flags = 0;  ///< FRAME_...
  bool is_endless = false;  ///< its axes run until another command stops them: see HeldAxes
};

/// Whether several benches in real time act immediately or in a tick that all of them can meet.
enum class Timing : std::uint8_t { at_once, common_tick };

/// The answers to rounds.
struct Answers {
  Outcome outcome;
  std::uint64_t tick = 0;  ///< in which the accepted commands take effect; 0 = none was accepted
  std::vector<std::size_t> ignored;  ///< places of the axes that ignored their set-point
};

/// A call that commands one or more axes: holds their states, the commands to them and the
/// deadline.
class AxesCall {
 public:
  AxesCall(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
           ObservedAxes::Progress progress = {});

  // ---- begin

  /// Connects only: see ObservedAxes::open.
  Outcome open() { return axes_.open(); }

  /// Connects and observes the axes for the first time.
  /// @param timeout drive time, from the first observation on
  Outcome begin(std::chrono::nanoseconds timeout);

  /// Takes control of every axis. Call this after begin() and before the first command.
  /// @param by_force also of axes that another session owns
  Outcome acquire(bool by_force = false);

  /// begin() and acquire().
  /// @param objects of each axis, requested at the same time: see take_values()
  Outcome begin_control(std::chrono::nanoseconds timeout,
                        std::span<const ObjectAddress> objects = {});

  /// Restarts the time-out from the present tick.
  void set_timeout(std::chrono::nanoseconds timeout);

  /// Records that commands of this call took effect at `tick`. In freerun the time-out counts from
  /// there, because the bench may run minutes of drive time before a command arrives.
  void note_in_force(std::uint64_t tick);

  // ---- observing

  [[nodiscard]] ObservedAxes& axes() noexcept { return axes_; }

  [[nodiscard]] const ObservedAxes& axes() const noexcept { return axes_; }

  /// The axes as last observed, in the order of the group.
  [[nodiscard]] const std::vector<AxisSnapshot>& snapshots() const noexcept {
    return axes_.snapshots();
  }

  /// The first axis; the only one in a call for a single axis.
  [[nodiscard]] const AxisSnapshot& snapshot() const { return axes_.snapshots().front(); }

  [[nodiscard]] std::uint64_t tick() const noexcept { return axes_.tick(); }

  /// Use for durations: see ObservedAxes.
  [[nodiscard]] std::uint64_t driven_tick() const noexcept { return axes_.driven_tick(); }

  [[nodiscard]] std::chrono::microseconds period() const { return axes_.period(); }

  [[nodiscard]] bool steps() const { return axes_.steps(); }

  /// The unit of an axis, for messages: see Discovery::unit_of.
  [[nodiscard]] Unit unit_of(const AxisId& axis) const { return core_->discovery.unit_of(axis); }

  /// @param user_units a position of the first axis [UU]
  /// @return the position as written in messages, such as "1024 UU (90.00 deg)".
  [[nodiscard]] std::string position_text(std::int64_t user_units) const;

  /// As position_text(), for a velocity [UU/s].
  [[nodiscard]] std::string velocity_text(std::int64_t user_units) const;

  /// Checks that every axis `fulfils` a condition, after ObservedAxes::look_again() if one does
  /// not.
  /// @return refused, naming the first axis that does not
  Outcome require(bool (*fulfils)(const AxisSnapshot& axis), std::string_view command,
                  std::string_view needs);

  /// Values of objects, one row per axis.
  using Values = std::vector<std::vector<std::int64_t>>;

  Result<Values> read(std::span<const ObjectAddress> objects);

  /// @return the objects requested by begin_control().
  Result<Values> take_values();

  // ---- commands

  /// @return an empty command to the axis at `place`.
  [[nodiscard]] msg::AxisCommand command_to(std::size_t place) const;

  /// @return a round with an empty command for every axis for which `wanted` holds.
  template <typename Wanted>
  [[nodiscard]] Round round_to(const Wanted& wanted) const {
    Round round;
    for (std::size_t place = 0; place < snapshots().size(); ++place) {
      if (wanted(snapshots()[place])) round.entries.push_back({place, command_to(place)});
    }
    return round;
  }

  /// @return a round with the controlword `word` for every axis for which `wanted` holds.
  template <typename Wanted>
  [[nodiscard]] Round round_of(std::uint16_t word, const Wanted& wanted) const {
    Round round = round_to(wanted);
    for (Round::Entry& entry : round.entries) {
      entry.command.members = msg::HAS_DS402_CONTROLWORD;
      entry.command.ds402_controlword = word;
    }
    return round;
  }

  /// Sends rounds in order, one frame per round and bench, and collects the answers. In lock-step
  /// no time passes. With Timing::common_tick, a refusal by one bench cancels the waiting frames on
  /// the others; if that was too late, `tick` is not 0.
  Answers exchange(std::span<const Round> rounds, Timing timing);

  /// Sends rounds in order, then observes the tick in which the last takes effect; in lock-step,
  /// steps to it.
  /// @return refused if a set-point was ignored.
  Outcome put_in_force(std::span<const Round> rounds);

  /// The first half of put_in_force(), which does not wait. await_in_force() must follow.
  void begin_to_put_in_force(std::span<const Round> rounds);

  /// The second half of put_in_force().
  /// @param has_stepped in lock-step: another call of this session has stepped a tick since; that
  ///        tick is observed, and no further one is stepped
  Outcome await_in_force(bool has_stepped = false);

  /// As put_in_force() of rounds, with the same controlwords for every axis.
  Outcome put_in_force(const std::vector<std::uint16_t>& controlwords);

  /// Sends rounds; their answers are collected later.
  /// @param apply_at tick in which they should take effect, 0 = the next
  /// @param sent one entry per bench, also for frames sent before a failure
  Outcome send(std::span<const Round> rounds, std::uint64_t apply_at,
               std::vector<SentFrames>& sent);

  Answers collect(std::span<const SentFrames> sent, Outcome outcome);

  /// By place, the command of this call that counts for the axis: the last one that ends a motion
  /// (a mode, a set-point, leaving Operation enabled), otherwise the first one, such as a resume.
  [[nodiscard]] const std::vector<GivenCommand>& given() const noexcept { return given_; }

  /// Makes this call wait for commands that an earlier call has given to axes of this session.
  void follow(std::vector<GivenCommand> given);

  // ---- waiting

  /// Observes tick by tick until `done` holds for every axis, at `from` or later.
  /// @param done takes an AxisSnapshot, or a place in the group
  /// @return timed_out at the deadline, naming the axes that are late.
  template <typename Done>
  Outcome await(std::string_view awaited, std::uint64_t from, const Done& done) {
    for (auto late = late_places(from, done); !late.empty(); late = late_places(from, done)) {
      if (Outcome seen = observe_next(awaited, late); !seen) return seen;
    }
    return {};
  }

  /// As await(), while every axis stays in Operation enabled. If one does not, or its service is
  /// lost, the others are stopped.
  template <typename Done>
  Outcome await_enabled(std::string_view awaited, std::uint64_t from, const Done& done) {
    while (true) {
      if (Outcome sound = check(awaited, from); !sound) return sound;
      const auto late = late_places(from, done);
      if (late.empty()) return {};
      if (Outcome seen = observe_next(awaited, late); !seen) return stop_if_lost(std::move(seen));
    }
  }

  /// Observes until `tick`, whatever the state of the axes.
  Outcome await_tick(std::string_view awaited, std::uint64_t tick);

  // ---- stopping

  /// Stops the others if an axis, observed at `from` or later, is not in Operation enabled, belongs
  /// to another session, or has got a command from elsewhere in this session.
  /// @return refused if another session has taken an axis; failed if another call of this session
  ///         has commanded it: that axis is not stopped
  Outcome check(std::string_view awaited, std::uint64_t from);

  /// Records that this session had every axis before this call; check_owners() compares with that.
  void note_owned() { was_owner_.assign(was_owner_.size(), true); }

  /// @return failed if the axis at `place` is not in Operation enabled, or if this session has
  ///         given it a command that is not from this call (named in the message): then this call
  ///         does not stop it
  [[nodiscard]] Outcome check_command(std::string_view awaited, std::size_t place);

  /// @return whether this session has the axis, according to both the bench and the session.
  [[nodiscard]] bool has_control_of(const Target& target, const AxisSnapshot& axis) const {
    return axis.owner_session == core_->id && core_->control.holds(target, {&axis.id.axis, 1});
  }

  /// @return whether check_command() has seen another command on an axis in Operation enabled.
  [[nodiscard]] bool is_superseded() const;

  /// @return refused if another session has an axis that this session had in a tick observed by
  ///         this call, or before this call (note_owned()).
  [[nodiscard]] Outcome check_owners();

  /// Quick stop of every axis in Operation enabled, except those that another session has taken or
  /// that have another command; observes the axes until all are at rest.
  /// @return `cause`.
  Outcome stop_others(Outcome cause);

  /// As stop_others(), without waiting.
  /// @param stop receives the answers to the quick stop
  /// @return `cause`.
  Outcome send_stop(Outcome cause, Answers& stop);

  /// Calls stop_others() if `outcome` is the loss of a service; otherwise does nothing.
  Outcome stop_if_lost(Outcome outcome);

  /// Asks the service about an axis that has stopped or lost its power without a fault.
  /// @return lost if the service is shutting down, which removes the power from all its axes, or
  ///         has ended
  [[nodiscard]] Outcome check_service(const AxisSnapshot& axis);

  /// @return `failed`, preceded by the cause if check_service() knows it.
  [[nodiscard]] Outcome explain_by_service(const Outcome& failed, const AxisSnapshot& axis);

  /// As explain_by_service() for an axis that is not in Operation enabled; otherwise returns
  /// `failed`.
  [[nodiscard]] Outcome explain_lost_power(const Outcome& failed, const AxisSnapshot& axis);

  /// As above, for the first axis that is not in Operation enabled.
  [[nodiscard]] Outcome explain_lost_power(const Outcome& failed);

 private:
  /// @return the places of the axes for which `done` does not hold yet at `from` or later.
  template <typename Done>
  [[nodiscard]] std::vector<std::size_t> late_places(std::uint64_t from, const Done& done) const {
    std::vector<std::size_t> places;
    for (std::size_t place = 0; place < snapshots().size(); ++place) {
      if (tick() < from || !holds(done, place)) places.push_back(place);
    }
    return places;
  }

  template <typename Done>
  [[nodiscard]] bool holds(const Done& done, std::size_t place) const {
    if constexpr (std::is_invocable_v<const Done&, const AxisSnapshot&>) {
      return done(snapshots()[place]);
    } else {
      return done(place);
    }
  }

  void ask(std::span<const ObjectAddress> objects);
  [[nodiscard]] const BenchPart& part_of(const AxisId& axis) const;
  [[nodiscard]] std::vector<std::uint16_t> axes_to_acquire(const BenchPart& part) const;
  [[nodiscard]] bool is_taken(std::size_t place) const;
  void note_given(std::size_t place, const msg::AxisCommand& command, std::uint64_t sequence);
  void note_given(const BenchPart& part, std::span<const Round> rounds,
                  std::span<const std::uint64_t> sequences);
  [[nodiscard]] std::optional<std::string> find_end(std::size_t place) const;
  Outcome renew_control(const Round& round);
  Outcome observe_next(std::string_view awaited, std::span<const std::size_t> late);
  [[nodiscard]] Outcome timed_out(std::string_view awaited,
                                  std::span<const std::size_t> late) const;
  Answers exchange_at(std::span<const Round> rounds, std::uint64_t apply_at);
  void cancel_pending();
  [[nodiscard]] std::string read_name(const BenchPart& part) const;

  std::shared_ptr<SessionCore> core_;
  ObservedAxes axes_;
  std::chrono::nanoseconds timeout_{0};
  std::uint64_t deadline_ = 0;       ///< as driven_tick()
  std::vector<bool> was_owner_;      ///< by place: whether this session had the axis in any tick
  std::vector<GivenCommand> given_;  ///< by place
  std::vector<bool> is_superseded_;  ///< by place
  std::vector<SentRequests> asked_;  ///< by ask(): one per bench
  std::size_t asked_objects_ = 0;
  std::vector<SentFrames> sent_;  ///< by begin_to_put_in_force(); `sending_` is the outcome
  Outcome sending_;
};

}  // namespace vdrive::client
