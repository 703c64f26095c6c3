// SPDX-License-Identifier: Apache-2.0
#include "drive/frame.hpp"

#include "drive/rounding.hpp"

#include <limits>

namespace vdrive {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRange = 4294967296.0;  // of a 32-bit position register

/// Turns of the register that lie between `position` and what the register shows of it.
double whole_turns(double position) {
  return kRange * floor_of(nearest(position) / kRange + 0.5);
}

}  // namespace

void rest_at(Drive& drive, double position) {
  DemandState& demand = drive.state().demand;
  demand.position = position;
  demand.velocity = 0.0;
  demand.segment = {.end_time = kInfinity, .position = position};
  demand.plan_ticks = 0.0;
  demand.moving = false;
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
  servo.load_offset[l] += r.gear_ratio * shift.motor - shift.load;
  servo.load_position[l] -= shift.load;
  servo.load_measured[l] -= shift.reading;
  servo.load_reading[l] -= shift.reading;
  s.demand.position -= shift.reading;
  s.target.position -= shift.reading;
}

void rebase(Drive& drive) {
  const ServoState& servo = drive.servo();
  const std::size_t l = drive.lane();
  const bool single = drive.registers().single_encoder;
  const double turns = whole_turns(drive.state().demand.position);
  const double motor = whole_turns(servo.motor_reading[l]);
  const double load = whole_turns(servo.load_position[l]);
  shift_frame(drive,
              {.motor = single ? turns : motor, .load = single ? load : turns, .reading = turns});
}

}  // namespace vdrive
