// SPDX-License-Identifier: Apache-2.0
#include "drive/homing.hpp"

#include "drive/demand.hpp"
#include "drive/registers.hpp"
#include "drive/rounding.hpp"

#include <algorithm>
#include <array>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// One method of 6098h.
struct Method {
  std::int8_t number;
  std::int8_t direction;  // of the first movement; 0 = none
  bool limit;             // home lies where the limit switch in that direction is left
  bool index;             // home is the next index pulse
};

constexpr std::array<Method, 8> kMethods{{
    {1, -1, true, true},
    {2, +1, true, true},
    {17, -1, true, false},
    {18, +1, true, false},
    {33, -1, false, true},
    {34, +1, false, true},
    {35, 0, false, false},
    {37, 0, false, false},
}};

const Method* find_method(std::int64_t number) {
  const auto* const method =
      std::find_if(kMethods.begin(), kMethods.end(), [number](const Method& m) {
        return m.number == number;
      });
  return method == kMethods.end() ? nullptr : method;
}

/// The method of the present run; a run has one.
const Method& method_of(const DriveContext& axis) {
  return *find_method(axis.state.homing.method);
}

/// @return whether the limit switch in `direction` is active.
bool at_limit(const DriveContext& axis, double direction) {
  return (axis.state.limits.inputs &
          (direction > 0.0 ? kPositiveLimitInput : kNegativeLimitInput)) != 0;
}

/// Index pulse of the motor's encoder, once a revolution: the first one that was passed in
/// `direction` since the reading `before`. One on which the motor stood does not count.
/// @return true and its place in the motor's frame [UU].
bool passed_index(const DriveContext& axis, double direction, double before, double& place) {
  const double offset = axis.registers.index.offset;
  const auto revolutions = [direction, offset](double reading) {
    return direction * (reading - offset) / kUserUnitsPerRevolution;
  };
  const double pulse = floor_of(revolutions(before)) + 1.0;
  if (pulse > revolutions(axis.servo.motor_reading[axis.lane])) {
    return false;
  }
  place = direction * pulse * kUserUnitsPerRevolution + offset;
  return true;
}

/// `home` [UU] becomes position 607Ch: the frame of all positions moves, the mechanics do not.
void attain(const DriveContext& axis, double home) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  const double offset = real(axis, "home_offset"_object);
  const double shift = home - offset;
  shift_frame(axis, {.motor = shift, .load = shift, .reading = shift});
  r.request = {};  // the plan was made in the frame of before
  s.target.position = offset;
  s.target.arrived = false;
  s.homing.stage = HomingStage::back;
  s.limits.homed = true;
  update_derived(axis);
}

void attain_at_index(const DriveContext& axis, double place) {
  const double ratio = axis.registers.single_encoder ? 1.0 : axis.registers.gear_ratio;
  const std::size_t l = axis.lane;
  attain(axis, axis.servo.load_reading[l] + ratio * (place - axis.servo.motor_reading[l]));
}

void seek_index(const DriveContext& axis, double before, bool index_input_rose) {
  const double direction = homing_direction(axis);
  double place = 0.0;
  if (passed_index(axis, direction, before, place)) {
    attain_at_index(axis, place);
  } else if (index_input_rose) {
    attain(axis, axis.servo.load_reading[axis.lane]);
  } else if (at_limit(axis, direction)) {
    axis.state.homing.stage = HomingStage::failed;
  }
}

void leave_limit(const DriveContext& axis) {
  DriveState& s = axis.state;
  const double direction = homing_direction(axis);
  if (at_limit(axis, direction)) {
    s.homing.stage = HomingStage::failed;
  } else if (!at_limit(axis, -direction) && direction * s.demand.velocity > 0.0) {
    if (method_of(axis).index) {
      s.homing.stage = HomingStage::index;
    } else {
      attain(axis, axis.servo.load_reading[axis.lane]);
    }
  }
}

}  // namespace

bool is_homing_method(std::int64_t value) {
  return value == 0 || find_method(value) != nullptr;
}

bool homing_runs(HomingStage stage) {
  return stage != HomingStage::idle && stage != HomingStage::done && stage != HomingStage::failed;
}

double homing_direction(const DriveContext& axis) {
  switch (axis.state.homing.stage) {
    case HomingStage::search:
      return method_of(axis).direction;
    case HomingStage::leave:
      return -method_of(axis).direction;
    case HomingStage::index: {
      const Method& method = method_of(axis);
      return method.limit ? -method.direction : method.direction;
    }
    default:
      return 0.0;
  }
}

bool start_homing(const DriveContext& axis) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  if (homing_runs(s.homing.stage)) {
    return false;
  }
  s.limits.homed = false;
  s.window.dwell = 0;
  s.target.arrived = false;
  s.homing.method = static_cast<std::int8_t>(reg(axis, "homing_method"_object));
  r.index.input = reg(axis, "test_index_pulse_input"_object) != 0;
  r.index.reading = axis.servo.motor_reading[axis.lane];
  const Method* const method = find_method(s.homing.method);
  const bool has_speeds =
      reg(axis, "homing_speed_search"_object) != 0 && reg(axis, "homing_speed_creep"_object) != 0;
  if (method == nullptr || (method->direction != 0 && !has_speeds)) {
    s.homing.stage = HomingStage::failed;
  } else if (method->direction == 0) {
    s.homing.stage = HomingStage::present;
  } else if (method->limit) {
    s.homing.stage = at_limit(axis, method->direction) ? HomingStage::leave : HomingStage::search;
  } else {
    s.homing.stage = HomingStage::index;
  }
  update_derived(axis);
  return true;
}

void advance_homing(const DriveContext& axis) {
  DriveState& s = axis.state;
  if (s.target.fresh || !homing_runs(s.homing.stage)) {
    return;  // the status shows the start before anything is found
  }
  if (s.power.machine.pending() != PowerCommand::none) {
    interrupt_homing(axis);
    return;
  }
  DriveRegisters& r = axis.registers;
  const bool index_input = reg(axis, "test_index_pulse_input"_object) != 0;
  const bool rose = index_input && !r.index.input;
  const double before = r.index.reading;
  r.index.input = index_input;
  r.index.reading = axis.servo.motor_reading[axis.lane];
  switch (s.homing.stage) {
    case HomingStage::present:
      if (!s.demand.moving) {
        attain(axis, s.demand.position);
        rest_at(axis, s.target.position);  // 6099h may be 0 here: nothing may be left to travel
      }
      break;
    case HomingStage::search:
      if (at_limit(axis, homing_direction(axis))) {
        s.homing.stage = HomingStage::leave;
      }
      break;
    case HomingStage::leave:
      leave_limit(axis);
      break;
    case HomingStage::index:
      seek_index(axis, before, rose);
      break;
    default:
      break;
  }
}

void interrupt_homing(const DriveContext& axis) {
  if (homing_runs(axis.state.homing.stage)) {
    axis.state.homing.stage = HomingStage::idle;
    axis.state.plan_due = true;
  }
}

}  // namespace vdrive
