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
  int abort_connection = 1;      ///< 6007h
  double jerk = 0.0;             ///< the higher one of 60A4h in use [UU/s³]; 0 = not checked
  std::int64_t range_lower = 0;  ///< 607Bh:01 [UU]
  std::int64_t range_span = 0;   ///< 607Bh:02 less 607Bh:01 [UU]; 0 = no modulo axis
  bool is_pushed = false;        ///< its plant moves it without power, or seems to
  double delay = 0.0;            ///< by which 5E20h holds back what a word commands, at most [s]
  std::int64_t maker_bits = 0;   ///< 5E20h:0C
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
  [[nodiscard]] std::int64_t way(std::int32_t from, std::int32_t to) const;
  void check_rest(const AxisStatus& now, Happenings& happenings);
  [[nodiscard]] bool brakes_at_its_limit(const AxisStatus& now) const;
  void check_speed(const AxisStatus& now, Happenings& happenings);
  [[nodiscard]] bool may_be_rounded(const AxisStatus& now, const AxisCauses& causes) const;
  void check_jerk(const AxisStatus& now, const AxisCauses& causes, Happenings& happenings);
  void check_range(const AxisStatus& now, bool commanded, Happenings& happenings);
  void check_modulo(const AxisStatus& now, Happenings& happenings) const;
  void check_torque(const AxisStatus& now, Happenings& happenings) const;
  void check_state(const AxisStatus& now, PowerState state, const AxisCauses& causes,
                   bool commanded, Happenings& happenings) const;

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
  double since_word_s_ = 0.0;     ///< since the last controlword, or the begin
  std::int64_t last_change_ = 0;  ///< of 606Bh in the last tick [UU/s]
  int standing_ticks_ = 0;        ///< for how long the demand of a profile has stood
  bool is_rounded_ = false;       ///< nothing but profiles led the demand since it stood
};

}  // namespace vdrive::simulation
