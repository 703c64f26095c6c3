// SPDX-License-Identifier: Apache-2.0
#include "drive/power.hpp"

#include "drive/demand.hpp"
#include "drive/registers.hpp"

#include <algorithm>
#include <array>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// A stop whose demand has ended waits for the axis to stand still, but not for ever: a load that
/// is pushed from outside may never do so.
constexpr std::uint32_t kLongestStandstillWait_us = 1'000'000;

/// Causes of faults that are levels, in the order in which they are looked at.
struct CauseRow {
  std::uint8_t bit;
  ObjectRow input;
  ErrorCode code;
};

constexpr std::array<CauseRow, 4> kCauses{{
    {1U << 0U, "test_over_current"_object, ErrorCode::continuous_over_current},
    {1U << 1U, "test_over_temperature"_object, ErrorCode::excess_temperature_drive},
    {1U << 2U, "test_encoder_failure"_object, ErrorCode::incremental_sensor_1_fault},
    {1U << 3U, "test_dc_link_loss"_object, ErrorCode::dc_link_under_voltage},
}};
constexpr std::uint8_t kDcLinkCause = 1U << 3U;

/// Takes control where the axis is, without set-points.
void take_control(const DriveContext& axis) {
  rebase(axis);
  rest_at(axis, axis.servo.load_reading[axis.lane]);
  set_power(axis, true);
  axis.registers.request = {};
  axis.state.following_error.count = 0;
  seed_target(axis);
}

/// Transition 4: caps of 607Fh and 6080h come into force, set-points are cleared.
void enable(const DriveContext& axis) {
  const double motor_cap =
      real(axis, "motor_max_speed_rpm"_object) * kUserUnitsPerRevolution / 60.0;
  axis.registers.velocity_cap = std::min(real(axis, "app_speed_limit"_object), motor_cap);
  axis.servo.speed_limit[axis.lane] = axis.registers.velocity_cap;
  take_control(axis);
}

/// Transition 16: the interrupted move is forgotten; what still moves is brought to rest.
void re_enable(const DriveContext& axis) {
  if (!axis.state.power.on) {  // 605Ah was 0 when the quick stop began: the axis coasts
    take_control(axis);
  } else if (axis.state.demand.moving) {
    drop_set_points(axis);
    axis.state.target.arrived =
        false;  // a mode change meanwhile may have taken the demand as the target
    axis.state.window.dwell = 0;
  } else {
    seed_target(axis);
  }
}

void clear_fault(const DriveContext& axis) {
  axis.state.faults.error_code = 0;
  axis.state.faults.error_register = 0;
  axis.state.following_error.shown = false;
  axis.state.following_error.count = 0;
  axis.state.faults.coasting = false;
}

void remember_error(const DriveContext& axis, ErrorCode code) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  s.faults.error_code = static_cast<std::uint16_t>(code);
  s.faults.error_register =
      static_cast<std::uint8_t>(s.faults.error_register | error_register_of(code));
  ++s.faults.count;
  std::copy_backward(r.history.codes.begin(), r.history.codes.end() - 1, r.history.codes.end());
  r.history.codes[0] = static_cast<std::uint32_t>(code);
  r.history.count = static_cast<std::uint8_t>(
      std::min<std::size_t>(r.history.count + 1U, r.history.codes.size()));
}

bool handles_fault(PowerState state) {
  return state == PowerState::fault_reaction_active || state == PowerState::fault;
}

bool has_power_to_lose(PowerState state) {
  return state == PowerState::operation_enabled || state == PowerState::quick_stop_active ||
         state == PowerState::fault_reaction_active;
}

}  // namespace

PowerOptions power_options(const DriveContext& axis) {
  return {
      .quick_stop_option_code =
          static_cast<std::int8_t>(reg(axis, "quick_stop_option_code"_object)),
      .shutdown_option_code = static_cast<std::int8_t>(reg(axis, "shutdown_option_code"_object)),
      .disable_operation_option_code =
          static_cast<std::int8_t>(reg(axis, "disable_operation_option_code"_object)),
      .enable_from_switch_on_disabled = axis.registers.settings.enable_from_switch_on_disabled};
}

bool cause_present(const DriveContext& axis) {
  return std::any_of(kCauses.begin(), kCauses.end(), [&axis](const CauseRow& cause) {
    return reg(axis, cause.input) != 0;
  });
}

