// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/cyclic_position.hpp"

#include "drive/habits.hpp"
#include "drive/limits.hpp"
#include "drive/stops.hpp"
#include "drive/window.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

constexpr std::int64_t kLowestTimeIndex = -6;  // of 60C2h:02

/// [us] by 60C2h:02, from the lowest one to 0.
constexpr std::array<std::int64_t, 7> kInterpolationUnits{1,      10,      100,      1'000,
                                                          10'000, 100'000, 1'000'000};

static_assert(describe("interpolation_time_index"_object).lower_limit == kLowestTimeIndex &&
                  describe("interpolation_time_index"_object).upper_limit == 0 &&
                  static_cast<std::int64_t>(kInterpolationUnits.size()) == 1 - kLowestTimeIndex,
              "each value of 60C2h:02 has its unit");

/// 607Ah counts from its first write in Operation enabled.
void take_position(Drive& drive, ObjectRow row) {
  if (row != "position_user_target_value"_object) return;
  DriveState& s = drive.state();
  CyclicState& cyclic = s.modes.cyclic;
  const bool streams = operation_enabled(drive);
  cyclic.begins = streams && (cyclic.begins || !cyclic.streams);
  cyclic.streams = streams;
  s.attention = s.attention || streams;
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

/// @return 60C2h in ticks; 0 and 1 both mean the present tick.
std::uint32_t interpolation_ticks(const Drive& drive) {
  // In a snapshot of a file a register may have any value.
  const std::int64_t index =
      std::clamp<std::int64_t>(reg(drive, "interpolation_time_index"_object), kLowestTimeIndex, 0);
  const std::int64_t unit = kInterpolationUnits[static_cast<std::size_t>(index - kLowestTimeIndex)];
  return ticks_of_us(drive, unit * unsigned_reg(drive, "interpolation_time_period"_object));
}

/// Once a tick, whatever was written before it and in which order. A 607Ah of the same value is not
/// a new set-point: a master that repeats it does not delay it.
void take_set_point(Drive& drive) {
  CyclicState& cyclic = drive.state().modes.cyclic;
  Interpolation& way = drive.registers().interpolation;
  const auto position = static_cast<std::int32_t>(reg(drive, "position_user_target_value"_object));
  if (cyclic.begins || position != way.set_point) {
    way = {.set_point = position, .ticks_left = interpolation_ticks(drive)};
    cyclic.begins = false;
  }
  if (way.ticks_left != 0) --way.ticks_left;
}

/// Bit 4 means nothing in this mode, but for a drive that waits for it.
void command(Drive& drive, const WrittenControlword& word) {
  if (!drive.registers().habits.gates_stream) ignore_edge(drive, word);
}

/// The next position that is written streams again.
void advance(Drive& drive) {
  DriveState& s = drive.state();
  if (!obeys_mode(drive) || !s.modes.cyclic.streams) return;
  s.target.given_up = false;
  if (holds_stream(drive)) {
    s.modes.cyclic.begins = true;  // the way begins anew once it is released
    return;
  }
  take_set_point(drive);
  s.modes.cyclic.streams =
      !heed_limit_switch(drive, streamed_target(drive) - demand_position(drive));
}

/// The demand at the end of this tick. The way that is left is divided anew in each tick: no
/// rounding adds up, and the last part is all of it.
double next_position(const Drive& drive) {
  const double target = streamed_target(drive);
  const std::uint32_t ticks_left = drive.registers().interpolation.ticks_left;
  if (ticks_left == 0) return target;
  const double start = demand_position(drive);
  return start + (target - start) / (static_cast<double>(ticks_left) + 1.0);
}

MotionRequest ask(const Drive& drive) {
  const DriveState& s = drive.state();
  if (!s.modes.cyclic.streams || holds_stream(drive)) {
    return s.target.given_up ? limit_switch_stop(drive) : ramp_stop(drive, "profile_dec"_object);
  }
  if (runs_into_limit_switch(drive, demand_velocity(drive))) return limit_switch_stop(drive);
  return {
      .kind = MotionRequest::Kind::follow,
      .target = next_position(drive),
      .limits = {
          .velocity = drive.registers().velocity_cap, .acceleration = 1.0, .deceleration = 1.0}};
}

/// @return whether the demand went as far as it should in this tick, to where 607Ah says.
bool is_on_its_way(const Drive& drive) {
  const double streamed = real(drive, "position_user_target_value"_object);
  return drive.state().target.position == drive.registers().request.target &&
         within_software_limits(drive, streamed) == streamed;
}

/// Bit 12: the demand is the streamed position, or on its way there; neither a stop nor a limit
/// keeps it away.
std::uint16_t status_bits(const Drive& drive) {
  const DriveState& s = drive.state();
  if (!s.demand.following) return 0U;
  const bool follows =
      drive.registers().interpolation.ticks_left == 0
          ? wrapped(s.target.position) == reg(drive, "position_user_target_value"_object)
          : is_on_its_way(drive);
  if (!follows) return 0U;
  const bool stands = drive.registers().interpolation.ticks_left == 0 && !s.demand.moving;
  return static_cast<std::uint16_t>(Statusword::kFollowsCommand |
                                    reached_when(shows_points(drive) && stands));
}

/// Each tick goes a piece of the way.
bool evolves(const Drive& drive) {
  return drive.state().power.on;
}

}  // namespace

constinit const Mode kCyclicPosition{.normal_ramp = "profile_dec"_object,
                                     .command = command,
                                     .take_target = take_position,
                                     .advance = advance,
                                     .ask = ask,
                                     .status_bits = status_bits,
                                     .evolves = evolves};

}  // namespace vdrive
