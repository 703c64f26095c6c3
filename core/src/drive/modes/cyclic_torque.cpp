// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/cyclic_torque.hpp"

#include "drive/interpolation.hpp"
#include "drive/stops.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// A commanded torque farther than this from the demand counts as held back [‰ of rated].
constexpr double kHeldBack = 0.5;

/// 6071h plus 60B2h.
std::int32_t set_point(const Drive& drive) {
  return static_cast<std::int32_t>(reg(drive, "target_torque"_object) +
                                   reg(drive, "torque_offset"_object));
}

void take_torque(Drive& drive, ObjectRow row) {
  if (row == "target_torque"_object) note_set_point(drive);
}

/// A limit switch counts in the direction of the torque or, without torque, in the direction in
/// which the axis drifts. Halt ends the stream: otherwise the last torque would be applied again
/// afterwards, even without a master. The next set-point starts a new stream.
void advance(Drive& drive) {
  if (!obeys_mode(drive) || !is_streaming(drive)) return;
  if (halted(drive)) {
    end_stream(drive);
    return;
  }
  drive.state().target.given_up = false;
  if (!take_set_point(drive, set_point(drive))) return;
  const double torque = set_point(drive);
  const bool drifts = torque == 0.0 && drifts_into_limit_switch(drive);
  if (give_up_target_at_limit_switch(drive, drifts ? actual_velocity(drive) : torque))
    end_stream(drive);
}

/// The torque at which the interpolation starts. If another loop was the outermost one, this is the
/// torque that the loop commands.
double demand_torque(const Drive& drive) {
  const DemandState& demand = drive.state().demand;
  return demand.control == ControlLoop::torque ? demand.torque : commanded_torque(drive);
}

/// An axis that is not under torque control yet has no torque to remove: with 605Dh = 1 it brakes
/// with 6084h.
MotionRequest halt(const Drive& drive) {
  const std::int64_t option = reg(drive, "halt_option_code"_object);
  const bool has_torque = drive.state().demand.control == ControlLoop::torque;
  return option == 1 && !has_torque ? ramp_stop(drive, "profile_dec"_object)
                                    : stop_by_option(drive, option, release_torque(drive));
}

/// A limit switch takes precedence over halt.
MotionRequest ask(const Drive& drive) {
  if (drive.state().target.given_up || drifts_into_limit_switch(drive)) {
    return limit_switch_stop(drive);
  }
  if (halted(drive)) return halt(drive);
  if (!is_streaming(drive)) return ramp_stop(drive, "profile_dec"_object);
  const double target = within_torque_limits(drive, set_point(drive));
  return {.kind = MotionRequest::Kind::follow,
          .control = ControlLoop::torque,
          .target = interpolated_demand(drive, demand_torque(drive), target),
          .limits = {.velocity = 0.0, .acceleration = 1.0, .deceleration = 1.0}};
}

/// Bit 12: the command is at the streamed torque or on its way there, neither stopped nor limited.
/// In the last sub-step of a tick the command is one step short of the end value.
std::uint16_t status_bits(const Drive& drive) {
  const DriveState& s = drive.state();
  const std::size_t l = drive.lane();
  const double step = drive.servo().torque_step[l] * drive.block().units.torque_per_mille[l];
  const double wanted = set_point(drive);
  const bool follows = s.demand.following && within_torque_limits(drive, wanted) == wanted &&
                       std::abs(s.demand.torque - step - commanded_torque(drive)) <= kHeldBack;
  return follows ? Statusword::kFollowsCommand : 0U;
}

/// Every tick continues the interpolation, and the axis may drift into a limit switch.
bool evolves(const Drive& drive) {
  return drive.state().power.on;
}

}  // namespace

constinit const Mode kCyclicTorque{.normal_ramp = "profile_dec"_object,
                                   .command = ignore_edge,
                                   .take_target = take_torque,
                                   .advance = advance,
                                   .ask = ask,
                                   .normal_stop = release_torque,
                                   .status_bits = status_bits,
                                   .evolves = evolves};

}  // namespace vdrive
