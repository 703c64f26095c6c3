// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/profile_torque.hpp"

#include "drive/limits.hpp"
#include "drive/stops.hpp"
#include "drive/window.hpp"
#include "rounding.hpp"

#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// A new torque replaces the target given up at a limit switch.
void take_torque(Drive& drive, ObjectRow row) {
  if (row == "target_torque"_object) drive.state().target.given_up = false;
}

/// A limit switch counts in the direction of the torque or, without torque, in the direction in
/// which the axis drifts.
void advance(Drive& drive) {
  const double target = real(drive, "target_torque"_object);
  const bool drifts = target == 0.0 && drifts_into_limit_switch(drive);
  give_up_target_at_limit_switch(drive, drifts ? actual_velocity(drive) : target);
}

/// A limit switch takes precedence over halt.
MotionRequest ask(const Drive& drive) {
  if (drive.state().target.given_up || drifts_into_limit_switch(drive)) {
    return limit_switch_stop(drive);
  }
  if (halted(drive)) {
    return stop_by_option(drive, reg(drive, "halt_option_code"_object), release_torque(drive));
  }
  return torque_to(drive, within_torque_limits(drive, real(drive, "target_torque"_object)));
}

/// Bit 10: the torque command has reached 6071h, neither limited nor stopped.
std::uint16_t status_bits(const Drive& drive) {
  if (halted(drive)) return reached_when(at_rest(drive));
  const DemandState& demand = drive.state().demand;
  return reached_when(demand.control == ControlLoop::torque && !demand.moving &&
                      nearest(commanded_torque(drive)) == real(drive, "target_torque"_object));
}

/// Every tick continues the ramp, and the axis may drift into a limit switch.
bool evolves(const Drive& drive) {
  return drive.state().power.on;
}

}  // namespace

constinit const Mode kProfileTorque{.normal_ramp = "profile_dec"_object,
                                    .command = ignore_edge,
                                    .take_target = take_torque,
                                    .advance = advance,
                                    .ask = ask,
                                    .normal_stop = release_torque,
                                    .status_bits = status_bits,
                                    .evolves = evolves};

}  // namespace vdrive
