// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session_core.hpp"
#include "vdrive/client/axis_group.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::client {

/// Which axes form a group, and on which benches they are.
struct GroupLayout {
  struct Bench {
    std::uint32_t number = 0;
    std::vector<std::uint16_t> axes;
    std::vector<std::size_t> places;  ///< of these axes in the group
  };

  std::vector<AxisId> axes;  ///< in the order of the group
  std::vector<Bench> benches;
};

[[nodiscard]] inline bool is_enabled(const AxisSnapshot& axis) {
  return axis.state() == PowerState::operation_enabled;
}

/// @return the refusal of something that the state of a drive does not allow.
[[nodiscard]] Outcome not_in_this_state(std::string message);

/// What one frame for each bench says: commands to axes by their place in the group.
struct Round {
  struct Word {
    std::size_t place;
    msg::AxisCommand command;
  };

  std::vector<Word> words;
  std::uint32_t flags = 0;  ///< FRAME_...
};

/// Whether several benches in real time act at once or on a tick that all of them can meet.
enum class Timing : std::uint8_t { at_once, common_tick };

/// What became of rounds.
struct Told {
  Outcome outcome;
  std::uint64_t tick = 0;            ///< in which what was accepted is in force; 0 = nothing was
  std::vector<std::size_t> ignored;  ///< places of the axes that did not take their set-point
};

/// One call that commands a group: the states of its axes, the commands to them, and the deadline.
/// The counterpart of Conversation for axes on several benches.
class GroupTalk {
 public:
  GroupTalk(std::shared_ptr<SessionCore> core, const GroupLayout& layout,
            std::function<void(std::uint64_t tick, std::span<const AxisSnapshot>)> observer);

  /// Connects to every bench, compares their clocks, and looks for the first time.
  Outcome listen(std::chrono::nanoseconds timeout);

  /// Takes control of every axis that was listened to: before the first command.
  Outcome acquire();

  /// Listens and takes control.
  Outcome take_control(std::chrono::nanoseconds timeout);

  /// Ends calls that wait for a sample with `failed` once this is requested.
  void stop_by(std::stop_token stop) { stop_ = std::move(stop); }

  /// Counts the time-out anew from the present tick.
  void set_timeout(std::chrono::nanoseconds timeout);

  /// The axes as they were seen last, in the order of the group.
  [[nodiscard]] const std::vector<AxisSnapshot>& now() const noexcept { return now_; }

  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  [[nodiscard]] std::chrono::microseconds period() const { return lines_.front().target.period; }

  [[nodiscard]] bool steps() const { return lines_.front().target.steps(); }

  /// Says rounds in order, one frame a round and bench, and collects the answers. No time passes in
  /// lock-step. With Timing::common_tick a refusal of one bench takes back what waits on the
  /// others; where that came too late `tick` is not 0.
  Told tell(std::span<const Round> rounds, Timing timing);

  /// Looks at the next tick. @return timed_out at the deadline, naming the axes that are `late`.
  template <typename Late>
  Outcome look(std::string_view awaited, const Late& late) {
    if (tick_ < deadline_) return advance(1);
    std::vector<std::size_t> places;
    for (std::size_t place = 0; place < now_.size(); ++place) {
      if (late(place)) places.push_back(place);
    }
    return timed_out(awaited, places);
  }

  /// Looks until `done` holds for every axis, at `from` or later.
  template <typename Done>
  Outcome look_until(std::string_view awaited, std::uint64_t from, const Done& done) {
    const auto late = [&](std::size_t place) {
      return tick_ < from || !done(place);
    };
    while (any(late)) {
      if (Outcome seen = look(awaited, late); !seen) return seen;
    }
    return {};
  }

  /// The same while every axis stays in Operation enabled. When one does not, or its service falls
  /// silent, the others are stopped.
  template <typename Done>
  Outcome look_enabled_until(std::string_view awaited, std::uint64_t from, const Done& done) {
    const auto late = [&](std::size_t place) {
      return tick_ < from || !done(place);
    };
    while (true) {
      if (Outcome sound = check(awaited, from); !sound) return sound;
      if (!any(late)) return {};
      if (Outcome seen = look(awaited, late); !seen) return stop_if_lost(std::move(seen));
    }
  }

