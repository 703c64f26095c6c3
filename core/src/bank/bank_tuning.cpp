// SPDX-License-Identifier: Apache-2.0
#include "bank/bank_state.hpp"
#include "drive/registers.hpp"
#include "plant/effects.hpp"
#include "plant/servo_design.hpp"
#include "torque_limit.hpp"
#include "vdrive/plant/model_parameters.hpp"

#include <algorithm>

namespace vdrive {

using namespace vdrive::literals;

namespace {

Gear gear_of(const DriveRegisters& registers) {
  return {static_cast<std::uint32_t>(registers.values["gear_ratio_numerator"_object]),
          static_cast<std::uint32_t>(registers.values["gear_ratio_denominator"_object])};
}

/// The torque limit [N.m] from 6072h and `relative`, which is 60E0h or 60E1h.
double torque_limit_of(const DriveRegisters& registers, const AxisModel& model,
                       ObjectRow relative) {
  const auto value = [&registers](ObjectRow row) {
    return static_cast<double>(registers.values[row]);
  };
  const double rated_torque = value("motor_rated_torque"_object) * 1.0e-3;
  const double current_torque =
      value("motor_rated_current"_object) * 1.0e-3 * model.torque_constant;
  const double highest = value("max_torque"_object) * 1.0e-3 * rated_torque;
  return torque_limit(highest, value(relative) * 1.0e-3, std::min(rated_torque, current_torque));
}

}  // namespace

void AxisBank::State::apply_gear(std::size_t axis) {
  Drive drive = this->drive(axis);
  const AxisModel& model = configurations[axis].model;
  const Gear gear = gear_of(drive.registers());
  const double ratio = ratio_of(gear);
  DriveRegisters& registers = drive.registers();
  if (ratio != registers.gear_ratio) {
    // Setting the gear must not move the load.
    ServoState& servo = drive.servo();
    servo.load_offset[drive.lane()] +=
        (registers.gear_ratio - ratio) * servo.position[drive.lane()];
    registers.gear_ratio = ratio;
    update_velocity_cap(drive);
    const Block& block = blocks[places[axis].block];
    if (block.coupling == Coupling::rigid) {
      design_lane(model, gear, timing.substep, drive.lane(), rigid.change(block.pool_index));
    } else {
      design_lane(model, gear, timing.substep, drive.lane(), elastic.change(block.pool_index));
    }
    design_effects(axis, gear);
  }
  apply_torques(axis);
}

void AxisBank::State::design_effects(std::size_t axis, const Gear& gear) {
  const Place& place = places[axis];
  const Block& block = blocks[place.block];
  EffectBlock* const of_block = effects_of(block);
  if (of_block == nullptr) return;
  const double velocity_from_load =
      block.coupling == Coupling::rigid
          ? rigid.get(block.pool_index).velocity_from_load[place.lane]
          : elastic.get(block.pool_index).free_motor_velocity.motor_load[place.lane];
  vdrive::design_effects(
      configurations[axis].model, gear,
      {.period = timing.period_us * 1.0e-6, .velocity_from_load = velocity_from_load}, place.lane,
      *of_block);
}

void AxisBank::State::apply_torques(std::size_t axis) {
  Drive drive = this->drive(axis);
  const DriveRegisters& registers = drive.registers();
  const AxisModel& model = configurations[axis].model;
  const Gear gear = gear_of(registers);
  const double unit = torque_unit(model, gear);
  const auto value = [&registers](ObjectRow row) {
    return static_cast<double>(registers.values[row]);
  };
  UnitBlock& units = drive.block().units;
  units.torque_per_mille[drive.lane()] = unit / (value("motor_rated_torque"_object) * 1.0e-6);
  units.current_per_mille[drive.lane()] =
      unit / model.torque_constant / (value("motor_rated_current"_object) * 1.0e-6);
  LoadNoise& noise = noises[axis];
  noise.per_torque = load_torque_factor(model, gear);
  noise.load =
      (value("test_load_torque"_object) * 1.0e-3 + model.gravity_torque) * noise.per_torque;
  drive.servo().load_torque[drive.lane()] = noise.load;
  const TorqueLimits limits{
      .positive = torque_limit_of(registers, model, "positive_torque_limit_relative"_object),
      .negative = torque_limit_of(registers, model, "negative_torque_limit_relative"_object)};
  const Block& block = blocks[places[axis].block];
  LoopParameters wanted = block.coupling == Coupling::rigid ? rigid.get(block.pool_index).loop
                                                            : elastic.get(block.pool_index).loop;
  drive.registers().position_gain = wanted.position_gain[drive.lane()];
  const double upper = wanted.upper_limit[drive.lane()];
  const double lower = wanted.lower_limit[drive.lane()];
  limit_lane(limits, unit, drive.lane(), wanted);
  if (wanted.upper_limit[drive.lane()] == upper && wanted.lower_limit[drive.lane()] == lower) {
    return;
  }
  if (block.coupling == Coupling::rigid) {
    rigid.change(block.pool_index).loop = wanted;
  } else {
    elastic.change(block.pool_index).loop = wanted;
  }
}

}  // namespace vdrive
