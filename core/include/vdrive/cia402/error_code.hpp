// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace vdrive {

/// Error codes of 603Fh and of the emergency message (CiA 301 and CiA 402 error code classes).
enum class ErrorCode : std::uint16_t {
  none = 0,
  continuous_over_current = 0x2310,
  load_level = 0x2350,
  dc_link_under_voltage = 0x3220,
  excess_temperature_drive = 0x4310,
  parameter_memory = 0x5530,
  incremental_sensor_1_fault = 0x7305,
  life_guard_or_heartbeat = 0x8130,
  following_error = 0x8611,
  sync_controller = 0x8700,
};

/// @return every error that the drive can report, by number, without `none`.
[[nodiscard]] std::span<const ErrorCode> error_codes() noexcept;

/// @return a description of `code`, or "unknown error".
[[nodiscard]] std::string_view describe(ErrorCode code) noexcept;

/// @return one sentence on what to check after this error; empty for an unknown code.
[[nodiscard]] std::string_view remedy_of(ErrorCode code) noexcept;

/// @return the bits that this error sets in the error register 1001h: its group and the generic bit
///         0 (CiA 301).
[[nodiscard]] std::uint8_t error_register_of(ErrorCode code) noexcept;

/// @return true when the drive can no longer brake and coasts whatever 605Eh says.
[[nodiscard]] bool forces_coasting(ErrorCode code) noexcept;

}  // namespace vdrive
