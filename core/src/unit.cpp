// SPDX-License-Identifier: Apache-2.0
#include "vdrive/unit.hpp"

#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <span>

namespace vdrive {
namespace {

constexpr std::string_view kUserUnit = "UU";
constexpr int kMostDecimals = 9;

struct Scale {
  std::string_view name;
  double size;  ///< in revolutions, or in metres
};

constexpr std::array kAngles{Scale{"deg", 1.0 / 360.0}, Scale{"rad", 0.5 * std::numbers::inv_pi},
                             Scale{"rev", 1.0}};
constexpr std::array kLengths{Scale{"mm", 1e-3}, Scale{"m", 1.0}, Scale{"cm", 1e-2},
                              Scale{"um", 1e-6}};

/// Names with a fixed meaning on every axis.
constexpr std::array<std::string_view, 2> kReserved{kUserUnit, "rpm"};

const Scale* scale_named(std::span<const Scale> scales, std::string_view name) {
  const auto found = std::ranges::find(scales, name, &Scale::name);
  return found == scales.end() ? nullptr : &*found;
}

/// @return the units that this one can be converted to; none for a length with another name.
std::span<const Scale> scales_of(const Unit& unit) {
  if (unit.kind == UnitKind::rotary) return kAngles;
  return scale_named(kLengths, unit.name) == nullptr ? std::span<const Scale>() : kLengths;
}

bool is_name_character(char c) {
  const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  return is_letter || c == '%' || static_cast<unsigned char>(c) >= 0x80;
}

/// @return the number of decimals that resolve a step of this size.
int decimals_of(double step) {
  int decimals = 0;
  while (step < 1.0 && decimals < kMostDecimals) {
    step *= 10.0;
    ++decimals;
  }
  return decimals;
}

}  // namespace

std::optional<std::string> check_unit_name(UnitKind kind, std::string_view name) {
  if (kind == UnitKind::rotary) {
    if (scale_named(kAngles, name) != nullptr) return std::nullopt;
    return "the unit of a rotary axis is deg, rad or rev";
  }
  if (name.empty() || name.size() > kMaxUnitNameLength) {
    return "the name of a unit must have 1 to " + std::to_string(kMaxUnitNameLength) + " bytes";
  }
  if (!is_utf8(name) || !std::ranges::all_of(name, is_name_character)) {
    return "the name of a unit may contain only letters and %, such as mm";
  }
  if (std::ranges::find(kReserved, name) != kReserved.end() ||
      scale_named(kAngles, name) != nullptr) {
    return "UU, deg, rad, rev and rpm cannot name the unit of a linear axis";
  }
  return std::nullopt;
}

bool is_usable(const Unit& unit) {
  return !check_unit_name(unit.kind, unit.name) && unit.size >= kSmallestUnit &&
         unit.size <= kLargestUnit;
}

std::vector<std::string> units_of(const Unit& unit) {
  std::vector<std::string> names{unit.name};
  for (const Scale& scale : scales_of(unit)) {
    if (scale.name != unit.name) names.emplace_back(scale.name);
  }
  return names;
}

std::optional<double> user_units_in(const Unit& unit, std::string_view name) {
  if (name == kUserUnit) return 1.0;
  if (unit.kind == UnitKind::linear && name == unit.name) return unit.size;
  const auto scales = scales_of(unit);
  const Scale* const wanted = scale_named(scales, name);
  if (wanted == nullptr) return std::nullopt;
  if (unit.kind == UnitKind::rotary) return unit.size * wanted->size;
  return unit.size * (wanted->size / scale_named(scales, unit.name)->size);
}

double to_user_units(double value, const Unit& unit) {
  return value * user_units_in(unit, unit.name).value_or(1.0);
}

double from_user_units(double user_units, const Unit& unit) {
  return user_units / user_units_in(unit, unit.name).value_or(1.0);
}

std::string position_text(std::int64_t user_units, const Unit& unit) {
  const double value = from_user_units(static_cast<double>(user_units), unit);
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals_of(from_user_units(1.0, unit)));
  return std::string(text.data(), end.ptr) + " " + unit.name;
}

}  // namespace vdrive
