// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "calls/axes_call.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// The limits of a move in profile position mode. The drive accepts 0 for each of them, and then
/// does not move, or moves with 1 UU/s².
inline constexpr std::array kMoveBounds = [] {
  using namespace literals;
  return std::array{
      kObjectRows["profile_velocity"_object].address, kObjectRows["profile_acc"_object].address,
      kObjectRows["profile_dec"_object].address,      kObjectRows["app_speed_limit"_object].address,
      kObjectRows["app_acc_limit"_object].address,    kObjectRows["app_dec_limit"_object].address};
}();

/// @return kMoveBounds followed by `kOthers`.
template <ObjectRow... kOthers>
[[nodiscard]] consteval auto move_bounds_and() {
  const std::array others{kObjectRows[kOthers].address...};
  std::array<ObjectAddress, kMoveBounds.size() + sizeof...(kOthers)> objects{};
  std::ranges::copy(others, std::ranges::copy(kMoveBounds, objects.begin()).out);
  return objects;
}

/// The objects that ProfileMove reads.
inline constexpr auto kMoveObjects = [] {
  using namespace literals;
  return move_bounds_and<"motor_speed_limit"_object, "positioning_option_code"_object,
                         "habit_controlword_loop"_object>();
}();

/// @param values of kMoveBounds, in this order
/// @return refused, naming the first object that is 0.
[[nodiscard]] Outcome check_bounds(const AxisId& axis, std::span<const std::int64_t> values);

/// @param unit of the axis
/// @return the refusal of a value that the drive would accept and never reach.
[[nodiscard]] Outcome above_limit(const AxisId& axis, const Unit& unit, std::string_view what,
                                  std::int64_t value, ObjectRow limit, std::int64_t limit_value,
                                  std::string_view remark = {});

/// The limits that a given speed is checked against.
struct SpeedLimits {
  std::int64_t app_speed_limit;    ///< 607Fh [UU/s]
  std::int64_t motor_speed_limit;  ///< 5E11h: 6080h converted to the same units [UU/s]
};

/// @param unit of the axis
/// @param velocity [UU/s]
/// @param what the quantity, for the message
/// @return refused, naming the limit, if the drive would accept the speed and never reach it.
[[nodiscard]] Outcome check_speed(const AxisId& axis, const Unit& unit, std::int64_t velocity,
                                  const SpeedLimits& limits, std::string_view what = "velocity");

/// One move of the only axis of a call, with the speed and the ramps given in the options.
class ProfileMove {
 public:
  /// @param call, wakeup, options must outlive this
  ProfileMove(AxesCall& call, const Wakeup& wakeup, const MoveOptions& options)
      : call_(call), wakeup_(wakeup), options_(options) {}

  /// Evaluates kMoveObjects, which `call` has requested.
  /// @return refused, with nothing changed, if the axis could not move.
  Outcome prepare();

  /// Hands over the set-point and waits until the drive has taken it. The old value of 6081h is
  /// restored immediately, because the drive samples it with the set-point; a drive that evaluates
  /// its controlword only once per loop gets it back after bit 12.
  Outcome start(std::int32_t target, bool relative);

  /// Waits until the axis is at its target; see await_target() in arrival.hpp.
  Outcome await_target();

  /// Clears bit 4 and, if the call waited for the target, restores the ramps.
  /// @return failed if it waited and the axis is at rest elsewhere: see check_arrival().
  Outcome finish();

 private:
  [[nodiscard]] Round set_point(std::int32_t target, bool relative) const;
  [[nodiscard]] Round old_velocity() const;
  [[nodiscard]] std::int32_t target_of(std::int32_t value, bool relative) const;
  bool add_old_ramps(Round& round) const;
  void put_back_ramps();
  Outcome await_acknowledge();
  Outcome await_next_edge();

  AxesCall& call_;
  const Wakeup& wakeup_;
  const MoveOptions& options_;
  std::vector<std::int64_t> before_;  ///< values of kMoveObjects before the move
  std::int32_t target_ = 0;           ///< absolute
  bool is_relative_ = false;
  bool wraps_ = false;                 ///< the move crosses the end of the position range
  bool has_controlword_loop_ = false;  ///< the drive evaluates 6040h once per loop: 5E20h:06
};

}  // namespace vdrive::client
