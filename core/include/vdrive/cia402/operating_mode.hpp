// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace vdrive {

/// Operating modes of 6060h and 6061h that the drive has (CiA 402-2, modes of operation).
enum class OperatingMode : std::int8_t {
  none = 0,  ///< empty mode: enabled, no motion
  profile_position = 1,
  velocity = 2,  ///< of inverters (vl)
  profile_velocity = 3,
  profile_torque = 4,
  homing = 6,
  interpolated_position = 7,
  cyclic_synchronous_position = 8,
  cyclic_synchronous_velocity = 9,
  cyclic_synchronous_torque = 10,
};

/// A bit of the controlword 6040h or the statusword 6041h and its name, such as "speed zero".
struct BitName {
  std::uint16_t bit = 0;
  std::string_view name;
};

/// What people read about an operating mode.
struct OperatingModeRow {
  OperatingMode mode = OperatingMode::none;
  std::string_view name;                  ///< the standard's
  std::array<BitName, 2> status_bits{};   ///< of 6041h that it reads in its own way
  std::array<BitName, 3> control_bits{};  ///< likewise of 6040h
  bool has_target = true;                 ///< bit 10 of 6041h says whether a target is reached
  bool commands_torque = false;           ///< an axis that stands may press with a torque
};

/// Every operating mode, by rising number: 6502h, the values of 6060h and all names follow from it.
inline constexpr std::array kOperatingModes{
    OperatingModeRow{.mode = OperatingMode::none, .name = "none", .has_target = false},
    OperatingModeRow{
        .mode = OperatingMode::profile_position,
        .name = "profile position",
        .status_bits = {{{Statusword::kSetPointAcknowledge, "set-point acknowledge"}}},
        .control_bits = {{{Controlword::kNewSetPoint, "new set-point"},
                          {Controlword::kChangeSetImmediately, "change set immediately"},
                          {Controlword::kRelative, "relative"}}}},
    OperatingModeRow{.mode = OperatingMode::velocity,
                     .name = "velocity",
                     .control_bits = {{{Controlword::kEnableRamp, "enable ramp"},
                                       {Controlword::kUnlockRamp, "unlock ramp"},
                                       {Controlword::kReferenceRamp, "reference ramp"}}}},
    OperatingModeRow{.mode = OperatingMode::profile_velocity,
                     .name = "profile velocity",
                     .status_bits = {{{Statusword::kSpeedZero, "speed zero"}}}},
    OperatingModeRow{
        .mode = OperatingMode::profile_torque, .name = "profile torque", .commands_torque = true},
    OperatingModeRow{.mode = OperatingMode::homing,
                     .name = "homing",
                     .status_bits = {{{Statusword::kHomingAttained, "homing attained"},
                                      {Statusword::kHomingError, "homing error"}}},
                     .control_bits = {{{Controlword::kStartHoming, "start homing"}}}},
    OperatingModeRow{
        .mode = OperatingMode::interpolated_position,
        .name = "interpolated position",
        .status_bits = {{{Statusword::kInterpolationActive, "interpolation active"}}},
        .control_bits = {{{Controlword::kEnableInterpolation, "enable interpolation"}}}},
    OperatingModeRow{.mode = OperatingMode::cyclic_synchronous_position,
                     .name = "cyclic synchronous position",
                     .status_bits = {{{Statusword::kFollowsCommand, "follows command"}}},
                     .has_target = false},
    OperatingModeRow{.mode = OperatingMode::cyclic_synchronous_velocity,
                     .name = "cyclic synchronous velocity",
                     .status_bits = {{{Statusword::kFollowsCommand, "follows command"}}},
                     .has_target = false},
    OperatingModeRow{.mode = OperatingMode::cyclic_synchronous_torque,
                     .name = "cyclic synchronous torque",
                     .status_bits = {{{Statusword::kFollowsCommand, "follows command"}}},
                     .has_target = false,
                     .commands_torque = true},
};

static_assert(std::ranges::is_sorted(kOperatingModes, {}, &OperatingModeRow::mode));

/// Value of 6502h: bit n - 1 stands for mode n.
inline constexpr std::uint32_t kSupportedDriveModes = [] {
  std::uint32_t bits = 0;
  for (const OperatingModeRow& row : kOperatingModes) {
    if (row.mode != OperatingMode::none) bits |= 1U << (static_cast<unsigned>(row.mode) - 1U);
  }
  return bits;
}();

/// @return whether 6060h takes `value`: 0 or a mode that 6502h shows.
[[nodiscard]] constexpr bool is_operating_mode(std::int64_t value) noexcept {
  return value == 0 ||
         (value > 0 && value <= 32 && (kSupportedDriveModes >> (value - 1) & 1U) != 0);
}

/// @return the row of `mode`, or null: 6061h of a status may come from a later version.
[[nodiscard]] constexpr const OperatingModeRow* find_operating_mode(OperatingMode mode) noexcept {
  for (const OperatingModeRow& row : kOperatingModes) {
    if (row.mode == mode) return &row;
  }
  return nullptr;
}

/// @return the standard's name of `mode`, such as "profile position"; "unknown" where it has no
///         row.
[[nodiscard]] std::string_view to_string(OperatingMode mode) noexcept;

}  // namespace vdrive
