// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace vdrive {

/// The homing methods of 6098h that the drive has (CiA 402-2, homing mode).
struct HomingMethodRow {
  std::int8_t number = 0;
  std::int8_t direction = 0;  ///< of the first movement; 0 = none
  bool limit = false;         ///< home lies where the limit switch in that direction is left
  bool index = false;         ///< home is the next index pulse
  std::string_view what;      ///< where home is, in words
};

/// Every method, by rising number: what 6098h takes beside 0 (no method), and every help of it.
inline constexpr std::array kHomingMethods{
    HomingMethodRow{.number = 1,
                    .direction = -1,
                    .limit = true,
                    .index = true,
                    .what = "to the negative limit switch, then back to the index pulse"},
    HomingMethodRow{.number = 2,
                    .direction = +1,
                    .limit = true,
                    .index = true,
                    .what = "to the positive limit switch, then back to the index pulse"},
    HomingMethodRow{.number = 17,
                    .direction = -1,
                    .limit = true,
                    .what = "to the negative limit switch, then back to where it opens"},
    HomingMethodRow{.number = 18,
                    .direction = +1,
                    .limit = true,
                    .what = "to the positive limit switch, then back to where it opens"},
    HomingMethodRow{.number = 33,
                    .direction = -1,
                    .index = true,
                    .what = "to the index pulse in negative direction"},
    HomingMethodRow{.number = 34,
                    .direction = +1,
                    .index = true,
                    .what = "to the index pulse in positive direction"},
    HomingMethodRow{.number = 35, .what = "where the axis is"},
    HomingMethodRow{.number = 37, .what = "where the axis is"},
};

static_assert(std::ranges::is_sorted(kHomingMethods, {}, &HomingMethodRow::number));

/// @return the row of method `number`, or null: the drive does not have it, or it is 0.
[[nodiscard]] constexpr const HomingMethodRow* find_homing_method(std::int64_t number) noexcept {
  for (const HomingMethodRow& row : kHomingMethods) {
    if (row.number == number) return &row;
  }
  return nullptr;
}

/// @return whether 6098h takes `value`: 0 (no method) or a method of the table.
[[nodiscard]] constexpr bool is_homing_method(std::int64_t value) noexcept {
  return value == 0 || find_homing_method(value) != nullptr;
}

}  // namespace vdrive
