// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive {

/// A method of homing, a value of 6098h (CiA 402-2, homing methods).
struct HomingMethod {
  std::int8_t number = 0;
  std::int8_t direction = 0;  ///< of the first movement: -1, +1, or 0 = none
  bool limit_switch = false;  ///< home lies where the limit switch in that direction is left
  bool index_pulse = false;   ///< home is the next index pulse
};

/// Every method that the drive has, by rising number. 6098h also takes 0: no method is chosen.
inline constexpr std::array kHomingMethods{
    HomingMethod{.number = 1, .direction = -1, .limit_switch = true, .index_pulse = true},
    HomingMethod{.number = 2, .direction = +1, .limit_switch = true, .index_pulse = true},
    HomingMethod{.number = 17, .direction = -1, .limit_switch = true},
    HomingMethod{.number = 18, .direction = +1, .limit_switch = true},
    HomingMethod{.number = 33, .direction = -1, .index_pulse = true},
    HomingMethod{.number = 34, .direction = +1, .index_pulse = true},
    HomingMethod{.number = 35},
    HomingMethod{.number = 37},
};

}  // namespace vdrive
