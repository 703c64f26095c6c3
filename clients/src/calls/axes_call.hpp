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

/// @return the refusal of something that the state of a drive does not allow.
[[nodiscard]] Outcome not_in_this_state(std::string message);

/// @return the refusal of a command that the axis' power state does not allow; of a fault with its
///         cause.
[[nodiscard]] Outcome refused_in_state(const AxisSnapshot& axis, std::string_view command,
                                       std::string_view hint);

/// @return failed, with what the axis shows instead of what was awaited: the cause first.
[[nodiscard]] Outcome failed_instead_of(std::string_view awaited, const AxisSnapshot& axis);

/// @return timed_out, with what the axis shows instead of what was awaited.
[[nodiscard]] Outcome timed_out_for(std::string_view awaited, const AxisSnapshot& axis);

/// What one frame for each bench carries: commands to axes by their place in the group.
struct Round {
  struct Entry {
    std::size_t place;
    msg::AxisCommand command;
  };

  std::vector<Entry> entries;
  std::uint32_t flags = 0;  ///< FRAME_...
  bool is_endless = false;  ///< its axes run from then on: see Holdings
};

/// Whether several benches in real time act at once or on a tick that all of them can meet.
enum class Timing : std::uint8_t { at_once, common_tick };

/// What became of rounds.
struct Answers {
  Outcome outcome;
  std::uint64_t tick = 0;            ///< in which what was accepted is in force; 0 = nothing was
  std::vector<std::size_t> ignored;  ///< places of the axes that did not take their set-point
};

/// One call that commands one axis or several: their states, the commands to them, and the
/// deadline.
class AxesCall {
 public:
  AxesCall(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
           ObservedAxes::Progress progress = {});

  // ---- begin

  /// Connects only: see ObservedAxes::open.
  Outcome open() { return axes_.open(); }

  /// Connects and observes the axes for the first time.
  /// @param timeout drive time from then on
  Outcome begin(std::chrono::nanoseconds timeout);

  /// Takes control of every axis: after begin() and before the first command.
  /// @param by_force also of those that another session owns
  Outcome acquire(bool by_force = false);

  /// Both. @param objects of each axis, asked for on the way: see take_values()
  Outcome begin_control(std::chrono::nanoseconds timeout,
                        std::span<const ObjectAddress> objects = {});

  /// Counts the time-out anew from the present tick.
  void set_timeout(std::chrono::nanoseconds timeout);

  /// Commands of this call are in force at `tick`. In freerun the time-out counts from there: until
  /// a command arrives, such a bench may run minutes of drive time.
  void note_in_force(std::uint64_t tick);

  // ---- what is observed

  [[nodiscard]] ObservedAxes& axes() noexcept { return axes_; }

  [[nodiscard]] const ObservedAxes& axes() const noexcept { return axes_; }

  /// The axes as they were observed last, in the order of the group.
  [[nodiscard]] const std::vector<AxisSnapshot>& snapshots() const noexcept {
    return axes_.snapshots();
  }

  /// The first axis, the only one of a call of an axis.
  [[nodiscard]] const AxisSnapshot& snapshot() const { return axes_.snapshots().front(); }

  [[nodiscard]] std::uint64_t tick() const noexcept { return axes_.tick(); }

  /// What durations count in: see ObservedAxes.
  [[nodiscard]] std::uint64_t driven_tick() const noexcept { return axes_.driven_tick(); }

  [[nodiscard]] std::chrono::microseconds period() const { return axes_.period(); }

  [[nodiscard]] bool steps() const { return axes_.steps(); }

  /// The unit of an axis, for messages: see Discovery::unit_of.
  [[nodiscard]] Unit unit_of(const AxisId& axis) const { return core_->discovery.unit_of(axis); }

  /// @param user_units a position of the first axis [UU]
  /// @return it as messages tell it, such as "1024 UU (90.00 deg)".
  [[nodiscard]] std::string position_text(std::int64_t user_units) const;

  /// The same of a velocity [UU/s].
  [[nodiscard]] std::string velocity_text(std::int64_t user_units) const;

  /// Requires that every axis `fulfils` a condition, as it is now
  /// (ObservedAxes::look_again).
  /// @return refused with the first axis that does not
  Outcome require(bool (*fulfils)(const AxisSnapshot& axis), std::string_view command,
                  std::string_view needs);

  /// Objects of each axis, one row an axis.
  using Values = std::vector<std::vector<std::int64_t>>;

  Result<Values> read(std::span<const ObjectAddress> objects);

  /// @return the objects that begin_control() has asked for.
  Result<Values> take_values();

  // ---- commands

  /// @return a command that names the axis at `place` and carries nothing yet.
  [[nodiscard]] msg::AxisCommand command_to(std::size_t place) const;

  /// @return a round that carries nothing yet for every axis that `wanted` holds for.
  template <typename Wanted>
  [[nodiscard]] Round round_to(const Wanted& wanted) const {
    Round round;
    for (std::size_t place = 0; place < snapshots().size(); ++place) {
      if (wanted(snapshots()[place])) round.entries.push_back({place, command_to(place)});
    }
    return round;
  }

  /// @return the controlword `word` for every axis that `wanted` holds for.
  template <typename Wanted>
  [[nodiscard]] Round round_of(std::uint16_t word, const Wanted& wanted) const {
    Round round = round_to(wanted);
    for (Round::Entry& entry : round.entries) {
      entry.command.members = msg::HAS_DS402_CONTROLWORD;
      entry.command.ds402_controlword = word;
    }
    return round;
  }

