// SPDX-License-Identifier: Apache-2.0
#include "drive/mode_table.hpp"

#include "drive/habits.hpp"
#include "drive/limits.hpp"
#include "drive/modes/cyclic_position.hpp"
#include "drive/modes/cyclic_torque.hpp"
#include "drive/modes/cyclic_velocity.hpp"
#include "drive/modes/homing.hpp"
#include "drive/modes/interpolated_position.hpp"
#include "drive/modes/profile_position.hpp"
#include "drive/modes/profile_torque.hpp"
#include "drive/modes/profile_velocity.hpp"
#include "drive/modes/velocity.hpp"
#include "drive/stops.hpp"
#include "drive/target.hpp"
#include "drive/window.hpp"

#include <algorithm>

namespace vdrive {
namespace {

using namespace vdrive::literals;

MotionRequest stay(const Drive& drive) {
  return runs_into_limit_switch(drive, demand_velocity(drive))
             ? limit_switch_stop(drive)
             : ramp_stop(drive, "profile_dec"_object);
}

/// 6061h = 0: enabled, no motion.
constexpr Mode kNoMode{.normal_ramp = "profile_dec"_object, .command = ignore_edge, .ask = stay};

struct ModeRow {
  OperatingMode number;
  const Mode* mode;
};

// For a new mode, add a row here and in kOperatingModes.
constexpr std::array kRows{
    ModeRow{OperatingMode::none, &kNoMode},
    ModeRow{OperatingMode::profile_position, &kProfilePosition},
    ModeRow{OperatingMode::velocity, &kVelocity},
    ModeRow{OperatingMode::profile_velocity, &kProfileVelocity},
    ModeRow{OperatingMode::profile_torque, &kProfileTorque},
    ModeRow{OperatingMode::homing, &kHoming},
    ModeRow{OperatingMode::interpolated_position, &kInterpolatedPosition},
    ModeRow{OperatingMode::cyclic_synchronous_position, &kCyclicPosition},
    ModeRow{OperatingMode::cyclic_synchronous_velocity, &kCyclicVelocity},
    ModeRow{OperatingMode::cyclic_synchronous_torque, &kCyclicTorque},
};

static_assert(std::ranges::equal(kRows, kOperatingModes, {}, &ModeRow::number,
                                 &OperatingModeRow::mode),
              "a mode has a row in both tables, at the same place");

consteval std::array<const Mode*, kModeNumbers> by_number() {
  std::array<const Mode*, kModeNumbers> modes{};
  modes.fill(&kNoMode);
  for (const ModeRow& row : kRows) modes[static_cast<std::size_t>(row.number)] = row.mode;
  return modes;
}

/// The stop with the normal ramp of the active mode.
MotionRequest normal_ramp_stop(const Drive& drive) {
  const Mode& mode = mode_of(drive);
  return mode.has_profile_type ? profile_stop(drive, mode.normal_ramp)
                               : ramp_stop(drive, mode.normal_ramp);
}

MotionRequest normal_stop(const Drive& drive) {
  const Mode& mode = mode_of(drive);
  return mode.normal_stop != nullptr ? mode.normal_stop(drive) : normal_ramp_stop(drive);
}

/// The normal stop as a quick stop or fault reaction: without limited jerk, which would let an axis
/// that is speeding up get faster first.
MotionRequest urgent_normal_stop(const Drive& drive) {
  MotionRequest request = normal_stop(drive);
  request.jerk = {};
  return request;
}

/// The stop for option codes 605Ah and 605Eh.
MotionRequest stop_of_mode(const Drive& drive, std::int64_t option) {
  constexpr std::int64_t kQuickRamp = 2;
  const Mode& mode = mode_of(drive);
  return option == kQuickRamp && mode.quick_stop != nullptr
             ? mode.quick_stop(drive)
             : stop_by_option(drive, option, urgent_normal_stop(drive));
}

/// The stop before a change of mode. The next mode begins at rest, so if the normal stop would only
/// remove a torque, the axis is braked with the normal ramp instead.
MotionRequest stop_before_change(const Drive& drive) {
  if (runs_into_limit_switch(drive, demand_velocity(drive))) {
    const Mode& mode = mode_of(drive);
    return mode.quick_stop != nullptr ? mode.quick_stop(drive) : limit_switch_stop(drive);
  }
  const MotionRequest normal = normal_stop(drive);
  return normal.control == ControlLoop::torque ? normal_ramp_stop(drive) : normal;
}

MotionRequest request_in_operation(const Drive& drive) {
  const DriveState& s = drive.state();
  if (s.mode.wanted != s.mode.actual) return stop_before_change(drive);
  return s.power.machine.pending() != PowerCommand::none ? normal_stop(drive)
                                                         : mode_of(drive).ask(drive);
}

/// The requested motion of a powered axis.
MotionRequest request_of_state(const Drive& drive) {
  switch (drive.state().power.machine.state()) {
    case PowerState::operation_enabled:
      return request_in_operation(drive);
    case PowerState::quick_stop_active: {
      const std::int64_t option = reg(drive, "quick_stop_option_code"_object);
      return stop_of_mode(drive, option > 4 ? option - 4 : option);
    }
    case PowerState::fault_reaction_active:
      return stop_of_mode(drive, reg(drive, "fault_reaction_option_code"_object));
    default:
      return {};
  }
}

}  // namespace

// Only addresses, known at compile time, as constinit enforces.
// NOLINTNEXTLINE(cppcoreguidelines-interfaces-global-init)
constinit const std::array<const Mode*, kModeNumbers> kModes = by_number();

MotionRequest requested_motion(const Drive& drive) {
  if (!drive.state().power.on) return {};
  MotionRequest request = request_of_state(drive);
  if (const Mode& mode = mode_of(drive); mode.torque_offset != nullptr) {
    request.torque_offset = mode.torque_offset(drive);
  }
  return request;
}

void follow_mode(Drive& drive) {
  DriveState& s = drive.state();
  if (s.mode.wanted == s.mode.actual) return;
  if (operation_enabled(drive) && !at_rest(drive)) {
    drop_targets(drive);
    s.attention = true;
    return;
  }
  if (holds_mode(drive)) return;
  s.mode.actual = s.mode.wanted;
  seed_target(drive);
}

}  // namespace vdrive
