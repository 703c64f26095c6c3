// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace vdrive {

/// Where the first movement of a homing run ends.
enum class HomingMark : std::uint8_t {
  none,          ///< none: home is the next index pulse or the present position
  limit_switch,  ///< the limit switch in that direction (bits 0 and 1 of 60FDh)
  home_switch,   ///< the home switch (bit 2 of 60FDh)
  hard_stop,     ///< the mechanical stop in that direction, detected by the torque (5E18h)
};

/// A homing method of 6098h: the methods of CiA 402-2, and negative numbers as many drives use them
/// for homing on a mechanical stop.
struct HomingMethodRow {
  std::int8_t number = 0;
  std::int8_t direction = 0;  ///< of the first movement while no switch is active; 0 = none
  std::int8_t approach = 0;   ///< direction of travel when home is reached; 0 = none
  HomingMark mark = HomingMark::none;
  bool onto = false;      ///< home is where the home switch closes; false: where it opens
  bool turns = false;     ///< a limit switch in `direction` reverses the search
  bool index = false;     ///< home is the next index pulse
  std::string_view what;  ///< where home is, as text
};

/// Every method, in ascending order. 6098h accepts these and 0 (no method), and help texts list
/// them. CiA 402-2 reserves 15, 16, 31 and 32; it has no method 36.
// clang-format off
inline constexpr std::array kHomingMethods{
    HomingMethodRow{.number = -4, .direction = +1, .approach = +1, .mark = HomingMark::hard_stop,
                    .what = "at the mechanical stop in positive direction"},
    HomingMethodRow{.number = -3, .direction = -1, .approach = -1, .mark = HomingMark::hard_stop,
                    .what = "at the mechanical stop in negative direction"},
    HomingMethodRow{.number = -2, .direction = +1, .approach = -1, .mark = HomingMark::hard_stop, .index = true,
                    .what = "to the mechanical stop in positive direction, then back to the index pulse"},
    HomingMethodRow{.number = -1, .direction = -1, .approach = +1, .mark = HomingMark::hard_stop, .index = true,
                    .what = "to the mechanical stop in negative direction, then back to the index pulse"},
    HomingMethodRow{.number = 1, .direction = -1, .approach = +1, .mark = HomingMark::limit_switch, .index = true,
                    .what = "to the negative limit switch, then back to the index pulse"},
    HomingMethodRow{.number = 2, .direction = +1, .approach = -1, .mark = HomingMark::limit_switch, .index = true,
                    .what = "to the positive limit switch, then back to the index pulse"},
    HomingMethodRow{.number = 3, .direction = +1, .approach = -1, .mark = HomingMark::home_switch, .index = true,
                    .what = "home switch up to the positive end: off it, then on to the index pulse"},
    HomingMethodRow{.number = 4, .direction = +1, .approach = +1, .mark = HomingMark::home_switch, .onto = true, .index = true,
                    .what = "home switch up to the positive end: onto it, then on to the index pulse"},
    HomingMethodRow{.number = 5, .direction = -1, .approach = +1, .mark = HomingMark::home_switch, .index = true,
                    .what = "home switch up to the negative end: off it, then on to the index pulse"},
    HomingMethodRow{.number = 6, .direction = -1, .approach = -1, .mark = HomingMark::home_switch, .onto = true, .index = true,
                    .what = "home switch up to the negative end: onto it, then on to the index pulse"},
    HomingMethodRow{.number = 7, .direction = +1, .approach = -1, .mark = HomingMark::home_switch, .turns = true, .index = true,
                    .what = "home switch, first in positive direction: off its negative edge, then on to the index pulse"},
    HomingMethodRow{.number = 8, .direction = +1, .approach = +1, .mark = HomingMark::home_switch, .onto = true, .turns = true, .index = true,
                    .what = "home switch, first in positive direction: onto its negative edge, then on to the index pulse"},
    HomingMethodRow{.number = 9, .direction = +1, .approach = -1, .mark = HomingMark::home_switch, .onto = true, .turns = true, .index = true,
                    .what = "home switch, first in positive direction: onto its positive edge, then on to the index pulse"},
    HomingMethodRow{.number = 10, .direction = +1, .approach = +1, .mark = HomingMark::home_switch, .turns = true, .index = true,
                    .what = "home switch, first in positive direction: off its positive edge, then on to the index pulse"},
    HomingMethodRow{.number = 11, .direction = -1, .approach = +1, .mark = HomingMark::home_switch, .turns = true, .index = true,
                    .what = "home switch, first in negative direction: off its positive edge, then on to the index pulse"},
    HomingMethodRow{.number = 12, .direction = -1, .approach = -1, .mark = HomingMark::home_switch, .onto = true, .turns = true, .index = true,
                    .what = "home switch, first in negative direction: onto its positive edge, then on to the index pulse"},
    HomingMethodRow{.number = 13, .direction = -1, .approach = +1, .mark = HomingMark::home_switch, .onto = true, .turns = true, .index = true,
                    .what = "home switch, first in negative direction: onto its negative edge, then on to the index pulse"},
    HomingMethodRow{.number = 14, .direction = -1, .approach = -1, .mark = HomingMark::home_switch, .turns = true, .index = true,
                    .what = "home switch, first in negative direction: off its negative edge, then on to the index pulse"},
    HomingMethodRow{.number = 17, .direction = -1, .approach = +1, .mark = HomingMark::limit_switch,
                    .what = "to the negative limit switch, then back to where it opens"},
    HomingMethodRow{.number = 18, .direction = +1, .approach = -1, .mark = HomingMark::limit_switch,
                    .what = "to the positive limit switch, then back to where it opens"},
    HomingMethodRow{.number = 19, .direction = +1, .approach = -1, .mark = HomingMark::home_switch,
                    .what = "home switch up to the positive end: off it"},
    HomingMethodRow{.number = 20, .direction = +1, .approach = +1, .mark = HomingMark::home_switch, .onto = true,
                    .what = "home switch up to the positive end: onto it"},
    HomingMethodRow{.number = 21, .direction = -1, .approach = +1, .mark = HomingMark::home_switch,
                    .what = "home switch up to the negative end: off it"},
    HomingMethodRow{.number = 22, .direction = -1, .approach = -1, .mark = HomingMark::home_switch, .onto = true,
                    .what = "home switch up to the negative end: onto it"},
    HomingMethodRow{.number = 23, .direction = +1, .approach = -1, .mark = HomingMark::home_switch, .turns = true,
                    .what = "home switch, first in positive direction: off its negative edge"},
    HomingMethodRow{.number = 24, .direction = +1, .approach = +1, .mark = HomingMark::home_switch, .onto = true, .turns = true,
                    .what = "home switch, first in positive direction: onto its negative edge"},
    HomingMethodRow{.number = 25, .direction = +1, .approach = -1, .mark = HomingMark::home_switch, .onto = true, .turns = true,
                    .what = "home switch, first in positive direction: onto its positive edge"},
    HomingMethodRow{.number = 26, .direction = +1, .approach = +1, .mark = HomingMark::home_switch, .turns = true,
                    .what = "home switch, first in positive direction: off its positive edge"},
    HomingMethodRow{.number = 27, .direction = -1, .approach = +1, .mark = HomingMark::home_switch, .turns = true,
                    .what = "home switch, first in negative direction: off its positive edge"},
    HomingMethodRow{.number = 28, .direction = -1, .approach = -1, .mark = HomingMark::home_switch, .onto = true, .turns = true,
                    .what = "home switch, first in negative direction: onto its positive edge"},
    HomingMethodRow{.number = 29, .direction = -1, .approach = +1, .mark = HomingMark::home_switch, .onto = true, .turns = true,
                    .what = "home switch, first in negative direction: onto its negative edge"},
    HomingMethodRow{.number = 30, .direction = -1, .approach = -1, .mark = HomingMark::home_switch, .turns = true,
                    .what = "home switch, first in negative direction: off its negative edge"},
    HomingMethodRow{.number = 33, .direction = -1, .approach = -1, .index = true,
                    .what = "to the index pulse in negative direction"},
    HomingMethodRow{.number = 34, .direction = +1, .approach = +1, .index = true,
                    .what = "to the index pulse in positive direction"},
    HomingMethodRow{.number = 35, .what = "where the axis is"},
    HomingMethodRow{.number = 37, .what = "where the axis is"},
};
// clang-format on

static_assert(std::ranges::is_sorted(kHomingMethods, {}, &HomingMethodRow::number));

/// @return the row of method `number`, or null for 0 and for a method that the drive does not have.
[[nodiscard]] constexpr const HomingMethodRow* find_homing_method(std::int64_t number) noexcept {
  for (const HomingMethodRow& row : kHomingMethods) {
    if (row.number == number) return &row;
  }
  return nullptr;
}

/// @return whether 6098h accepts `value`: 0 (no method) or a method of the table.
[[nodiscard]] constexpr bool is_homing_method(std::int64_t value) noexcept {
  return value == 0 || find_homing_method(value) != nullptr;
}

}  // namespace vdrive
