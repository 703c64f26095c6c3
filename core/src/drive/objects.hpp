// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <cstdint>

namespace vdrive {

// Writes and reads of objects, and what they mean to the axis.

/// What the bank has to do after a write.
enum class WriteEffect : std::uint8_t { none, torque_limits, gear };

/// The rules of one object for its value: those of the table, and the narrower ones of its meaning.
[[nodiscard]] AbortCode check_object_value(ObjectRow row, std::int64_t value) noexcept;

/// A write that the dictionary allows; see AxisBank::write.
AbortCode write_object(Drive& drive, ObjectRow row, std::int64_t value,
                       WriteEffect& effect) noexcept;

[[nodiscard]] std::int64_t read_object(const Drive& drive, ObjectRow row, AbortCode& code) noexcept;

}  // namespace vdrive
