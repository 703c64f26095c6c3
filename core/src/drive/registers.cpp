// SPDX-License-Identifier: Apache-2.0
#include "drive/registers.hpp"

#include "rounding.hpp"

#include <algorithm>
#include <cstddef>

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
  limits.placed = reg(drive, "test_switch_negative_limit"_object) != ends.lowest ||
                  reg(drive, "test_switch_positive_limit"_object) != ends.highest ||
                  reg(drive, "test_switch_home_length"_object) != 0;
  limits.inputs = active_inputs(drive);
}

/// The position that the switches see: the exact position of the load in the units of 6064h,
/// relative to where 6064h was 0 when the bank started. With one encoder 6064h counts the motor, so
/// the position of the load is converted to that of the motor.
double machine_position(const Drive& drive) {
  const ServoState& servo = drive.servo();
  const DriveRegisters& r = drive.registers();
  const std::size_t l = drive.lane();
  return r.single_encoder
             ? (servo.load_position[l] - servo.load_offset[l]) / r.gear_ratio - r.origins.motor
             : servo.load_position[l] - r.origins.load;
}

/// On a modulo axis the home switch recurs in every turn of the range.
/// @return whether the home switch has a position and is active at `position`.
bool is_on_home_switch(const Drive& drive, double position) {
  const double begin = real(drive, "test_switch_home"_object);
  const double length = real(drive, "test_switch_home_length"_object);
  const double span = drive.registers().range.span;
  const double place =
      span > 0.0 ? position - span * floor_of((position - begin) / span) : position;
  return length != 0.0 && place >= begin && place <= begin + length;
}

/// @return the bits of 60FDh of the switches that have a position.
unsigned switches_at(const Drive& drive, double position) {
  const TypeRange none = range_of(DataType::integer32);
  const std::int64_t negative = reg(drive, "test_switch_negative_limit"_object);
  const std::int64_t positive = reg(drive, "test_switch_positive_limit"_object);
  const bool is_negative = negative != none.lowest && position <= static_cast<double>(negative);
  const bool is_positive = positive != none.highest && position >= static_cast<double>(positive);
  return (is_negative ? kNegativeLimitInput : 0U) | (is_positive ? kPositiveLimitInput : 0U) |
         (is_on_home_switch(drive, position) ? kHomeInput : 0U);
}

/// Limits 607Bh in the right order make the axis a modulo axis. The full range of the register
/// counts as no range.
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

void update_frozen_feedback(Drive& drive) {
  const std::uint64_t lane = std::uint64_t{1} << drive.lane();
  std::uint64_t& frozen = drive.block().frozen;
  frozen = reg(drive, "test_frozen_feedback"_object) != 0 ? frozen | lane : frozen & ~lane;
}

}  // namespace

void update_derived(Drive& drive) noexcept {
  update_windows(drive);
  update_range(drive);
  update_limits(drive);
  update_frozen_feedback(drive);
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

std::uint8_t active_inputs(const Drive& drive) noexcept {
  const unsigned set =
      (reg(drive, "test_negative_limit_input"_object) != 0 ? kNegativeLimitInput : 0U) |
      (reg(drive, "test_positive_limit_input"_object) != 0 ? kPositiveLimitInput : 0U) |
      (reg(drive, "test_home_input"_object) != 0 ? kHomeInput : 0U);
  const bool placed = drive.state().limits.placed;
  return static_cast<std::uint8_t>(set |
                                   (placed ? switches_at(drive, machine_position(drive)) : 0U));
}

std::optional<double> index_pulse_passed(const Drive& drive, double direction, double before,
                                         double now) noexcept {
  const double offset = drive.registers().index.offset;
  const auto revolutions = [direction, offset](double reading) {
    return direction * (reading - offset) / kUserUnitsPerRevolution;
  };
  const double pulse = floor_of(revolutions(before)) + 1.0;
  if (pulse > revolutions(now)) return std::nullopt;
  return direction * pulse * kUserUnitsPerRevolution + offset;
}

}  // namespace vdrive
