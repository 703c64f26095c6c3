// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/control_model.hpp"
#include "simulation/happenings.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/power_state.hpp"

#include <chrono>
#include <cstdint>

namespace vdrive::simulation {

/// Limits of an axis, in force from its power-up to the end.
struct AxisLimits {
  std::int64_t speed = 136'533;      ///< 607Fh, or 6080h where that is lower [UU/s]
  bool has_range = false;            ///< 3535h
  std::int64_t lower = 0;            ///< 607Dh:01 [UU]
  std::int64_t upper = 0;            ///< 607Dh:02 [UU]
  std::int64_t positive_torque = 0;  ///< the lower of 6072h and 60E0h [per mille]
  std::int64_t negative_torque = 0;
  int abort_connection = 1;  ///< 6007h
};

/// Checks one axis in every tick, from outside.
class AxisWatch {
 public:
  AxisWatch(std::uint16_t number, const AxisLimits& limits, std::chrono::microseconds period)
      : number_(number),
        limits_(limits),
        period_s_(std::chrono::duration<double>(period).count()) {}

  /// @param state in which the axis is
  void check(const AxisStatus& now, PowerState state, const AxisCauses& causes,
             const Registers& registers, bool restored, Happenings& happenings);

  /// The following checks start again from `now`.
  void begin(const AxisStatus& now, PowerState state);

 private:
  void check_jump(const AxisStatus& now, const Registers& registers, bool commanded,
                  Happenings& happenings) const;
  void check_rest(const AxisStatus& now, Happenings& happenings);
  [[nodiscard]] bool brakes_at_its_limit(const AxisStatus& now) const;
  void check_speed(const AxisStatus& now, Happenings& happenings);
  void check_range(const AxisStatus& now, bool commanded, Happenings& happenings);
  void check_torque(const AxisStatus& now, Happenings& happenings) const;
  void check_state(const AxisStatus& now, PowerState state, const AxisCauses& causes,
                   Happenings& happenings) const;

  std::uint16_t number_;
  AxisLimits limits_;
  double period_s_;
  AxisStatus last_;
  PowerState last_state_ = PowerState::switch_on_disabled;
  bool has_test_input_ = false;
  bool had_test_input_ = false;   ///< in the tick before
  bool is_contained_ = false;     ///< the demand began within 607Dh and was never led outside
  double calm_s_ = 0.0;           ///< for how long nothing but the drive moved the axis
  std::int64_t rest_speed_ = -1;  ///< without power: the speed that is not exceeded; below 0 = none
};

}  // namespace vdrive::simulation
