// SPDX-License-Identifier: Apache-2.0
#include "drive/modulo.hpp"

#include "drive/frame.hpp"
#include "drive/registers.hpp"
#include "drive/stops.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/positioning_option.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdrive {
namespace {

/// Values of bits 6 and 7 of 60F2h.
enum class RotaryDirection : std::uint8_t { as_linear, negative, positive, shortest };

/// The bits are ignored on an axis without a range or with software limits in force.
RotaryDirection direction_of(const Drive& drive, std::int64_t option) {
  if (!is_modulo(drive) || drive.state().limits.enabled) return RotaryDirection::as_linear;
  return static_cast<RotaryDirection>((option & PositioningOption::kDirectionBits) >>
                                      PositioningOption::kFirstDirectionBit);
}

/// The position where the demand would come to rest, rounded: a fraction of a unit must not cause a
/// turn.
double place_of_rest(const Drive& drive, double deceleration) {
  const double velocity = demand_velocity(drive);
  if (const MotionJerk jerk = profile_jerk(drive); is_limited(jerk)) {
    const MotionLimits limits{
        .velocity = 0.0, .acceleration = deceleration, .deceleration = deceleration};
    const MotionSample start{demand_position(drive), velocity,
                             starting_acceleration(drive, limits, jerk)};
    return nearest(plan_jerk_stop(start, deceleration, jerk).end_position());
  }
  return nearest(demand_position(drive) + velocity * std::abs(velocity) / (2.0 * deceleration));
}

}  // namespace

void fold_numbers(const Drive& drive, NumberBlock& numbers) noexcept {
  const std::size_t l = drive.lane();
  const std::int32_t demand = shown_position(drive, nearest(demand_position(drive)));
  numbers.position_demand_value[l] = demand;
  numbers.load_position_actual_value[l] = shown_position(drive, nearest(actual_position(drive)));
  if (drive.registers().single_encoder) {
    const double motor = drive.servo().motor_reading[l];
    numbers.motor_position_actual_value[l] = shown_position(drive, nearest(motor));
  } else {
    const double motor = numbers.motor_position_actual_value[l];
    numbers.motor_position_error_value[l] = wrapped(demand - motor);
  }
}

double target_on_range(const Drive& drive, double target, std::int64_t option,
                       double deceleration) {
  const RotaryDirection direction = direction_of(drive, option);
  if (direction == RotaryDirection::as_linear) return target;
  const double span = drive.registers().range.span;
  const double ranges = (target - place_of_rest(drive, deceleration)) / span;
  switch (direction) {
    case RotaryDirection::positive:
      return target - span * floor_of(ranges);
    case RotaryDirection::negative:
      return target + span * floor_of(-ranges);
    default:
      return target + span * floor_of(0.5 - ranges);  // if both ways are equal, the positive one
  }
}

}  // namespace vdrive