void set_power(const DriveContext& axis, bool powered) {
  axis.state.power.on = powered;
  axis.servo.powered[axis.lane] = powered ? 1.0 : 0.0;
  axis.servo.integrator[axis.lane] = 0.0;
  axis.state.demand.control = Control::position;
  axis.servo.closes_position[axis.lane] = 1.0;
  axis.servo.torque_control[axis.lane] = 0.0;
  if (!powered) {
    axis.servo.torque[axis.lane] = 0.0;
    rest_at(axis, axis.servo.load_reading[axis.lane]);
  }
}

void act(const DriveContext& axis, const TransitionSet& taken) {
  if (taken.empty()) {
    return;
  }
  DriveState& s = axis.state;
  s.power.ticks_in_state = 0;
  s.attention = true;
  s.plan_due = true;
  s.power.stop_ticks = 0;
  if (taken.contains(4)) {
    enable(axis);
  } else if (taken.contains(16)) {
    re_enable(axis);
  } else if (taken.contains(11)) {
    drop_set_points(axis);
    if (reg(axis, "quick_stop_option_code"_object) == 0) {
      set_power(axis, false);
    }
  } else if (taken.contains(13)) {
    drop_set_points(axis);
    if (s.faults.coasting || reg(axis, "fault_reaction_option_code"_object) == 0) {
      set_power(axis, false);
    }
  } else {
    drop_set_points(axis);
    set_power(axis, false);
  }
  if (taken.contains(15)) {
    clear_fault(axis);
  }
}

void raise_fault(const DriveContext& axis, ErrorCode code) {
  DriveState& s = axis.state;
  remember_error(axis, code);
  s.faults.coasting = s.faults.coasting || forces_coasting(code);
  act(axis, s.power.machine.fault_detected());
  if (s.faults.coasting && s.power.on) {
    set_power(axis, false);  // a braking fault reaction that can brake no more
  }
}

/// A lost DC link is a fault only where the motor is powered; elsewhere the axis falls back. A
/// cause that went for a reset and came back before the tick is a new fault.
void watch_causes(const DriveContext& axis) {
  DriveState& s = axis.state;
  std::uint8_t present = 0;
  for (const CauseRow& cause : kCauses) {
    if (reg(axis, cause.input) == 0) {
      continue;
    }
    present = static_cast<std::uint8_t>(present | cause.bit);
    const bool known = (s.faults.causes & cause.bit) != 0 && handles_fault(s.power.machine.state());
    const bool harmless = cause.bit == kDcLinkCause && !has_power_to_lose(s.power.machine.state());
    if (!known && !harmless) {
      raise_fault(axis, cause.code);
    }
  }
  s.faults.causes = present;
  s.faults.dc_link = (present & kDcLinkCause) == 0;
  if (!s.faults.dc_link) {
    act(axis, s.power.machine.voltage_lost());
  }
}

void complete_stops(const DriveContext& axis) {
  DriveState& s = axis.state;
  const bool stopping = s.power.machine.state() == PowerState::quick_stop_active ||
                        s.power.machine.state() == PowerState::fault_reaction_active ||
                        s.power.machine.pending() != PowerCommand::none;
  if (!stopping || s.power.ticks_in_state == 0) {
    return;
  }
  DriveRegisters& r = axis.registers;
  if (s.power.on && s.demand.moving) {
    s.power.stop_ticks = 0;
    return;
  }
  const std::uint32_t longest = kLongestStandstillWait_us / axis.timing.period_us;
  if (s.power.on && !at_rest(axis) && ++s.power.stop_ticks < longest) {
    return;
  }
  const bool dwells = s.power.machine.state() == PowerState::quick_stop_active &&
                      s.power.ticks_in_state < ticks_of_ms(axis, r.settings.quick_stop_dwell_ms);
  if (!dwells) {
    act(axis, s.power.machine.stop_finished(power_options(axis)));
  }
}

void follow_mode(const DriveContext& axis) {
  DriveState& s = axis.state;
  if (s.mode.wanted == s.mode.actual) {
    return;
  }
  if (operation_enabled(axis) && !at_rest(axis)) {
    drop_set_points(axis);
    s.attention = true;
    return;
  }
  s.mode.actual = s.mode.wanted;
  seed_target(axis);
}

}  // namespace vdrive
