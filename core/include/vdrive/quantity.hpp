// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"
#include "vdrive/unit.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive {

/// Positions, speeds, accelerations and jerks as people write and read them: in user units (UU) or
/// in a unit of the axis.

/// The dimension of a quantity.
enum class Dimension : std::uint8_t { position, velocity, acceleration, jerk };

/// A quantity as written. The unit of an axis converts it to user units.
struct WrittenQuantity {
  double value = 0.0;
  /// The unit of the position, such as "deg" for 90deg/s; "UU" if none was written; or "rpm".
  std::string unit;

  /// @return whether it needs no conversion and so means the same for every axis.
  [[nodiscard]] bool is_in_user_units() const { return unit == "UU"; }
};

/// @param text a decimal number such as -500 or 1e4, with or without a unit: 90deg, 180deg/s,
///        900deg/s2, 9000deg/s3, 300rpm
/// @throws std::invalid_argument for anything else and for a fraction of a user unit; the message
///         contains the text and an example.
[[nodiscard]] WrittenQuantity read_quantity(std::string_view text, Dimension dimension);

/// @return the quantity in [UU], [UU/s], [UU/s²] or [UU/s³], not rounded; nothing if the axis has
///         no such unit.
[[nodiscard]] std::optional<double> to_user_units(const WrittenQuantity& quantity,
                                                  const Unit& unit);

/// @return the units that the axis accepts for a quantity, such as "mm/s, m/s, cm/s, um/s, UU/s".
[[nodiscard]] std::string list_of_units(Dimension dimension, const Unit& unit);

/// @return the suffix that follows the unit of a position: "", "/s", "/s2" or "/s3".
[[nodiscard]] std::string_view unit_ending(Dimension dimension) noexcept;

/// @return the unit of an axis whose own unit is unknown: values are shown in UU only.
[[nodiscard]] Unit user_unit();

/// @return the unit of the axis in this dimension, such as "mm/s3".
[[nodiscard]] std::string unit_name(Dimension dimension, const Unit& unit);

/// @param user_units [UU], [UU/s], [UU/s²] or [UU/s³]
/// @return a text such as "1024 UU/s (90.00 deg/s)", or "1024 UU/s" for user_unit(). Every message
///         shows quantities in this form.
[[nodiscard]] std::string quantity_text(std::int64_t user_units, Dimension dimension,
                                        const Unit& unit);

/// @return what the object measures; nothing if it is no position, speed, acceleration or jerk.
[[nodiscard]] std::optional<Dimension> dimension_of(ObjectRow row) noexcept;

/// @return a value of the object as quantity_text, or as a plain number if it has no dimension.
[[nodiscard]] std::string object_value_text(ObjectRow row, std::int64_t value, const Unit& unit);

/// @return advice_on() of vdrive/dictionary/object_text.hpp, with limits in the unit of the axis.
[[nodiscard]] std::string advice_on(ObjectAddress object, AbortCode code, const Unit& unit);

}  // namespace vdrive
