// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/plant/axis_model.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// Physical meaning of the user units (UU) of an axis: parts of a revolution or of a length. The
/// drive knows only UU; programs convert.

/// Kind of a unit, with the units to which it can be converted.
enum class UnitKind : std::uint8_t {
  rotary,  ///< deg, rad and rev
  linear,  ///< m, cm, mm and um if it is one of these; otherwise only itself
};

inline constexpr std::size_t kMaxUnitNameLength = 16;  // [bytes]
inline constexpr double kSmallestUnit = 1e-6;          // [UU]
inline constexpr double kLargestUnit = 1e9;            // [UU]

/// The unit of an axis. The default is that of the default axis.
struct Unit {
  UnitKind kind = UnitKind::rotary;
  std::string name = "deg";               ///< in which positions are shown; rotary: deg, rad, rev
  double size = kUserUnitsPerRevolution;  ///< [UU] per revolution; linear: per `name`

  friend bool operator==(const Unit&, const Unit&) = default;
};

/// @return "rotary" or "linear".
[[nodiscard]] constexpr std::string_view to_string(UnitKind kind) noexcept {
  return kind == UnitKind::rotary ? "rotary" : "linear";
}

/// @return what is wrong with the name of a unit of that kind, or nothing for a valid one. The name
///         of a length has 1 to kMaxUnitNameLength bytes of UTF-8, in which ASCII characters are
///         letters or %, and is not UU, deg, rad, rev or rpm.
[[nodiscard]] std::optional<std::string> check_unit_name(UnitKind kind, std::string_view name);

/// @return whether name and size are within their limits, to check units sent by another program.
[[nodiscard]] bool is_usable(const Unit& unit);

/// @return the names of the units in which a position of this axis can be given, such as {"deg",
///         "rad", "rev"}, with its own name first.
[[nodiscard]] std::vector<std::string> units_of(const Unit& unit);

/// @return [UU] per `name`, nothing if the axis has no such unit (see units_of). Every axis has
///         "UU".
[[nodiscard]] std::optional<double> user_units_in(const Unit& unit, std::string_view name);

/// @param value a position [unit.name], a speed [unit.name/s] or an acceleration [unit.name/s²]
/// @return the same in UU, UU/s or UU/s², not rounded.
[[nodiscard]] double to_user_units(double value, const Unit& unit);

/// @param user_units a position [UU], a speed [UU/s] or an acceleration [UU/s²]
/// @return the same in unit.name, unit.name/s or unit.name/s².
[[nodiscard]] double from_user_units(double user_units, const Unit& unit);

/// @return a position for display, such as "90.00 deg", with enough digits to resolve 1 UU.
[[nodiscard]] std::string position_text(std::int64_t user_units, const Unit& unit);

}  // namespace vdrive
