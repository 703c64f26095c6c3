// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/cyclic_velocity.hpp"

#include "drive/interpolation.hpp"
#include "drive/stops.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// 60FFh plus 60B1h, saturated to the range of the register that shows the demand.
std::int32_t set_point(const Drive& drive) {
  using Ends = std::numeric_limits<std::int32_t>;
  const std::int64_t sum =
      reg(drive, "target_velocity"_object) + reg(drive, "velocity_offset"_object);
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(sum, Ends::min(), Ends::max()));
}

void take_velocity(Drive& drive, ObjectRow row) {
  if (row == "target_velocity"_object) note_set_point(drive);
}

/// Halt ends the stream: otherwise the axis would resume the last velocity afterwards, even without
/// a master. The next set-point starts a new stream.
void advance(Drive& drive) {
  if (!obeys_mode(drive) || !is_streaming(drive)) return;
  if (halted(drive)) {
    end_stream(drive);
    return;
  }
  drive.state().target.given_up = false;
  if (!take_set_point(drive, set_point(drive))) return;
  if (give_up_target_at_limit_switch(drive, set_point(drive))) end_stream(drive);
}

MotionRequest stop(const Drive& drive) {
  const MotionRequest normal = ramp_stop(drive, "profile_dec"_object);
  return halted(drive) ? stop_by_option(drive, reg(drive, "halt_option_code"_object), normal)
                       : normal;
}

/// A limit switch takes precedence over halt.
MotionRequest ask(const Drive& drive) {
  if (drive.state().target.given_up || runs_into_limit_switch(drive, demand_velocity(drive))) {
    return limit_switch_stop(drive);
  }
  if (!is_streaming(drive)) return stop(drive);
  return {
      .kind = MotionRequest::Kind::follow,
      .control = ControlLoop::velocity,
      .target = interpolated_demand(drive, demand_velocity(drive), set_point(drive)),
      .limits = {
          .velocity = drive.registers().velocity_cap, .acceleration = 1.0, .deceleration = 1.0}};
}

double torque_offset(const Drive& drive) {
  return real(drive, "torque_offset"_object);
}

/// Bit 12: the demand is at the streamed velocity or on its way there, neither stopped nor limited
/// by 607Fh or 6080h.
std::uint16_t status_bits(const Drive& drive) {
  const DriveState& s = drive.state();
  const DriveRegisters& registers = drive.registers();
  const double wanted = set_point(drive);
  const bool follows = s.demand.following && demand_velocity(drive) == registers.request.target &&
                       std::abs(wanted) <= registers.velocity_cap;
  return follows ? Statusword::kFollowsCommand : 0U;
}

/// Every tick continues the interpolation.
bool evolves(const Drive& drive) {
  return drive.state().power.on;
}

}  // namespace

constinit const Mode kCyclicVelocity{.normal_ramp = "profile_dec"_object,
                                     .command = ignore_edge,
                                     .take_target = take_velocity,
                                     .advance = advance,
                                     .ask = ask,
                                     .torque_offset = torque_offset,
                                     .status_bits = status_bits,
                                     .evolves = evolves};

}  // namespace vdrive
