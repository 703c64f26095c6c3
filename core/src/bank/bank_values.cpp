// SPDX-License-Identifier: Apache-2.0
#include "bank/bank_state.hpp"
#include "drive/objects.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"
#include "drive/tick.hpp"
#include "vdrive/dictionary/object_text.hpp"

#include <cstddef>
#include <stdexcept>
#include <string>

namespace vdrive {

using namespace vdrive::literals;

namespace {

/// @param axes number of axes of the bank; a single axis is not named in the message
[[noreturn]] void refuse(std::size_t axis, std::size_t axes, const char* kind,
                         const InitialValue& refused) {
  const std::string place = axes == 1 ? "" : "axis " + std::to_string(axis) + ": ";
  throw std::invalid_argument(place + kind + " value " + std::to_string(refused.value) + " of " +
                              object_text(refused.address) + " is refused");
}

}  // namespace

void AxisBank::State::start_axis(std::size_t axis) {
  Drive drive = this->drive(axis);
  const auto position = static_cast<double>(configurations[axis].initial_position);
  ServoState& servo = drive.servo();
  for (Lane* lane : {&servo.position, &servo.measured, &servo.motor_reading, &servo.load_position,
                     &servo.load_reading}) {
    (*lane)[drive.lane()] = position;
  }
  // Objects of the test bench keep their values at a power-up, so they get their defaults only
  // here.
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    drive.registers().values[row] = kObjectRows[row].default_value;
  }
  drive.registers().settings = configurations[axis].settings;
  drive.registers().single_encoder =
      configurations[axis].model.feedback == Feedback::single_encoder;
  fill_memory(axis);
  power_up(drive, true);
  show(drive);  // before an initial value can freeze the feedback (5E0Ch)
  if (const InitialValue* const refused = set_initial_values(axis)) {
    refuse(axis, configurations.size(), "initial", *refused);
  }
  show(drive);
}

void AxisBank::State::fill_memory(std::size_t axis) {
  for (const InitialValue& stored : configurations[axis].stored) {
    if (memories[axis].keep(stored.address, stored.value) != AbortCode::none) {
      refuse(axis, configurations.size(), "stored", stored);
    }
  }
  drive(axis).registers().memory_error = configurations[axis].memory_error;
}

const InitialValue* AxisBank::State::set_initial_values(std::size_t axis) {
  Drive drive = this->drive(axis);
  drive.registers().values["serial_number"_object] = configurations[axis].serial_number;
  const InitialValue* refused = nullptr;
  for (const InitialValue& initial : configurations[axis].parameters) {
    const auto row = find_row(initial.address);
    if (row && is_identity(initial.address)) {
      drive.registers().values[*row] = initial.value;
      continue;
    }
    // A controlword is a command, not a parameter: no axis is enabled by its configuration.
    const bool allowed = row && *row != "ds402_controlword"_object &&
                         write_object(drive, *row, initial.value).code == AbortCode::none;
    if (!allowed && refused == nullptr) refused = &initial;
  }
  memories[axis].load_into(drive);
  update_derived(drive);
  apply_gear(axis);
  return refused;
}

AbortCode AxisBank::State::write(std::size_t axis, ObjectRow row, std::int64_t value) {
  Drive drive = changed_drive(axis);
  const WriteResult result = write_object(drive, row, value);
  if (result.servo == ServoUpdate::gear) apply_gear(axis);
  if (result.servo == ServoUpdate::torques) apply_torques(axis);
  return result.code;
}

}  // namespace vdrive
