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

/// @return failed if 6040h = `word` halts the axis.
[[nodiscard]] Outcome outcome_of_halt(const AxisSnapshot& axis, std::uint16_t word);

/// @return the outcome of an interrupted wait: the axis continues to its target, unless its bench
///         ends with the program.
[[nodiscard]] Outcome continues_to_target(const AxisSnapshot& axis);

/// Bit 10 is also set when an axis stands still because this or another session halted it; 6040h
/// tells the two cases apart.
/// @return failed if the axis is halted.
Outcome check_halt(AxesCall& call);

/// Records, in each observed tick, whether a limit switch blocks the way of an axis. In such a tick
/// the drive abandons its target for good, even if the switch opens again.
class LimitSwitchWatch {
 public:
  /// @param way the sign is the direction to the target, 0 = none
  void note(const AxisSnapshot& axis, std::int64_t way);

  /// @return whether the target was abandoned and the demand is at rest: nothing more will happen.
  [[nodiscard]] bool has_ended(const AxisSnapshot& axis) const;

  /// @param unit of the axis
  /// @param what the motion, such as "the move to 1000 UU"
  /// @return failed, naming the switch, if the target was abandoned.
  [[nodiscard]] Outcome outcome(const AxisSnapshot& axis, const Unit& unit,
                                const std::string& what) const;

 private:
  std::string_view input_;  ///< the one that blocks the way, empty = none
};

/// @return failed if a limit switch keeps a stationary axis of the call from its target.
[[nodiscard]] Outcome check_limit_switch(const AxesCall& call, const AxisSnapshot& axis,
                                         std::int32_t target);

/// @param at_rest the axis in the tick in which it arrived
/// @param target absolute
/// @param is_exact false: the axis may also come to rest elsewhere, because `target` may be wrong
/// @return failed if a software limit cut the move short, or if `is_exact` and the axis is at rest
///         elsewhere.
[[nodiscard]] Outcome check_arrival(AxesCall& call, const AxisSnapshot& at_rest,
                                    std::int32_t target, bool is_exact = true);

/// A set-point of profile position mode is void once the axis has left the mode or this session has
/// lost control of the axis.
/// @return failed if the axis shows that one of these has happened.
[[nodiscard]] Outcome check_set_point(const AxisSnapshot& axis);

/// Waits until the axis is at its target.
/// @param target absolute; none if unknown: then the direction of motion selects the limit switch
///        to watch
/// @param from tick from which on the drive has the set-point
/// @return failed also if it was halted on the way, if a limit switch or another command ended the
///         motion, or if the wait was interrupted: in that case the motion continues.
Outcome await_target(AxesCall& call, const Wakeup& wakeup, std::optional<std::int32_t> target,
                     std::uint64_t from);

}  // namespace vdrive::client
