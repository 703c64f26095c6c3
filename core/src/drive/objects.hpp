// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>

namespace vdrive {

// Writes and reads of objects and their effect on the axis.

/// The part of the servo that a write affects; the bank owns the parameters of the servo.
enum class ServoUpdate : std::uint8_t { none, torques, gear };

struct WriteResult {
  AbortCode code = AbortCode::none;
  ServoUpdate servo = ServoUpdate::none;  ///< none when the write is refused
};

/// @return what `write_object` would return now; see AxisBank::check.
[[nodiscard]] AbortCode check_object(const Drive& drive, ObjectRow row,
                                     std::int64_t value) noexcept;

/// Writes an object; see AxisBank::write. This is the only place that interprets Change.
WriteResult write_object(Drive& drive, ObjectRow row, std::int64_t value) noexcept;

[[nodiscard]] std::int64_t read_object(const Drive& drive, ObjectRow row, AbortCode& code) noexcept;

}  // namespace vdrive
