// SPDX-License-Identifier: Apache-2.0
#include "drive/objects.hpp"

#include "drive/controlword.hpp"
#include "drive/faults.hpp"
#include "drive/frame.hpp"
#include "drive/habits.hpp"
#include "drive/mode_table.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"
#include "drive/touch_probe.hpp"
#include "drive/vl_units.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace vdrive {
namespace {

using namespace vdrive::literals;

void write_mode(Drive& drive, OperatingMode wanted) {
  DriveState& s = drive.state();
  HabitWaits& waits = drive.registers().waits;
  const std::uint32_t delay = drive.registers().habits.mode;
  if (wanted == s.mode.actual) {
    waits.mode = 0;
  } else if (delay != 0 && wanted != s.mode.wanted) {
    begin_wait(drive, waits.mode, delay);
  }
  s.mode.wanted = wanted;
  follow_mode(drive);
  s.attention = true;
  s.plan_due = true;
}

/// Tells the active mode that a target was written, if the mode needs to know.
void take_target(Drive& drive, ObjectRow row) {
  if (const Mode& mode = mode_of(drive); mode.take_target != nullptr) mode.take_target(drive, row);
}

/// 5E11h: 6080h in the units of 6064h, limited to what the object can show.
std::int64_t motor_speed_limit(const Drive& drive) {
  const double limit = velocity_of_motor(drive, real(drive, "motor_max_speed_rpm"_object));
  const auto highest = static_cast<double>(kObjectRows["motor_speed_limit"_object].upper_limit);
  return static_cast<std::int64_t>(std::min(limit, highest));
}

}  // namespace

AbortCode check_object(const Drive& drive, ObjectRow row, std::int64_t value) noexcept {
  const AbortCode code =
      is_modulo(drive) ? check_value_on_modulo_axis(row, value) : check_object_value(row, value);
  if (code != AbortCode::none) return code;
  const bool is_refused = kObjectRows[row].change == Change::mode &&
                          refuses_mode_change(drive, static_cast<OperatingMode>(value));
  return is_refused ? AbortCode::refused_in_present_device_state : AbortCode::none;
}

WriteResult write_object(Drive& drive, ObjectRow row, std::int64_t value) noexcept {
  if (const AbortCode code = check_object(drive, row, value); code != AbortCode::none) {
    return {code};
  }
  const Change change = kObjectRows[row].change;
  if (change == Change::memory) {
    return {};  // the signature is not kept: the object still reads 1
  }
  const std::int64_t previous = std::exchange(drive.registers().values[row], value);
  switch (change) {
    case Change::limits:
      update_derived(drive);
      break;
    case Change::torque_limits:
      update_derived(drive);
      return {AbortCode::none, ServoUpdate::torques};
    case Change::gear:
      update_derived(drive);
      return {AbortCode::none, ServoUpdate::gear};
    case Change::plan:
      drive.state().plan_due = true;
      break;
    case Change::target:  // profile position latches it with the next set-point
    case Change::record:
      take_target(drive, row);
      break;
    case Change::planned_target:
      take_target(drive, row);
      drive.state().plan_due = true;
      break;
    case Change::power:
      write_controlword(drive, static_cast<std::uint16_t>(value));
      break;
    case Change::mode:
      write_mode(drive, static_cast<OperatingMode>(value));
      break;
    case Change::records:
      if (value != previous || value == 0) drive.registers().record_buffer.count = 0;
      break;
    case Change::history:
      clear_history(drive);
      break;
    case Change::habits:
      update_habits(drive);
      break;
    case Change::probe:
      enable_touch_probes(drive, static_cast<std::uint16_t>(previous));
      break;
    case Change::connection:
      if (previous == 0 && value != 0) lose_connection(drive);
      break;
    case Change::power_drop:
      if (previous == 0 && value != 0) drop_power(drive);
      break;
    case Change::nothing:
    case Change::memory:
      break;
  }
  return {};
}

std::int64_t read_object(const Drive& drive, ObjectRow row, AbortCode& code) noexcept {
  const DriveRegisters& registers = drive.registers();
  if (const auto monitored = value_of(drive.status(), row)) return *monitored;
  switch (row) {
    case "error_history_count"_object:
      return registers.history.count;
    case "dc_link_circuit_voltage"_object:
      return drive.state().faults.dc_link ? registers.values[row] : 0;
    case "motor_speed_limit"_object:
      return motor_speed_limit(drive);
    case "interpolation_buffer_position"_object:
      return registers.record_buffer.count;
    case "vl_velocity_demand"_object:
      return vl_velocity_demand(drive);
    case "vl_velocity_actual_value"_object:
      return vl_velocity_actual_value(drive);
    default:
      break;
  }
  const std::int64_t value = reg(drive, row);
  const ObjectAddress address = kObjectRows[row].address;
  if (address.index != 0x1003) return value;
  const std::size_t entry = address.subindex - 1U;
  if (entry >= registers.history.count) {
    code = AbortCode::no_data_available;
    return 0;
  }
  return registers.history.codes[entry];
}

}  // namespace vdrive
