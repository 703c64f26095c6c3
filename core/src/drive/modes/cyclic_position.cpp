// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/cyclic_position.hpp"

#include "drive/habits.hpp"
#include "drive/interpolation.hpp"
#include "drive/stops.hpp"
#include "drive/window.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// 607Ah plus 60B0h, wrapping around as the registers do.
std::int32_t set_point(const Drive& drive) {
  return static_cast<std::int32_t>(unsigned_reg(drive, "position_user_target_value"_object) +
                                   unsigned_reg(drive, "position_offset"_object));
}

void take_position(Drive& drive, ObjectRow row) {
  if (row == "position_user_target_value"_object) note_set_point(drive);
}

/// Bit 4 has no meaning in this mode, except for a drive that waits for it (5E20h:02).
void command(Drive& drive, const WrittenControlword& word) {
  if (!drive.registers().habits.gates_stream) ignore_edge(drive, word);
}

/// After a limit switch, the next written position starts a new stream.
void advance(Drive& drive) {
  DriveState& s = drive.state();
  if (!obeys_mode(drive) || !is_streaming(drive)) return;
  s.target.given_up = false;
  if (holds_stream(drive)) {
    s.modes.stream.stage = StreamStage::begins;  // the interpolation starts again once released
    return;
  }
  if (!take_set_point(drive, set_point(drive))) return;
  const double target = streamed_position(drive, set_point(drive));
  if (give_up_target_at_limit_switch(drive, target - demand_position(drive))) end_stream(drive);
}

MotionRequest ask(const Drive& drive) {
  if (!is_streaming(drive) || holds_stream(drive)) {
    return drive.state().target.given_up ? limit_switch_stop(drive)
                                         : ramp_stop(drive, "profile_dec"_object);
  }
  if (runs_into_limit_switch(drive, demand_velocity(drive))) return limit_switch_stop(drive);
  MotionRequest request = follow_position(drive, set_point(drive));
  request.velocity_offset = real(drive, "velocity_offset"_object);
  return request;
}

double torque_offset(const Drive& drive) {
  return real(drive, "torque_offset"_object);
}

/// Bit 12: the demand is at the streamed position or on its way there.
std::uint16_t status_bits(const Drive& drive) {
  if (!follows_position(drive, set_point(drive))) return 0U;
  const bool stands =
      drive.registers().interpolation.ticks_left == 0 && !drive.state().demand.moving;
  return static_cast<std::uint16_t>(Statusword::kFollowsCommand |
                                    reached_when(shows_points(drive) && stands));
}

/// Every tick continues the interpolation.
bool evolves(const Drive& drive) {
  return drive.state().power.on;
}

}  // namespace

constinit const Mode kCyclicPosition{.normal_ramp = "profile_dec"_object,
                                     .command = command,
                                     .take_target = take_position,
                                     .advance = advance,
                                     .ask = ask,
                                     .torque_offset = torque_offset,
                                     .status_bits = status_bits,
                                     .evolves = evolves};

}  // namespace vdrive
