// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/unit.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive {

/// Positions, speeds and ramps as people write them: in user units (UU) or in a unit of an axis.

/// What a quantity measures.
enum class Dimension : std::uint8_t { position, velocity, acceleration };

/// A quantity as it was written. The unit of an axis converts it to user units.
struct WrittenQuantity {
  double value = 0.0;
  std::string unit;  ///< of the position, without "/s" or "/s2"; "UU" where none was written; "rpm"

  /// @return whether every axis takes it for the same number.
  [[nodiscard]] bool is_in_user_units() const { return unit == "UU"; }
};

/// @param text a decimal number such as -500 or 1e4, with or without a unit: 90deg, 180deg/s,
///        900deg/s2, 300rpm
/// @throws std::invalid_argument for anything else, and for a fraction of a user unit; the message
///         has the text and an example.
[[nodiscard]] WrittenQuantity read_quantity(std::string_view text, Dimension dimension);

/// @return [UU], [UU/s] or [UU/s²] of the quantity, not rounded; nothing where the axis has no such
///         unit.
[[nodiscard]] std::optional<double> to_user_units(const WrittenQuantity& quantity,
                                                  const Unit& unit);

/// @return the units in which the axis takes a quantity, such as "mm/s, m/s, cm/s, um/s, UU/s".
[[nodiscard]] std::string list_of_units(Dimension dimension, const Unit& unit);

/// @return what follows the unit of a position: "", "/s" or "/s2".
[[nodiscard]] std::string_view unit_ending(Dimension dimension) noexcept;

/// @return what the object measures; nothing where it is no position, speed or ramp.
[[nodiscard]] std::optional<Dimension> dimension_of(ObjectRow row) noexcept;

}  // namespace vdrive
