// SPDX-License-Identifier: Apache-2.0
#include "drive/modulo.hpp"

#include "drive/frame.hpp"
#include "drive/registers.hpp"
#include "drive/stops.hpp"
#include "rounding.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// Bits 6 and 7 of 60F2h, the rotary axis direction option of CiA 402-2.
enum class RotaryDirection : std::uint8_t { as_linear, negative, positive, shortest };

constexpr unsigned kFirstDirectionBit = 6;
constexpr std::int64_t kDirectionMask = 3;

/// Bits that an axis kept from before it lost its range mean nothing.
RotaryDirection direction_of(const Drive& drive) {
  if (!is_modulo(drive) || drive.state().limits.enabled) return RotaryDirection::as_linear;
  const std::int64_t option = reg(drive, "positioning_option_code"_object);
  return static_cast<RotaryDirection>((option >> kFirstDirectionBit) & kDirectionMask);
}

/// Where the demand would come to rest, whole: a part of a unit is no reason for a turn.
double place_of_rest(const Drive& drive, double deceleration) {
  const double velocity = demand_velocity(drive);
  if (const MotionJerk jerk = profile_jerk(drive); is_limited(jerk)) {
    const MotionSample start{demand_position(drive), velocity, demand_acceleration(drive)};
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

double target_on_range(const Drive& drive, double target, double deceleration) {
  const RotaryDirection direction = direction_of(drive);
  if (direction == RotaryDirection::as_linear) return target;
  const double span = drive.registers().range.span;
  const double ranges = (target - place_of_rest(drive, deceleration)) / span;
  switch (direction) {
    case RotaryDirection::positive:
      return target - span * floor_of(ranges);
    case RotaryDirection::negative:
      return target + span * floor_of(-ranges);
    default:
      return target + span * floor_of(0.5 - ranges);  // of two equal ways the positive one
  }
}

}  // namespace vdrive
