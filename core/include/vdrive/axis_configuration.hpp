// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"
#include "vdrive/plant/axis_model.hpp"

#include <cstdint>
#include <vector>

namespace vdrive {

/// Points on which drives read the standard differently; the defaults follow the manual.
struct AxisSettings {
  bool enable_from_switch_on_disabled = true;  ///< 000Fh in Switch on disabled enables (manual)
  bool acknowledge_while_halted = true;        ///< false: no set-point is taken while bit 8 is 1
  bool following_error_is_fault = true;        ///< false: bit 13 without fault
  bool limits_need_homing = false;             ///< 607Dh is in force only once the axis is homed
  std::uint16_t quick_stop_dwell_ms = 0;       ///< [ms] shortest time in Quick stop active
};

/// A value that an object takes at power-up instead of its default.
struct InitialValue {
  ObjectAddress address;
  std::int64_t value = 0;
};

/// @return whether the object is part of the identity object (1018h), whose values come only from
///         the configuration of an axis.
[[nodiscard]] constexpr bool is_identity(ObjectAddress address) noexcept {
  return address.index == 0x1018;
}

/// The complete configuration of one axis.
struct AxisConfiguration {
  AxisModel model;
  AxisSettings settings;
  std::int32_t initial_position = 0;     ///< [user units] at first power-up
  std::uint32_t serial_number = 0;       ///< 1018h:04
  std::vector<InitialValue> parameters;  ///< written at each power-up; may include 1018h (identity)

  /// Values that the axis stored with 1010h in an earlier run; see AxisBank::set_stored.
  std::vector<InitialValue> stored{};
  /// The stored values are unusable: fault 5530h at every power-up until AxisBank::forget_stored.
  bool memory_error = false;
};

}  // namespace vdrive
