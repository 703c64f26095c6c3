// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/random_cases.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace vdrive::test {

// What a random master tells an axis, whatever carries it: each draw suits the state and the mode
// that the axis shows, so that most commands have an effect.

/// A value for an object of an axis.
struct DrawnWrite {
  ObjectAddress object;
  std::int64_t value;
};

inline constexpr std::int64_t kUnitsPerTurn = 4'096;

/// @return a controlword: mostly towards Operation enabled; there set-points, halts and stops, too.
[[nodiscard]] inline std::uint16_t draw_controlword(const AxisStatus& status, Random& random) {
  constexpr std::array<std::uint16_t, 22> kWordsInOperation{
      0x000F, 0x000F, 0x000F, 0x000F, 0x000F, 0x000F, 0x000F, 0x001F, 0x001F, 0x001F, 0x001F,
      0x001F, 0x003F, 0x003F, 0x005F, 0x007F, 0x007F, 0x010F, 0x0002, 0x0006, 0x0007, 0x0000};
  switch (decode_power_state(status.ds402_statusword)) {
    case PowerState::fault:
      return random.per_mille(700) ? 0x0080 : 0x000F;
    case PowerState::switch_on_disabled:
      return random.per_mille(700) ? 0x000F : 0x0006;
    case PowerState::ready_to_switch_on:
      return random.per_mille(700) ? 0x000F : 0x0007;
    case PowerState::operation_enabled:
      return random.pick<std::uint16_t>(kWordsInOperation);
    default:
      return 0x000F;
  }
}

/// @return profile position most often, else any mode or none.
[[nodiscard]] inline std::int8_t draw_mode(Random& random) {
  const OperatingMode mode = random.per_mille(300)
                                 ? OperatingMode::profile_position
                                 : random.pick<OperatingModeRow>(kOperatingModes).mode;
  return static_cast<std::int8_t>(mode);
}

/// @return what the mode in force takes: targets anywhere, streamed ones near to the demand.
[[nodiscard]] inline DrawnWrite draw_set_point(const AxisStatus& status, Random& random) {
  const auto near_to = [&random](std::int32_t value, std::int64_t most) {
    return std::clamp<std::int64_t>(value + random.between(-most, most), INT32_MIN, INT32_MAX);
  };
  switch (static_cast<OperatingMode>(status.op_mode_actual)) {
    case OperatingMode::velocity:
      return {{0x6042, 0}, random.between(-2'200, 2'200)};
    case OperatingMode::profile_velocity:
      return {{0x60FF, 0}, random.between(-120'000, 120'000)};
    case OperatingMode::profile_torque:
    case OperatingMode::cyclic_synchronous_torque:
      return {{0x6071, 0}, random.between(-800, 800)};
    case OperatingMode::homing:
      return {{0x6098, 0}, random.pick<HomingMethodRow>(kHomingMethods).number};
    case OperatingMode::interpolated_position:
      return {{0x60C1, 1}, near_to(status.position_demand_value, 200)};
    case OperatingMode::cyclic_synchronous_position:
      return {{0x607A, 0}, near_to(status.position_demand_value, 200)};
    case OperatingMode::cyclic_synchronous_velocity:
      return {{0x60FF, 0}, near_to(status.velocity_demand_value, 10'000)};
    default:
      return {{0x607A, 0}, random.between(-20 * kUnitsPerTurn, 20 * kUnitsPerTurn)};
  }
}

/// @return what masters set beside their set-points: offsets, touch probes, 60C2h, the buffer of
///         records, ways round the range of a modulo axis.
[[nodiscard]] inline DrawnWrite draw_setting(Random& random) {
  struct Setting {
    ObjectAddress object;
    std::array<std::int64_t, 6> values;
  };

  static constexpr std::array kSettings{
      Setting{{0x60B0, 0}, {0, 0, 100, -100, 50, -50}},
      Setting{{0x60B1, 0}, {0, 0, 2'000, -2'000, 5'000, -5'000}},
      Setting{{0x60B2, 0}, {0, 0, 50, -50, 200, -200}},
      Setting{{0x60B8, 0}, {0, 0x0011, 0x0033, 0x0037, 0x3300, 0x373B}},
      Setting{{0x60C2, 1}, {0, 1, 2, 4, 10, 20}},
      Setting{{0x60C4, 2}, {1, 1, 1, 2, 4, 16}},
      Setting{{0x60C4, 6}, {0, 1, 1, 1, 1, 1}},
      Setting{{0x60D0, 1}, {1, 2, 3, 5, 1, 5}},
      Setting{{0x60F2, 0}, {0, 1, 2, 2 + 64, 2 + 128, 2 + 192}}};
  const Setting& setting = random.pick<Setting>(kSettings);
  return {setting.object, random.pick<std::int64_t>(setting.values)};
}

}  // namespace vdrive::test
