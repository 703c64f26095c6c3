// SPDX-License-Identifier: Apache-2.0
#include "drive/registers.hpp"

#include <algorithm>

namespace vdrive {
namespace {

using namespace vdrive::literals;

void update_windows(Drive& drive) {
  WindowState& window = drive.state().window;
  window.position = unsigned_reg(drive, "position_target_reached_window"_object);
  window.position_ticks =
      ticks_of_ms(drive, reg(drive, "position_target_reached_window_time"_object));
  window.velocity = unsigned_reg(drive, "velocity_window"_object);
  window.velocity_ticks = ticks_of_ms(drive, reg(drive, "velocity_window_time"_object));
  window.threshold = unsigned_reg(drive, "velocity_threshold"_object);
  window.threshold_ticks = ticks_of_ms(drive, reg(drive, "velocity_threshold_time"_object));
  FollowingErrorState& error = drive.state().following_error;
  error.window = unsigned_reg(drive, "following_error_window"_object);
  error.ticks = ticks_of_ms(drive, reg(drive, "following_error_time_out"_object));
}

void update_limits(Drive& drive) {
  LimitState& limits = drive.state().limits;
  const std::int64_t lower = reg(drive, "user_position_lower_limit"_object);
  const std::int64_t upper = reg(drive, "user_position_upper_limit"_object);
  const TypeRange ends = range_of(DataType::integer32);
  const bool whole_range = lower == ends.lowest && upper == ends.highest;
  limits.lower = static_cast<double>(lower);
  limits.upper = static_cast<double>(upper);
  limits.enabled = reg(drive, "app_position_limit_switch"_object) != 0 && lower < upper &&
                   !whole_range && (limits.homed || !drive.registers().settings.limits_need_homing);
  limits.inputs = static_cast<std::uint8_t>(
      (reg(drive, "test_negative_limit_input"_object) != 0 ? kNegativeLimitInput : 0U) |
      (reg(drive, "test_positive_limit_input"_object) != 0 ? kPositiveLimitInput : 0U) |
      (reg(drive, "test_home_input"_object) != 0 ? kHomeInput : 0U));
}

/// 607Bh makes a modulo axis of one whose limits are in order. The whole range of the register is
/// the one that every axis has.
void update_range(Drive& drive) {
  const std::int64_t lower = reg(drive, "min_position_range_limit"_object);
  const std::int64_t upper = reg(drive, "max_position_range_limit"_object);
  const TypeRange ends = range_of(DataType::integer32);
  const bool has_range = lower < upper && !(lower == ends.lowest && upper == ends.highest);
  drive.registers().range = has_range ? PositionRange{.lower = static_cast<double>(lower),
                                                      .span = static_cast<double>(upper - lower)}
                                      : PositionRange{};
  const std::uint64_t lane = std::uint64_t{1} << drive.lane();
  std::uint64_t& modulo = drive.block().modulo;
  modulo = has_range ? modulo | lane : modulo & ~lane;
}

}  // namespace

void update_derived(Drive& drive) noexcept {
  update_windows(drive);
  update_limits(drive);
  update_range(drive);
  DriveState& s = drive.state();
  drive.block().units.rated_current[drive.lane()] = real(drive, "motor_rated_current"_object);
  drive.servo().blocked[drive.lane()] = reg(drive, "test_blocked_load"_object) != 0 ? 1.0 : 0.0;
  s.attention = true;
  s.plan_due = true;
}

void update_velocity_cap(Drive& drive) noexcept {
  DriveRegisters& registers = drive.registers();
  registers.velocity_cap =
      std::min(registers.speed_limits.app_speed_limit,
               velocity_of_motor(drive, registers.speed_limits.motor_max_speed_rpm));
  drive.servo().speed_limit[drive.lane()] = registers.velocity_cap;
}

}  // namespace vdrive
