// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/drive.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace vdrive {

// Questions that every part of the drive asks of an axis.

inline constexpr std::uint32_t kSaturatedCount = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint32_t kWindowOff = std::numeric_limits<std::uint32_t>::max();

/// Bits of the digital inputs 60FDh.
inline constexpr std::uint8_t kNegativeLimitInput = 1U << 0U;
inline constexpr std::uint8_t kPositiveLimitInput = 1U << 1U;
inline constexpr std::uint8_t kHomeInput = 1U << 2U;

[[nodiscard]] inline std::int64_t reg(const DriveContext& axis, ObjectRow row) {
  return axis.registers.values[row];
}

[[nodiscard]] inline double real(const DriveContext& axis, ObjectRow row) {
  return static_cast<double>(axis.registers.values[row]);
}

[[nodiscard]] inline std::uint32_t ticks_of_ms(const DriveContext& axis,
                                               std::int64_t milliseconds) {
  const std::int64_t period = axis.timing.period_us;
  return static_cast<std::uint32_t>((milliseconds * 1000 + period - 1) / period);
}

[[nodiscard]] inline bool operation_enabled(const DriveContext& axis) {
  return axis.state.power.machine.state() == PowerState::operation_enabled;
}

[[nodiscard]] inline bool halted(const DriveContext& axis) {
  return (axis.state.controlword & Controlword::kHalt) != 0;
}

/// @return `target` [UU] within 607Dh where that is in force.
[[nodiscard]] inline double clamp_to_software_limits(const DriveContext& axis, double target) {
  const DriveState& s = axis.state;
  return s.limits.enabled ? std::min(std::max(target, s.limits.lower), s.limits.upper) : target;
}

/// Demand and actual speed are zero.
[[nodiscard]] inline bool at_rest(const DriveContext& axis) {
  return !axis.state.demand.moving && std::abs(axis.servo.load_speed[axis.lane]) <=
                                          static_cast<double>(axis.state.window.threshold);
}

}  // namespace vdrive
