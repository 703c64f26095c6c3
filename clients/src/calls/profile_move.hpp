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

/// What bounds a move in profile position mode. The drive takes 0 for each of them, and does not
/// move then, or with 1 UU/s².
inline constexpr std::array kMoveBounds = [] {
  using namespace literals;
  return std::array{
      kObjectRows["profile_velocity"_object].address, kObjectRows["profile_acc"_object].address,
      kObjectRows["profile_dec"_object].address,      kObjectRows["app_speed_limit"_object].address,
      kObjectRows["app_acc_limit"_object].address,    kObjectRows["app_dec_limit"_object].address};
}();

/// @return kMoveBounds, then these.
template <ObjectRow... kOthers>
[[nodiscard]] consteval auto move_bounds_and() {
  const std::array others{kObjectRows[kOthers].address...};
  std::array<ObjectAddress, kMoveBounds.size() + sizeof...(kOthers)> objects{};
  std::ranges::copy(others, std::ranges::copy(kMoveBounds, objects.begin()).out);
  return objects;
}

/// What ProfileMove reads.
inline constexpr auto kMoveObjects = [] {
  using namespace literals;
  return move_bounds_and<"motor_speed_limit"_object, "positioning_option_code"_object,
                         "habit_controlword_loop"_object>();
}();

/// @param values of kMoveBounds, in this order
/// @return refused, naming the first of them that is 0.
[[nodiscard]] Outcome check_bounds(const AxisId& axis, std::span<const std::int64_t> values);

/// @param unit of the axis
/// @return the refusal of a value that the drive would accept and never reach.
[[nodiscard]] Outcome above_limit(const AxisId& axis, const Unit& unit, std::string_view what,
                                  std::int64_t value, ObjectRow limit, std::int64_t limit_value,
                                  std::string_view remark = {});

/// What a speed that a call gives is compared with.
struct SpeedLimits {
  std::int64_t app_speed_limit;    ///< 607Fh [UU/s]
  std::int64_t motor_speed_limit;  ///< 5E11h: 6080h in the same units [UU/s]
};

/// @param unit of the axis
/// @param velocity [UU/s]
/// @param what it is, for the message
/// @return refused where the drive would accept the speed and never reach it, naming the limit.
[[nodiscard]] Outcome check_speed(const AxisId& axis, const Unit& unit, std::int64_t velocity,
                                  const SpeedLimits& limits, std::string_view what = "velocity");

/// One move of the only axis of a call, with the speed and the ramps that the options give for it.
class ProfileMove {
 public:
  /// @param call, wakeup, options outlive this
  ProfileMove(AxesCall& call, const Wakeup& wakeup, const MoveOptions& options)
      : call_(call), wakeup_(wakeup), options_(options) {}

  /// Takes what the drive has: `call` has asked for kMoveObjects. @return refused where the axis
  /// could not move, with nothing changed.
  Outcome prepare();

  /// Hands the set-point over, and waits until the drive has taken it. 6081h, which the drive takes
  /// with the set-point, has its old value again at once; after bit 12 where the drive looks
  /// seldom.
  Outcome start(std::int32_t target, bool relative);

  /// Waits until the axis is at its target; see await_target of arrival.hpp.
  Outcome await_target();

  /// Drops bit 4. @return failed where the axis rests elsewhere: see check_arrival of arrival.hpp.
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
  std::vector<std::int64_t> before_;  ///< values of kMoveObjects, before the move
  std::int32_t target_ = 0;           ///< absolute
  bool is_relative_ = false;
  bool wraps_ = false;                 ///< the way to it leads through the end of the register
  bool looks_once_in_a_loop_ = false;  ///< the drive, at 6040h: 5E20h:06
};

}  // namespace vdrive::client
