// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/cyclic_position.hpp"

#include "drive/limits.hpp"
#include "drive/stops.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// 607Ah counts from its first write in Operation enabled.
void take_position(Drive& drive, ObjectRow row) {
  if (row != "position_user_target_value"_object) return;
  DriveState& s = drive.state();
  s.modes.cyclic.streams = operation_enabled(drive);
  s.attention = s.attention || s.modes.cyclic.streams;
}

/// The streamed position, by the shorter way round the register; with software limits between them.
double streamed_target(const Drive& drive) {
  const DriveState& s = drive.state();
  const double streamed = real(drive, "position_user_target_value"_object);
  const double goal = within_software_limits(drive, streamed);
  const double whole = nearest(demand_position(drive));
  return whole +
         (s.limits.enabled ? goal - wrapped(whole) : static_cast<double>(wrapped(goal - whole)));
}

/// The next position that is written streams again.
void advance(Drive& drive) {
  DriveState& s = drive.state();
  if (!obeys_mode(drive) || !s.modes.cyclic.streams) return;
  s.target.given_up = false;
  s.modes.cyclic.streams =
      !heed_limit_switch(drive, streamed_target(drive) - demand_position(drive));
}

MotionRequest ask(const Drive& drive) {
  const DriveState& s = drive.state();
  if (!s.modes.cyclic.streams) {
    return s.target.given_up ? limit_switch_stop(drive) : ramp_stop(drive, "profile_dec"_object);
  }
  if (runs_into_limit_switch(drive, demand_velocity(drive))) return limit_switch_stop(drive);
  return {
      .kind = MotionRequest::Kind::follow,
      .target = streamed_target(drive),
      .limits = {
          .velocity = drive.registers().velocity_cap, .acceleration = 1.0, .deceleration = 1.0}};
}

/// Bit 12: the demand is the streamed position; neither a stop nor a limit keeps it away.
std::uint16_t status_bits(const Drive& drive) {
  const DriveState& s = drive.state();
  const bool follows = s.demand.following && wrapped(s.target.position) ==
                                                 reg(drive, "position_user_target_value"_object);
  return follows ? Statusword::kFollowsCommand : 0U;
}

/// Each tick goes a piece of the way.
bool evolves(const Drive& drive) {
  return drive.state().power.on;
}

}  // namespace

constinit const Mode kCyclicPosition{.normal_ramp = "profile_dec"_object,
                                     .command = ignore_edge,
                                     .take_target = take_position,
                                     .advance = advance,
                                     .ask = ask,
                                     .status_bits = status_bits,
                                     .evolves = evolves};

}  // namespace vdrive
