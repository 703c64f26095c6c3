// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "calls/axes_call.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::client {

inline constexpr std::string_view kTargetReached = "target reached, bit 10";

/// 6040h, for AxesCall::read().
inline constexpr std::array kControlwordObject = [] {
  using namespace literals;
  return std::array{kObjectRows["ds402_controlword"_object].address};
}();

/// @return failed when 6040h = `word` halts the axis.
[[nodiscard]] Outcome outcome_of_halt(const AxisSnapshot& axis, std::uint16_t word);

/// @return the outcome of an interrupted wait: the axis continues to its target, unless its bench
/// ends with the program.
[[nodiscard]] Outcome goes_on_to_target(const AxisSnapshot& axis);

/// Bit 10 also shows that an axis which was halted, by this session or another one, stands still:
/// 6040h shows which it is.
/// @return failed when the axis is halted.
Outcome check_halt(AxesCall& call);

/// Notes in each tick that is observed whether a limit switch lies in the way of an axis. The drive
/// gives its target up in such a tick, for good: the switch may open again.
class LimitSwitchWatch {
 public:
  /// @param way its sign is the direction to the target, 0 = none
  void note(const AxisSnapshot& axis, std::int64_t way);

  /// @return whether the target was given up and the demand stands: nothing more comes.
  [[nodiscard]] bool has_ended(const AxisSnapshot& axis) const;

  /// @param unit of the axis
  /// @param what such as "the move to 1000 UU"
  /// @return failed, naming the switch, when the target was given up.
  [[nodiscard]] Outcome outcome(const AxisSnapshot& axis, const Unit& unit,
                                const std::string& what) const;

 private:
  std::string_view input_;  ///< that lies in the way, empty = none
};

/// @return failed when a limit switch keeps an axis of the call that stands from a target.
[[nodiscard]] Outcome check_limit_switch(const AxesCall& call, const AxisSnapshot& axis,
                                         std::int32_t target);

/// @param at_rest the axis in the tick that has shown its arrival
/// @param target absolute
/// @param is_exact whether the axis has nowhere else to rest
/// @return failed where a software limit has cut the move off, or where the axis rests elsewhere.
[[nodiscard]] Outcome check_arrival(AxesCall& call, const AxisSnapshot& at_rest,
                                    std::int32_t target, bool is_exact = true);

/// A set-point of profile position mode ends with the mode, and with the control of its axis.
/// @return failed when the axis shows that either has ended since.
[[nodiscard]] Outcome check_set_point(const AxisSnapshot& axis);

/// Waits until the axis is at its target.
/// @param target absolute, none where it is not known: then a limit switch is seen by the speed
/// @param from tick in which the drive has the set-point
/// @return failed also when it was halted on the way, when a limit switch or another command has
///         ended the motion, and when the wait was interrupted: then it continues.
Outcome await_target(AxesCall& call, const Wakeup& wakeup, std::optional<std::int32_t> target,
                     std::uint64_t from);

}  // namespace vdrive::client