  /// Sends rounds in order, one frame a round and bench, and collects the answers. No time passes
  /// in lock-step. With Timing::common_tick a refusal of one bench takes back what waits on the
  /// others; where that came too late `tick` is not 0.
  Answers exchange(std::span<const Round> rounds, Timing timing);

  /// Sends rounds in order, then observes the tick in which the last is in force; in lock-step
  /// steps to it. @return refused when a set-point was ignored.
  Outcome put_in_force(std::span<const Round> rounds);

  /// The first half of put_in_force(), which does not wait. The second half must follow.
  void begin_to_put_in_force(std::span<const Round> rounds);

  /// The second half.
  /// @param has_stepped in lock-step a call of this session has let a tick pass since: it is looked
  ///        at, and no further one passes
  Outcome await_in_force(bool has_stepped = false);

  /// The same with controlwords to every axis.
  Outcome put_in_force(const std::vector<std::uint16_t>& controlwords);

  /// Sends rounds, for their answers to be collected later.
  /// @param apply_at tick in which they are to be in force, 0 = the next
  /// @param sent one entry a bench, also of what was sent before a failure
  Outcome send(std::span<const Round> rounds, std::uint64_t apply_at,
               std::vector<SentFrames>& sent);

  /// Collects the answers to what was sent.
  Answers collect(std::span<const SentFrames> sent, Outcome outcome);

  /// By place: the last command of this call that ends what its axis did before; of a call without
  /// one, such as a resume, its first.
  [[nodiscard]] const std::vector<GivenCommand>& given() const noexcept { return given_; }

  /// This call waits for commands that an earlier call has given to axes of this session.
  void follow(std::vector<GivenCommand> given);

  // ---- waiting

  /// Observes tick by tick until `done` holds for every axis, at `from` or later.
  /// @param done of an AxisSnapshot, or of a place in the group
  /// @return timed_out at the deadline, naming the axes that are late.
  template <typename Done>
  Outcome await(std::string_view awaited, std::uint64_t from, const Done& done) {
    for (auto late = late_places(from, done); !late.empty(); late = late_places(from, done)) {
      if (Outcome seen = observe_next(awaited, late); !seen) return seen;
    }
    return {};
  }

  /// The same while every axis stays in Operation enabled. When one does not, or its service is
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

  /// Observes until `tick`, whatever the axes show.
  Outcome await_tick(std::string_view awaited, std::uint64_t tick);

  // ---- stopping

  /// Stops the others when an axis that was observed at `from` or later is not in Operation
  /// enabled, is that of another session by now, or has got another command than that of this call.
  /// @return refused when another session has taken an axis, failed when this session has given it
  ///         another command: what that axis does from then on is not what this call waits for, and
  ///         this call does not stop it
  Outcome check(std::string_view awaited, std::uint64_t from);

  /// This session had every axis before this call: check_owners() compares with that.
  void note_owned() { was_owner_.assign(was_owner_.size(), true); }

  /// @return failed when the axis at `place` is not in Operation enabled, or when this session has
  ///         given it another command than this call, naming it: then this call does not stop it
  [[nodiscard]] Outcome check_command(std::string_view awaited, std::size_t place);

  /// @return whether this session has the axis, by the bench and by its own knowledge.
  [[nodiscard]] bool has_control_of(const Target& target, const AxisSnapshot& axis) const {
    return axis.owner_session == core_->id && core_->control.holds(target, {&axis.id.axis, 1});
  }

  /// @return whether check_command() has seen another command on an axis in Operation enabled.
  [[nodiscard]] bool is_superseded() const;

  /// @return refused when another session has an axis that this session had, in a tick that this
  ///         call observed or before it.
  [[nodiscard]] Outcome check_owners();

  /// Quick stop of every axis in Operation enabled, save those that another session has taken or
  /// that have another command; observes them until all are at rest.
  /// @return `cause`.
  Outcome stop_others(Outcome cause);

  /// The same without waiting.
  /// @return `cause`; `stop` is what became of the quick stop.
  Outcome send_stop(Outcome cause, Answers& stop);

  /// stop_others() when `outcome` is the loss of a service; else nothing.
  Outcome stop_if_lost(Outcome outcome);

  /// Asks the service of an axis that has stopped or lost its power without a fault.
  /// @return lost when it shuts down, which takes the power of all its axes, or has ended
  [[nodiscard]] Outcome check_service(const AxisSnapshot& axis);

  /// @return `failed`; where check_service() knows the cause, that first.
  [[nodiscard]] Outcome explain_by_service(const Outcome& failed, const AxisSnapshot& axis);

  /// The same for an axis that is not in Operation enabled; for another one, `failed`.
  [[nodiscard]] Outcome explain_lost_power(const Outcome& failed, const AxisSnapshot& axis);

  /// The same for the first axis that is not in Operation enabled.
  [[nodiscard]] Outcome explain_lost_power(const Outcome& failed);

 private:
  /// @return the places of the axes that are not `done` at `from` or later.
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
  std::vector<bool> was_owner_;      ///< by place: whether this session had the axis in some tick
  std::vector<GivenCommand> given_;  ///< by place
  std::vector<bool> is_superseded_;  ///< by place
  std::vector<SentRequests> asked_;  ///< by ask(): one a bench
  std::size_t asked_objects_ = 0;
  std::vector<SentFrames> sent_;  ///< by begin_to_put_in_force(): with the outcome of the sending
  Outcome sending_;
};

}  // namespace vdrive::client
