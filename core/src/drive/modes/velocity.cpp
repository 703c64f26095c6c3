// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/velocity.hpp"

#include "drive/limits.hpp"
#include "drive/stops.hpp"
#include "drive/vl_units.hpp"
#include "drive/window.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cmath>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

bool commands(const Drive& drive, std::uint16_t bit) {
  return (drive.state().controlword & bit) != 0;
}

/// Input of the ramp [UU/s]: 6042h, or 0 if bit 6 = 0.
double ramp_input(const Drive& drive) {
  return commands(drive, Controlword::kReferenceRamp) ? limited_vl_target(drive) : 0.0;
}

/// End value of the ramp [UU/s]. With bit 5 = 0 its output is held, which is the demand of the last
/// tick; with bit 4 = 0 the axis is stopped.
double destination(const Drive& drive) {
  if (drive.state().target.given_up || halted(drive) ||
      !commands(drive, Controlword::kEnableRamp)) {
    return 0.0;
  }
  return commands(drive, Controlword::kUnlockRamp) ? ramp_input(drive) : demand_velocity(drive);
}

/// [UU/s²]; a limit switch takes precedence over halt, and halt over bits 4 to 6.
double deceleration(const Drive& drive) {
  if (drive.state().target.given_up || runs_into_limit_switch(drive, demand_velocity(drive))) {
    return vl_quick_stop_deceleration(drive);
  }
  if (halted(drive)) {
    constexpr std::int64_t kQuickRamp = 2;
    const std::int64_t option = reg(drive, "halt_option_code"_object);
    return option == kQuickRamp ? vl_quick_stop_deceleration(drive)
                                : option_deceleration(drive, option, vl_deceleration(drive));
  }
  return commands(drive, Controlword::kEnableRamp) ? vl_deceleration(drive)
                                                   : vl_quick_stop_deceleration(drive);
}

/// Bits 4 to 6 are levels that `ask` reads, so their edges are not counted.
void command(Drive& /*drive*/, const WrittenControlword& /*word*/) {}

/// A new velocity replaces the target given up at a limit switch.
void take_velocity(Drive& drive, ObjectRow row) {
  if (row == "vl_target_velocity"_object) drive.state().target.given_up = false;
}

void advance(Drive& drive) {
  give_up_target_at_limit_switch(drive, destination(drive));
}

MotionRequest ask(const Drive& drive) {
  return {.kind = MotionRequest::Kind::velocity,
          .control = ControlLoop::velocity,
          .target = destination(drive),
          .limits = {.velocity = drive.registers().velocity_cap,
                     .acceleration = vl_acceleration(drive),
                     .deceleration = deceleration(drive)}};
}

MotionRequest normal_stop(const Drive& drive) {
  return stop_with(vl_deceleration(drive));
}

MotionRequest quick_stop(const Drive& drive) {
  return stop_with(vl_quick_stop_deceleration(drive));
}

/// 606Dh and 606Eh apply to the input of the ramp.
void watch(Drive& drive) {
  WindowState& window = drive.state().window;
  const double error = nearest(actual_velocity(drive)) - nearest(ramp_input(drive));
  count_ticks(std::abs(error) <= window.velocity, window.dwell);
}

/// Bit 10: the input of the ramp is reached, or under halt, standstill; bit 11: 6042h is limited by
/// 6046h, 607Fh or 6080h.
std::uint16_t status_bits(const Drive& drive) {
  const WindowState& window = drive.state().window;
  const bool reached = halted(drive) ? at_rest(drive) : window.dwell > window.velocity_ticks;
  const bool is_limited = limited_vl_target(drive) != vl_target(drive);
  return static_cast<std::uint16_t>(reached_when(reached) |
                                    (is_limited ? Statusword::kInternalLimitActive : 0U));
}

}  // namespace

constinit const Mode kVelocity{.command = command,
                               .take_target = take_velocity,
                               .advance = advance,
                               .ask = ask,
                               .normal_stop = normal_stop,
                               .quick_stop = quick_stop,
                               .watch = watch,
                               .status_bits = status_bits};

}  // namespace vdrive
