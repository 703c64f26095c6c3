// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session_core.hpp"
#include "vdrive/client/axis.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// One call that commands one axis: its state, the commands to it, and the deadline.
class Conversation {
 public:
  /// @param timeout drive time from the first look on
  Conversation(std::shared_ptr<SessionCore> core, AxisId id, std::chrono::nanoseconds timeout);

  /// Connects, and looks for the first time.
  Outcome listen();

  /// Also takes control: before the first command.
  Outcome take_control();

  /// The axis as it was seen last.
  [[nodiscard]] const AxisSnapshot& now() const noexcept { return now_; }

  [[nodiscard]] PowerState state() const noexcept { return now_.state(); }

  /// Says these commands in order, one after another, then looks at the tick in which the last is
  /// in force. @return refused with 0x08000022 when a set-point was ignored.
  Outcome say(std::span<const msg::AxisCommand> commands);

  /// The same with controlwords alone.
  Outcome say(const std::vector<std::uint16_t>& controlwords);

  /// Looks at the next tick. @return timed_out, naming what was waited for, at the deadline.
  Outcome look(std::string_view awaited);

  /// Looks at `tick` or the first sample after it.
  Outcome look_at(std::uint64_t tick, std::string_view awaited);

  /// Looks until `condition` holds for the present snapshot.
  template <typename Condition>
  Outcome look_until(std::string_view awaited, const Condition& condition) {
    while (!condition(now_)) {
      if (Outcome outcome = look(awaited); !outcome) return outcome;
    }
    return {};
  }

  /// The same while Operation enabled lasts. @return failed when it does not.
  template <typename Condition>
  Outcome look_enabled_until(std::string_view awaited, const Condition& condition) {
    while (true) {
      if (state() != PowerState::operation_enabled) return ended(awaited);
      if (condition(now_)) return {};
      if (Outcome outcome = look(awaited); !outcome) return outcome;
    }
  }

  /// The value of one object now.
  Result<std::int64_t> read(ObjectAddress object);

  /// @return the refusal of a command that this power state does not allow.
  [[nodiscard]] Outcome not_now(std::string_view command, std::string_view hint) const;

  /// @return failed, with what the axis shows instead.
  [[nodiscard]] Outcome ended(std::string_view awaited) const;

  [[nodiscard]] const Target& target() const noexcept { return target_; }

  [[nodiscard]] const AxisId& id() const noexcept { return id_; }

 private:
  Outcome note(Result<Observation> sample);

  std::shared_ptr<SessionCore> core_;
  AxisId id_;
  std::chrono::nanoseconds timeout_;
  Target target_;
  std::optional<Follower> follower_;
  AxisSnapshot now_;
  std::uint64_t deadline_ = 0;  ///< tick
};

/// @return a command that writes the controlword only.
[[nodiscard]] msg::AxisCommand controlword_command(std::uint16_t axis, std::uint16_t word);

/// @return such as "shows 0x218 Fault, error 0x8611 following error".
[[nodiscard]] std::string what_it_shows(const AxisSnapshot& axis);

/// @return the refusal of a command that the axis' power state does not allow.
[[nodiscard]] Outcome refused_in_state(const AxisSnapshot& axis, std::string_view command,
                                       std::string_view hint);

}  // namespace vdrive::client
