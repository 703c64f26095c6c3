// SPDX-License-Identifier: Apache-2.0
//
// Writes and reads of objects, and what they mean to the axis.
#include "drive/demand.hpp"
#include "drive/homing.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"

#include <cstddef>

namespace vdrive {
namespace {

using namespace vdrive::literals;

std::uint32_t unsigned_reg(const DriveContext& axis, ObjectRow row) {
  return static_cast<std::uint32_t>(reg(axis, row));
}

/// Bit 4 starts a homing run, bit 8 ends it for good.
void command_homing(const DriveContext& axis, std::uint16_t previous, bool accepting) {
  DriveState& s = axis.state;
  if (halted(axis)) {
    interrupt_homing(axis);
  }
  const bool rising = (s.controlword & ~previous & Controlword::kStartHoming) != 0;
  if (!rising) {
    return;
  }
  if (accepting && !halted(axis) && start_homing(axis)) {
    s.target.fresh = true;
  } else {
    ++s.ignored_set_points;
  }
}

void command_set_point(const DriveContext& axis, std::uint16_t previous, bool accepting) {
  DriveState& s = axis.state;
  const std::uint16_t word = s.controlword;
  const SetPoint candidate{
      .position_user_target_value =
          static_cast<std::int32_t>(reg(axis, "position_user_target_value"_object)),
      .profile_velocity = unsigned_reg(axis, "profile_velocity"_object),
      .synchronous_move_duration = unsigned_reg(axis, "synchronous_move_duration"_object),
      .synchronous_move_acceleration_time =
          unsigned_reg(axis, "synchronous_move_acceleration_time"_object),
      .synchronous_move_deceleration_time =
          unsigned_reg(axis, "synchronous_move_deceleration_time"_object),
      .relative = (word & Controlword::kRelative) != 0};
  // What waits for its turn is judged when it comes: its start is not known before.
  const bool waits = s.set_points.active && (word & Controlword::kChangeSetImmediately) == 0;
  const bool startable = accepting && (waits || can_start(axis, candidate));
  switch (
      s.set_points.queue.controlword(word, previous, startable, s.set_points.active, candidate)) {
    case SetPointOutcome::started:
      start_set_point(axis, candidate);
      s.target.fresh = true;
      break;
    case SetPointOutcome::buffered:
      s.target.fresh = true;
      break;
    case SetPointOutcome::ignored:
      ++s.ignored_set_points;
      break;
    case SetPointOutcome::none:
      break;
  }
}

void write_controlword(const DriveContext& axis, std::uint16_t word) {
  DriveState& s = axis.state;
  const std::uint16_t previous = s.controlword;
  const bool ready_before =
      operation_enabled(axis) && s.power.machine.pending() == PowerCommand::none;
  s.controlword = word;
  act(axis,
      s.power.machine.command(decode_command(word, previous), power_options(axis),
                              reg(axis, "test_dc_link_loss"_object) == 0, cause_present(axis)));
  const bool accepting = ready_before && operation_enabled(axis) &&
                         s.power.machine.pending() == PowerCommand::none &&
                         s.mode.wanted == s.mode.actual;
  if (s.mode.actual == OperatingMode::homing) {
    command_homing(axis, previous, accepting);
  } else {
    command_set_point(axis, previous,
                      accepting && s.mode.actual == OperatingMode::profile_position &&
                          (!halted(axis) || axis.registers.settings.acknowledge_while_halted));
  }
  s.plan_due = true;
  s.attention = true;
}

/// A target of profile velocity or torque was written: in its mode it replaces what a limit switch
/// has given up.
void take_target(const DriveContext& axis, OperatingMode mode) {
  DriveState& s = axis.state;
  s.target.given_up = s.target.given_up && s.mode.actual != mode;
  s.plan_due = true;
}

/// Rows that refuse what they do not mean with 0x06090030, also beyond the range that they show.
bool is_judged_by_meaning(ObjectRow row) {
  return row == "error_history_count"_object || row == "homing_method"_object;
}

bool is_request(ObjectRow row) {
  return row == "store_all_parameters"_object || row == "restore_all_default_parameters"_object;
}

bool is_within_type(ObjectRow row, std::int64_t value) {
  const TypeRange type = range_of(describe(row).data_type);
  return value >= type.lowest && value <= type.highest;
}

/// The narrower rules of single objects, for a value within its type.
AbortCode check_value(ObjectRow row, std::int64_t value) {
  switch (row) {
    case "op_mode_cmd"_object:
      return is_operating_mode(value) ? AbortCode::none : AbortCode::value_range_exceeded;
    case "homing_method"_object:
      return is_homing_method(value) ? AbortCode::none : AbortCode::value_range_exceeded;
    case "positioning_option_code"_object:
      return value <= 2 ? AbortCode::none : AbortCode::value_range_exceeded;
    case "error_history_count"_object:
      return value == 0 ? AbortCode::none : AbortCode::value_range_exceeded;
    case "store_all_parameters"_object:
      return value == kStoreSignature ? AbortCode::none : AbortCode::cannot_store_or_transfer;
    case "restore_all_default_parameters"_object:
      return value == kRestoreSignature ? AbortCode::none : AbortCode::cannot_store_or_transfer;
    default:
      return AbortCode::none;
  }
}

WriteEffect effect_of(ObjectRow row) {
  switch (row) {
    case "gear_ratio_numerator"_object:
    case "gear_ratio_denominator"_object:
      return WriteEffect::gear;
    case "positive_torque_limit_relative"_object:
    case "negative_torque_limit_relative"_object:
    case "max_torque"_object:
    case "motor_rated_torque"_object:
    case "motor_rated_current"_object:
    case "test_load_torque"_object:
      return WriteEffect::torque_limits;
    default:
      return WriteEffect::none;
  }
}

}  // namespace

void update_derived(const DriveContext& axis) noexcept {
  DriveState& s = axis.state;
  s.window.position =
      static_cast<std::uint32_t>(reg(axis, "position_target_reached_window"_object));
  s.window.position_ticks =
      ticks_of_ms(axis, reg(axis, "position_target_reached_window_time"_object));
  s.following_error.window = static_cast<std::uint32_t>(reg(axis, "following_error_window"_object));
  s.following_error.ticks = ticks_of_ms(axis, reg(axis, "following_error_time_out"_object));
  s.window.threshold = static_cast<std::uint32_t>(reg(axis, "velocity_threshold"_object));
  s.window.threshold_ticks = ticks_of_ms(axis, reg(axis, "velocity_threshold_time"_object));
  s.window.velocity = static_cast<std::uint32_t>(reg(axis, "velocity_window"_object));
  s.window.velocity_ticks = ticks_of_ms(axis, reg(axis, "velocity_window_time"_object));
  s.units.rated_current = real(axis, "motor_rated_current"_object);
  const std::int64_t lower = reg(axis, "user_position_lower_limit"_object);
  const std::int64_t upper = reg(axis, "user_position_upper_limit"_object);
  const TypeRange ends = range_of(DataType::integer32);
  const bool whole_range = lower == ends.lowest && upper == ends.highest;
  s.limits.lower = static_cast<double>(lower);
  s.limits.upper = static_cast<double>(upper);
  s.limits.enabled = reg(axis, "app_position_limit_switch"_object) != 0 && lower < upper &&
                     !whole_range &&
                     (s.limits.homed || !axis.registers.settings.limits_need_homing);
  s.limits.inputs = static_cast<std::uint8_t>(
      (reg(axis, "test_negative_limit_input"_object) != 0 ? kNegativeLimitInput : 0U) |
      (reg(axis, "test_positive_limit_input"_object) != 0 ? kPositiveLimitInput : 0U) |
      (reg(axis, "test_home_input"_object) != 0 ? kHomeInput : 0U));
  axis.servo.blocked[axis.lane] = reg(axis, "test_blocked_load"_object) != 0 ? 1.0 : 0.0;
  s.attention = true;
  s.plan_due = true;
}

AbortCode check_object_value(ObjectRow row, std::int64_t value) noexcept {
  const AbortCode code = check_write(row, value);
  const bool is_judged =
      code == AbortCode::none || (is_judged_by_meaning(row) && is_within_type(row, value));
  return is_judged ? check_value(row, value) : code;
}

AbortCode write_object(const DriveContext& axis, ObjectRow row, std::int64_t value,
                       WriteEffect& effect) noexcept {
  if (const AbortCode code = check_object_value(row, value); code != AbortCode::none) {
    return code;
  }
  if (is_request(row)) {
    return AbortCode::none;  // whoever owns the bank carries it out; the row goes on reading 1
  }
  axis.registers.values[row] = value;
  switch (row) {
    case "ds402_controlword"_object:
      write_controlword(axis, static_cast<std::uint16_t>(value));
      break;
    case "position_user_target_value"_object:
      // Profile position latches it with the next set-point.
      axis.state.cyclic.streams =
          operation_enabled(axis) &&
          axis.state.mode.actual == OperatingMode::cyclic_synchronous_position;
      axis.state.attention = axis.state.attention || axis.state.cyclic.streams;
      break;
    case "profile_velocity"_object:
    case "synchronous_move_duration"_object:
    case "synchronous_move_acceleration_time"_object:
    case "synchronous_move_deceleration_time"_object:
    case "positioning_option_code"_object:
      break;  // latched with the next set-point
    case "op_mode_cmd"_object:
      axis.state.mode.wanted = static_cast<OperatingMode>(value);
      follow_mode(axis);
      axis.state.attention = true;
      axis.state.plan_due = true;
      break;
    case "target_velocity"_object:
      take_target(axis, OperatingMode::profile_velocity);
      break;
    case "target_torque"_object:
      take_target(axis, OperatingMode::profile_torque);
      break;
    case "profile_acc"_object:
    case "profile_dec"_object:
    case "torque_slope"_object:
    case "homing_method"_object:
    case "homing_speed_search"_object:
    case "homing_speed_creep"_object:
    case "homing_acceleration"_object:
    case "home_offset"_object:
      axis.state.plan_due = true;
      break;
    case "error_history_count"_object:
      axis.registers.history.codes = {};
      axis.registers.history.count = 0;
      break;
    default:
      update_derived(axis);
      effect = effect_of(row);
      break;
  }
  return AbortCode::none;
}

std::int64_t read_object(const DriveContext& axis, ObjectRow row, AbortCode& code) noexcept {
  const DriveRegisters& registers = axis.registers;
  if (const auto monitored = value_of(axis.status, row)) {
    return *monitored;
  }
  switch (row) {
    case "error_history_count"_object:
      return registers.history.count;
    case "dc_link_circuit_voltage"_object:
      return axis.state.faults.dc_link ? registers.values[row] : 0;
    default:
      break;
  }
  const ObjectAddress address = describe(row).address;
  if (address.index != 0x1003) {
    return registers.values[row];
  }
  const std::size_t entry = address.subindex - 1U;
  if (entry >= registers.history.count) {
    code = AbortCode::no_data_available;
    return 0;
  }
  return registers.history.codes[entry];
}

}  // namespace vdrive
