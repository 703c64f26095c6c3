// SPDX-License-Identifier: Apache-2.0
#include "drive/frame.hpp"

#include "rounding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace vdrive {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRange = 4294967296.0;  // of a 32-bit position register

/// The multiple of the register range between `position` and the value that the register shows.
double whole_turns(double position) {
  return kRange * floor_of(nearest(position) / kRange + 0.5);
}

/// The multiple of the range 607Bh between `position` and the value shown.
double whole_ranges(const PositionRange& range, double position) {
  return range.span * floor_of((nearest(position) - range.lower) / range.span);
}

/// Acceleration of the demand at the end of the last tick [UU/s²].
double demand_acceleration(const Drive& drive) {
  if (!drive.state().demand.moving) return 0.0;
  const JerkSegment segment = jerk_segment_of(drive.demand(), drive.lane());
  return sample(segment, plan_time(drive)).acceleration;
}

}  // namespace

void put_segment(Drive& drive, const JerkSegment& segment) {
  DemandBlock& demand = drive.demand();
  const std::size_t l = drive.lane();
  demand.segment_position[l] = segment.position;
  demand.segment_velocity[l] = segment.velocity;
  demand.segment_acceleration[l] = segment.acceleration;
  demand.segment_jerk[l] = segment.jerk;
  demand.reference_time[l] = segment.reference_time;
  demand.end_time[l] = segment.end_time;
}

double plan_time(const Drive& drive) {
  const double ticks = drive.demand().plan_ticks[drive.lane()];
  return (ticks * drive.timing().substeps) * drive.timing().substep;
}

double starting_acceleration(const Drive& drive, const MotionLimits& limits,
                             const MotionJerk& jerk) {
  const double acceleration = demand_acceleration(drive);
  const std::size_t l = drive.lane();
  if ((drive.block().jerk_limited & (std::uint64_t{1} << l)) != 0) return acceleration;
  const double velocity = drive.demand().velocity[l];
  const double direction = velocity < 0.0 ? -1.0 : 1.0;
  const double speed = std::abs(velocity);
  const double room = std::max(limits.velocity - speed, 0.0);
  const double most = std::min(limits.acceleration, std::sqrt(2.0 * jerk.acceleration * room));
  const double least = -std::min(limits.deceleration, std::sqrt(2.0 * jerk.deceleration * speed));
  return direction * std::min(std::max(direction * acceleration, least), most);
}

void rest_at(Drive& drive, double position) {
  DemandBlock& demand = drive.demand();
  const std::size_t l = drive.lane();
  demand.position[l] = position;
  demand.velocity[l] = 0.0;
  demand.plan_ticks[l] = 0.0;
  put_segment(drive, {.end_time = kInfinity, .position = position});
  drive.block().jerk_limited &= ~(std::uint64_t{1} << l);
  drive.state().demand.moving = false;
}

void shift_frame(Drive& drive, const FrameShift& shift) {
  DriveState& s = drive.state();
  DriveRegisters& r = drive.registers();
  ServoState& servo = drive.servo();
  const std::size_t l = drive.lane();
  servo.position[l] -= shift.motor;
  servo.measured[l] -= shift.motor;
  servo.motor_reading[l] -= shift.motor;
  const double offset = r.index.offset - shift.motor;
  r.index.offset = offset - kUserUnitsPerRevolution * nearest(offset / kUserUnitsPerRevolution);
  r.index.reading -= shift.motor;
  r.origins.motor -= shift.motor;
  r.origins.load -= shift.load;
  r.touch_probe.motor_reading -= shift.motor;
  r.homing.pressed_at -= shift.reading;
  servo.load_offset[l] += r.gear_ratio * shift.motor - shift.load;
  servo.load_position[l] -= shift.load;
  servo.load_reading[l] -= shift.reading;
  drive.demand().position[l] -= shift.reading;
  s.target.position -= shift.reading;
}

void rebase(Drive& drive) {
  const ServoState& servo = drive.servo();
  const std::size_t l = drive.lane();
  const bool single = drive.registers().single_encoder;
  const double demand = drive.demand().position[l];
  const double turns =
      is_modulo(drive) ? whole_ranges(drive.registers().range, demand) : whole_turns(demand);
  const double motor = whole_turns(servo.motor_reading[l]);
  const double load = whole_turns(servo.load_position[l]);
  shift_frame(drive,
              {.motor = single ? turns : motor, .load = single ? load : turns, .reading = turns});
}

std::int32_t shown_position(const Drive& drive, double position) {
  if (!is_modulo(drive)) return wrapped(position);
  const double whole = nearest(position);
  return wrapped(whole - whole_ranges(drive.registers().range, whole));
}

double shorter_way(const Drive& drive, double distance) {
  if (!is_modulo(drive)) return wrapped(distance);
  const double span = drive.registers().range.span;
  // Computed for the opposite direction, so that exactly half a range gives the positive way.
  const double back = -distance;
  return -(back - span * floor_of(back / span + 0.5));
}

}  // namespace vdrive
