// SPDX-License-Identifier: Apache-2.0
#include "support/programs/generator.hpp"

#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace vdrive::test {
namespace {

/// Draws limits that are in force in every mode, as objects of the axis.
void draw_limits(DrawnAxis& axis, Random& random) {
  AxisLimits& limits = axis.limits;
  limits.speed = random.per_mille(500) ? 136'533 : random.between(20'000, 136'000);
  const std::int64_t most = random.between(1'000, 3'000);
  const auto within = [&] {
    return random.per_mille(500) ? most : random.between(500, most);
  };
  limits.positive_torque = within();
  limits.negative_torque = within();
  limits.has_range = random.per_mille(500);
  limits.lower = -random.between(10'000, 60'000);
  limits.upper = random.between(10'000, 60'000);
  limits.abort_connection = static_cast<int>(random.per_mille(700) ? 1 : random.below(4));
}

void add_jerk(DrawnAxis& axis, Random& random) {
  constexpr std::array<std::int64_t, 4> kJerks{4'096'000, 4'096'000, 10'000'000, 50'000'000};
  const std::int64_t first = random.pick<std::int64_t>(kJerks);
  const std::int64_t second = random.pick<std::int64_t>(kJerks);
  const bool has_two = random.per_mille(500);
  axis.limits.jerk = static_cast<double>(has_two ? std::max(first, second) : first);
  axis.parameters.insert(axis.parameters.end(), {{{0x6086, 0}, 3},
                                                 {{0x60A3, 0}, has_two ? 2 : 1},
                                                 {{0x60A4, 1}, first},
                                                 {{0x60A4, 2}, second}});
}

/// Adds a modulo range that contains 0. Software limits are removed because they would hide its
/// ends.
void add_range(DrawnAxis& axis, Random& random) {
  axis.limits.has_range = false;
  axis.limits.range_span = random.between(1'000, 50'000);
  axis.limits.range_lower = -random.between(0, axis.limits.range_span - 1);
  axis.parameters.push_back({{0x607B, 1}, axis.limits.range_lower});
  axis.parameters.push_back({{0x607B, 2}, axis.limits.range_lower + axis.limits.range_span});
}

void add_switches(DrawnAxis& axis, Random& random) {
  axis.parameters.insert(axis.parameters.end(), {{{0x5E21, 1}, -random.between(15'000, 60'000)},
                                                 {{0x5E21, 2}, random.between(15'000, 60'000)},
                                                 {{0x5E21, 3}, random.between(-10'000, 10'000)},
                                                 {{0x5E21, 4}, random.between(50, 5'000)}});
}

void add_end_stops(DrawnAxis& axis, Random& random) {
  axis.model.lower_end_stop = static_cast<double>(-random.between(20'000, 80'000));
  axis.model.upper_end_stop = static_cast<double>(random.between(20'000, 80'000));
}

/// Adds effects of the plant. A weight always has a brake that holds it. Together the effects
/// accelerate the axis by less than kStrongest (model.cpp); ripple is left out because it would
/// exceed the torque limits.
void add_effects(DrawnAxis& axis, Random& random) {
  AxisModel& model = axis.model;
  if (random.per_mille(500)) {
    model.gravity_torque = random.per_mille(500) ? 0.3 : -0.3;
    model.brake_torque = 1.5;
    model.brake_release_time = 0.02;
    model.brake_engage_time = 0.03;
  }
  if (random.per_mille(500)) model.cogging_torque = 0.05;
  if (random.per_mille(500)) {
    model.encoder_noise = 0.1;
    model.load_encoder_noise = 0.1;
    model.encoder_noise_seed = static_cast<double>(random.below(1'000'000));
  }
  if (random.per_mille(500)) model.motor_thermal_time_constant = 10.0;
  axis.limits.is_pushed =
      model.gravity_torque != 0.0 || model.cogging_torque != 0.0 || model.encoder_noise != 0.0;
}

/// A habit that may be drawn. 5E20h:05 is left out, because its refusals depend on what the axis
/// does within a tick.
struct Habit {
  std::uint8_t subindex;
  std::int64_t highest;
  bool holds_back;  ///< delays commands by up to `highest` ms
};

constexpr std::array kDrawnHabits{
    Habit{0x01, 1, false}, Habit{0x02, 1, false}, Habit{0x03, 1, false}, Habit{0x04, 2, false},
    Habit{0x06, 8, true},  Habit{0x07, 60, true}, Habit{0x08, 30, true}, Habit{0x09, 30, true},
    Habit{0x0A, 1, false}, Habit{0x0B, 1, false}, Habit{0x0D, 1, false}, Habit{0x0E, 1, false}};

void add_habits(DrawnAxis& axis, Random& random) {
  constexpr double kMillisecond_s = 1.0e-3;
  constexpr double kWholeTicks_s = 0.01;  // more than rounding up to ticks of 2 ms adds
  axis.limits.jerk = 0.0;                 // not checked: 5E20h:0B plans from rest
  for (const Habit& habit : kDrawnHabits) {
    if (!random.per_mille(250)) continue;
    const std::int64_t value = random.between(1, habit.highest);
    axis.parameters.push_back({{0x5E20, habit.subindex}, value});
    if (!habit.holds_back) continue;
    axis.limits.delay += static_cast<double>(value) * kMillisecond_s + kWholeTicks_s;
  }
  if (random.per_mille(250)) {
    constexpr std::array<std::int64_t, 3> kMakerBits{0x0200, 0x4000, 0xC000};
    axis.limits.maker_bits = random.pick<std::int64_t>(kMakerBits);
    axis.parameters.push_back({{0x5E20, 0x0C}, axis.limits.maker_bits});
  }
}

void add_monitor(DrawnAxis& axis, Random& random) {
  axis.parameters.push_back({{0x5E12, 1}, random.between(0, 3)});
  axis.parameters.push_back({{0x5E12, 2}, random.per_mille(500) ? 0 : 200});
}

// Kinds drawn later may override those drawn earlier. To add a kind, add a row.
constexpr std::array kKinds{add_jerk,    add_range,  add_switches, add_end_stops,
                            add_effects, add_habits, add_monitor};

void add_limits(DrawnAxis& axis) {
  const AxisLimits& limits = axis.limits;
  axis.parameters.insert(axis.parameters.end(),
                         {{{0x607F, 0}, limits.speed},
                          {{0x6072, 0}, std::max(limits.positive_torque, limits.negative_torque)},
                          {{0x60E0, 0}, limits.positive_torque},
                          {{0x60E1, 0}, limits.negative_torque},
                          {{0x3535, 0}, limits.has_range ? 1 : 0},
                          {{0x607D, 1}, limits.lower},
                          {{0x607D, 2}, limits.upper},
                          {{0x6007, 0}, limits.abort_connection}});
}

}  // namespace

std::uint16_t draw_controlword(const AxisStatus& status, Random& random) {
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

std::int8_t draw_mode(Random& random) {
  const OperatingMode mode = random.per_mille(300)
                                 ? OperatingMode::profile_position
                                 : random.pick<OperatingModeRow>(kOperatingModes).mode;
  return static_cast<std::int8_t>(mode);
}

Write draw_set_point(const AxisStatus& status, Random& random) {
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

Write draw_setting(Random& random) {
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

Write draw_write(const AxisStatus& status, Random& random) {
  switch (random.below(10)) {
    case 0:
      return {{0x6060, 0}, draw_mode(random)};
    case 1:
    case 2:
    case 3:
      return draw_set_point(status, random);
    case 4:
      return draw_setting(random);
    default:
      return {{0x6040, 0}, draw_controlword(status, random)};
  }
}

Write draw_disturbance(Random& random) {
  constexpr std::int64_t kStrongestLoad = 2'500;  // [mN.m]
  const auto index = static_cast<std::uint16_t>(0x5E00 + random.below(11));
  return {{index, 0}, index == 0x5E00 ? random.between(-kStrongestLoad, kStrongestLoad) : 1};
}

Intent draw_intent(std::span<const Intent::Kind> kinds, std::int32_t reach, Random& random) {
  constexpr std::int32_t kHere = 37;  // homing method
  const auto around = [&random](std::int32_t most) {
    return static_cast<std::int32_t>(random.between(-most, most));
  };
  const Intent::Kind kind = random.pick(kinds);
  switch (kind) {
    case Intent::Kind::home:
      return {kind, kHere};
    case Intent::Kind::move_to:
      return {kind, around(reach)};
    case Intent::Kind::move_by:
      return {kind, around(100)};
    case Intent::Kind::run_at:
      return {kind, random.one_in(3) ? 0 : around(3'000)};
    case Intent::Kind::apply_torque:
      return {kind, around(50)};
    default:
      return {kind};
  }
}

Intent draw_intent(const AxisStatus& status, std::span<const Intent::Kind> kinds,
                   std::int32_t reach, Random& random) {
  const PowerState state = decode_power_state(status.ds402_statusword);
  if (state != PowerState::operation_enabled && random.one_in(2)) {
    return {is_fault(state) ? Intent::Kind::reset_fault : Intent::Kind::enable};
  }
  return draw_intent(kinds, reach, random);
}

std::vector<DrawnAxis> draw_axes(std::size_t count, bool kinds, Random& random) {
  std::array<bool, kKinds.size()> has_kind{};
  for (bool& has : has_kind) has = kinds && random.per_mille(500);
  std::vector<DrawnAxis> axes(count);
  for (DrawnAxis& axis : axes) {
    draw_limits(axis, random);
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      if (has_kind.at(kind) && random.per_mille(400)) kKinds.at(kind)(axis, random);
    }
    add_limits(axis);
  }
  return axes;
}

}  // namespace vdrive::test