  /// Stops the others when an axis seen at `from` or later is not in Operation enabled.
  Outcome check(std::string_view awaited, std::uint64_t from);

  /// Quick stop of every axis in Operation enabled, and what it shows until all are at rest.
  /// @return `cause`.
  Outcome stop_others(Outcome cause);

  /// The same without waiting. @return `cause`; `stop` says what became of the quick stop.
  Outcome say_stop(Outcome cause, Told& stop);

  /// The same when `outcome` says that a service is lost; else nothing.
  Outcome stop_if_lost(Outcome outcome);

  /// Lets the axes in Quick stop active come to rest.
  Outcome await_quick_stops();

  /// Advances to the next tick that all benches show; in lock-step by `ticks`.
  Outcome advance(std::uint64_t ticks);

  /// Objects of each axis, one row an axis.
  Result<std::vector<std::vector<std::int64_t>>> read(std::span<const ObjectAddress> objects);

  /// A command that names the axis at `place` and carries nothing yet.
  [[nodiscard]] msg::AxisCommand command_to(std::size_t place) const;

  /// The controlword `word` for every axis that `wanted` holds for.
  template <typename Wanted>
  [[nodiscard]] Round round_of(std::uint16_t word, const Wanted& wanted) const {
    Round round;
    for (std::size_t place = 0; place < now_.size(); ++place) {
      if (!wanted(now_[place])) continue;
      msg::AxisCommand command = command_to(place);
      command.members(msg::HAS_DS402_CONTROLWORD);
      command.ds402_controlword(word);
      round.words.push_back({place, std::move(command)});
    }
    return round;
  }

  /// Sends a round, for its answers to be collected later.
  Outcome send(const Round& round, std::uint64_t apply_at, std::vector<SentFrames>& sent);

  /// Collects the answers to what was sent.
  Told collect(std::span<const SentFrames> sent, Outcome outcome);

  /// The newest tick that any bench has been heard of at.
  Result<std::uint64_t> newest_tick();

 private:
  /// One bench of the group.
  struct Line {
    const GroupLayout::Bench* bench = nullptr;
    Target target;
    std::shared_ptr<StatusFeed> feed;  ///< none in lock-step
    Observation seen;
    bool is_lost = false;
  };

  template <typename Condition>
  [[nodiscard]] bool any(const Condition& condition) const {
    for (std::size_t place = 0; place < now_.size(); ++place) {
      if (condition(place)) return true;
    }
    return false;
  }

  Outcome connect();
  Outcome compare_clocks() const;
  Outcome next(Line& line);
  Outcome align();
  Outcome look_at_streams();
  Outcome await_common_ticks();
  Outcome catch_up(Line& line);
  static std::string axes_of(const Line& line);
  static Outcome note_lost(Line& line, Outcome outcome);
  static Outcome note(Line& line, Result<Observation> sample);
  [[nodiscard]] static std::vector<msg::Request> read_requests(
      const Line& line, std::span<const ObjectAddress> objects);
  static void note_ignored(const Line& line, std::span<const std::uint16_t> axes, Told& told);
  void publish();
  Told tell_at(std::span<const Round> rounds, std::uint64_t apply_at);
  void cancel_pending();
  [[nodiscard]] bool is_heard(const AxisSnapshot& axis) const;
  [[nodiscard]] Outcome timed_out(std::string_view awaited,
                                  std::span<const std::size_t> late) const;

  std::shared_ptr<SessionCore> core_;
  const GroupLayout& layout_;
  std::function<void(std::uint64_t, std::span<const AxisSnapshot>)> observer_;
  std::vector<Line> lines_;
  std::vector<AxisSnapshot> now_;
  std::uint64_t tick_ = 0;
  std::uint64_t deadline_ = 0;
  std::stop_token stop_;
};

}  // namespace vdrive::client
