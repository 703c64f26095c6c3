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
  velocity = 2,  ///< of frequency inverters (vl)
  profile_velocity = 3,
  profile_torque = 4,
  homing = 6,
  interpolated_position = 7,
  cyclic_synchronous_position = 8,
  cyclic_synchronous_velocity = 9,
  cyclic_synchronous_torque = 10,
};

/// A bit of the controlword 6040h or the statusword 6041h with its names, such as "speed zero".
struct BitName {
  std::uint16_t bit = 0;
  std::string_view name;
  std::string_view name_zh;
};

/// Names and properties of an operating mode for display.
struct OperatingModeRow {
  OperatingMode mode = OperatingMode::none;
  std::string_view name;                  ///< as in the standard
  std::string_view name_zh;               ///< in Chinese, like the names of objects
  std::array<BitName, 2> status_bits{};   ///< bits of 6041h specific to this mode
  std::array<BitName, 3> control_bits{};  ///< likewise for 6040h
  bool has_target = true;                 ///< bit 10 of 6041h shows whether a target is reached
  bool commands_torque = false;           ///< an axis at standstill may still press with a torque
};

/// Every operating mode, in ascending order. 6502h, the values of 6060h and all names are derived
/// from this table.
inline constexpr std::array kOperatingModes{
    OperatingModeRow{
        .mode = OperatingMode::none, .name = "none", .name_zh = "无", .has_target = false},
    OperatingModeRow{.mode = OperatingMode::profile_position,
                     .name = "profile position",
                     .name_zh = "轮廓位置",
                     .status_bits = {{{Statusword::kSetPointAcknowledge, "set-point acknowledge",
                                       "设定点应答"}}},
                     .control_bits = {{{Controlword::kNewSetPoint, "new set-point", "新设定点"},
                                       {Controlword::kChangeSetImmediately,
                                        "change set immediately", "立即更改"},
                                       {Controlword::kRelative, "relative", "相对"}}}},
    OperatingModeRow{
        .mode = OperatingMode::velocity,
        .name = "velocity",
        .name_zh = "速度",
        .control_bits = {{{Controlword::kEnableRamp, "enable ramp", "使能斜坡"},
                          {Controlword::kUnlockRamp, "unlock ramp", "解锁斜坡"},
                          {Controlword::kReferenceRamp, "reference ramp", "斜坡给定"}}}},
    OperatingModeRow{.mode = OperatingMode::profile_velocity,
                     .name = "profile velocity",
                     .name_zh = "轮廓速度",
                     .status_bits = {{{Statusword::kSpeedZero, "speed zero", "零速"}}}},
    OperatingModeRow{.mode = OperatingMode::profile_torque,
                     .name = "profile torque",
                     .name_zh = "轮廓转矩",
                     .commands_torque = true},
    OperatingModeRow{.mode = OperatingMode::homing,
                     .name = "homing",
                     .name_zh = "回零",
                     .status_bits = {{{Statusword::kHomingAttained, "homing attained", "回零完成"},
                                      {Statusword::kHomingError, "homing error", "回零错误"}}},
                     .control_bits = {{{Controlword::kStartHoming, "start homing", "开始回零"}}}},
    OperatingModeRow{
        .mode = OperatingMode::interpolated_position,
        .name = "interpolated position",
        .name_zh = "插补位置",
        .status_bits = {{{Statusword::kInterpolationActive, "interpolation active", "插补有效"}}},
        .control_bits = {{{Controlword::kEnableInterpolation, "enable interpolation",
                           "使能插补"}}}},
    OperatingModeRow{
        .mode = OperatingMode::cyclic_synchronous_position,
        .name = "cyclic synchronous position",
        .name_zh = "周期同步位置",
        .status_bits = {{{Statusword::kFollowsCommand, "follows command", "跟随指令"}}},
        .has_target = false},
    OperatingModeRow{
        .mode = OperatingMode::cyclic_synchronous_velocity,
        .name = "cyclic synchronous velocity",
        .name_zh = "周期同步速度",
        .status_bits = {{{Statusword::kFollowsCommand, "follows command", "跟随指令"}}},
        .has_target = false},
    OperatingModeRow{
        .mode = OperatingMode::cyclic_synchronous_torque,
        .name = "cyclic synchronous torque",
        .name_zh = "周期同步转矩",
        .status_bits = {{{Statusword::kFollowsCommand, "follows command", "跟随指令"}}},
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

/// @return whether 6060h accepts `value`: 0 or a mode shown in 6502h.
[[nodiscard]] constexpr bool is_operating_mode(std::int64_t value) noexcept {
  return value == 0 ||
         (value > 0 && value <= 32 && (kSupportedDriveModes >> (value - 1) & 1U) != 0);
}

/// @return the row of `mode`, or null: a status may come from a later version with more modes.
[[nodiscard]] constexpr const OperatingModeRow* find_operating_mode(OperatingMode mode) noexcept {
  for (const OperatingModeRow& row : kOperatingModes) {
    if (row.mode == mode) return &row;
  }
  return nullptr;
}

/// @return the standard's name of `mode`, such as "profile position"; "unknown" for a mode without
///         a row.
[[nodiscard]] std::string_view to_string(OperatingMode mode) noexcept;

}  // namespace vdrive
