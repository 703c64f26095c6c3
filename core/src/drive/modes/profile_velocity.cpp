// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/profile_velocity.hpp"

#include "drive/limits.hpp"
#include "drive/stops.hpp"
#include "drive/window.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cmath>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// A new velocity replaces the target given up at a limit switch.
void take_velocity(Drive& drive, ObjectRow row) {
  if (row == "target_velocity"_object) drive.state().target.given_up = false;
}

void advance(Drive& drive) {
  give_up_target_at_limit_switch(drive, real(drive, "target_velocity"_object));
}

MotionRequest ask(const Drive& drive) {
  const DriveState& s = drive.state();
  MotionRequest request{.kind = MotionRequest::Kind::velocity,
                        .control = ControlLoop::velocity,
                        .target = real(drive, "target_velocity"_object),
                        .limits = {.velocity = drive.registers().velocity_cap,
                                   .acceleration = acceleration_of(drive, "profile_acc"_object),
                                   .deceleration = deceleration_of(drive, "profile_dec"_object)},
                        .jerk = profile_jerk(drive)};
  if (halted(drive)) {
    const std::int64_t option = reg(drive, "halt_option_code"_object);
    request.target = 0.0;
    request.limits.deceleration = option_deceleration(drive, option, request.limits.deceleration);
    if (option != 1) request.jerk = {};
  }
  if (s.target.given_up) request.target = 0.0;
  if (s.target.given_up || runs_into_limit_switch(drive, demand_velocity(drive))) {
    request.limits.deceleration = deceleration_of(drive, "quick_stop_deceleration"_object);
    request.jerk = {};
  }
  return request;
}

/// 606Dh and 606Eh apply to the target, 606Fh and 6070h to standstill.
void watch(Drive& drive) {
  WindowState& window = drive.state().window;
  const double speed = nearest(actual_velocity(drive));
  const double error = std::abs(real(drive, "target_velocity"_object) - speed);
  count_ticks(error <= window.velocity, window.dwell);
  count_ticks(std::abs(speed) <= window.threshold, window.standstill);
}

/// Bit 10: the velocity is reached, or under halt, zero; bit 12: the axis stands.
std::uint16_t status_bits(const Drive& drive) {
  const WindowState& window = drive.state().window;
  const bool reached = halted(drive) ? at_rest(drive) : window.dwell > window.velocity_ticks;
  const bool stands = window.standstill > window.threshold_ticks;
  return static_cast<std::uint16_t>(reached_when(reached) | (stands ? Statusword::kSpeedZero : 0U));
}

}  // namespace

constinit const Mode kProfileVelocity{.normal_ramp = "profile_dec"_object,
                                      .has_profile_type = true,
                                      .command = ignore_edge,
                                      .take_target = take_velocity,
                                      .advance = advance,
                                      .ask = ask,
                                      .watch = watch,
                                      .status_bits = status_bits};

}  // namespace vdrive
