// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/assert.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace vdrive {

// Registers and readings of an axis in the form that the drive uses.

inline constexpr std::uint32_t kSaturatedCount = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint32_t kWindowOff = std::numeric_limits<std::uint32_t>::max();

/// Bits of the digital inputs 60FDh.
inline constexpr std::uint8_t kNegativeLimitInput = 1U << 0U;
inline constexpr std::uint8_t kPositiveLimitInput = 1U << 1U;
inline constexpr std::uint8_t kHomeInput = 1U << 2U;

[[nodiscard]] inline std::int64_t reg(const Drive& drive, ObjectRow row) {
  ensure(row < kObjectCount, "a register has a row of the dictionary");
  return drive.registers().values[row];
}

[[nodiscard]] inline std::uint32_t unsigned_reg(const Drive& drive, ObjectRow row) {
  return static_cast<std::uint32_t>(reg(drive, row));
}

[[nodiscard]] inline double real(const Drive& drive, ObjectRow row) {
  return static_cast<double>(reg(drive, row));
}

/// @return a time [us] in ticks, rounded up.
[[nodiscard]] inline std::uint32_t ticks_of_us(const Drive& drive, std::int64_t microseconds) {
  const std::int64_t period = drive.timing().period_us;
  return static_cast<std::uint32_t>((microseconds + period - 1) / period);
}

[[nodiscard]] inline std::uint32_t ticks_of_ms(const Drive& drive, std::int64_t milliseconds) {
  return ticks_of_us(drive, milliseconds * 1000);
}

/// @return the demand at the end of the last tick [UU], not rounded.
[[nodiscard]] inline double demand_position(const Drive& drive) {
  return drive.demand().position[drive.lane()];
}

/// @return the velocity of the demand [UU/s], not rounded.
[[nodiscard]] inline double demand_velocity(const Drive& drive) {
  return drive.demand().velocity[drive.lane()];
}

/// @return the actual position 6064h [UU], not rounded.
[[nodiscard]] inline double actual_position(const Drive& drive) {
  return drive.servo().load_reading[drive.lane()];
}

/// @return the actual velocity 606Ch [UU/s], not rounded.
[[nodiscard]] inline double actual_velocity(const Drive& drive) {
  return drive.servo().load_speed[drive.lane()];
}

/// @return the commanded torque [‰ of rated].
[[nodiscard]] inline double commanded_torque(const Drive& drive) {
  return drive.servo().command[drive.lane()] * drive.block().units.torque_per_mille[drive.lane()];
}

[[nodiscard]] inline bool operation_enabled(const Drive& drive) {
  return drive.state().power.machine.state() == PowerState::operation_enabled;
}

[[nodiscard]] inline bool halted(const Drive& drive) {
  return (drive.state().controlword & Controlword::kHalt) != 0;
}

/// @return whether the readings are frozen at the values that they had when 5E0Ch became 1.
[[nodiscard]] inline bool shows_frozen_feedback(const Drive& drive) {
  return (drive.block().frozen >> drive.lane() & 1U) != 0;
}

/// Converts registers to the form that the tick uses, after they were written.
void update_derived(Drive& drive) noexcept;

/// @return the velocity of 6064h [UU/s] at a motor speed of `rpm`, not rounded.
[[nodiscard]] inline double velocity_of_motor(const Drive& drive, double rpm) noexcept {
  const DriveRegisters& registers = drive.registers();
  return velocity_of_motor(
      rpm, registers.single_encoder ? Feedback::single_encoder : Feedback::dual_encoder,
      registers.gear_ratio);
}

/// Applies the present speed limits with the present gear, after either has changed.
void update_velocity_cap(Drive& drive) noexcept;

/// @return bits of 60FDh: the inputs set by the test bench (5E06h to 5E08h), and the switches with
///         a position (5E21h) that are active at the exact position of the axis.
[[nodiscard]] std::uint8_t active_inputs(const Drive& drive) noexcept;

/// Finds an index pulse of encoder 1, which comes once per motor revolution, between two readings
/// [UU in the frame of the motor]. A pulse on which the motor stood does not count.
/// @param direction +1 or -1
/// @return the position of the first pulse passed in `direction`, or nothing.
[[nodiscard]] std::optional<double> index_pulse_passed(const Drive& drive, double direction,
                                                       double before, double now) noexcept;

}  // namespace vdrive
