// SPDX-License-Identifier: Apache-2.0
// The axes of deploy/axes: each is good, moves without ringing and settles in the time that
// docs/reference/presets.md says.
#include "configuration/presets.hpp"

#include "configuration/configuration_file.hpp"
#include "configuration/configuration_warnings.hpp"
#include "vdrive/axis_bank.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;
using namespace vdrive::literals;
using testing::HasSubstr;
using testing::IsEmpty;

struct Machine {
  const char* name;
  std::int64_t settling_ms;  // docs/reference/presets.md

  friend std::ostream& operator<<(std::ostream& out, const Machine& machine) {
    return out << machine.name;
  }
};

const std::vector<Machine> kMachines{
    {"ball-screw", 5},  {"conveyor", 5},       {"geared-elastic", 450}, {"linear-motor", 5},
    {"nema23-belt", 5}, {"pick-and-place", 5}, {"rotary-table", 5},     {"scara-joint", 350},
    {"vertical", 5},    {"winder", 5}};

std::filesystem::path file_of(const std::string& name) {
  return std::filesystem::path(VDRIVE_SOURCE_DIR) / "deploy" / "axes" / (name + ".yaml");
}

std::string refusal_of_preset(const std::string& name, std::size_t count) {
  try {
    static_cast<void>(preset_axes(name, count));
  } catch (const ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Presets, AreTheFilesOfDeploy) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(file_of("any").parent_path())) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().stem().string());
  }
  std::ranges::sort(files);
  EXPECT_EQ(preset_names(), files);
  std::vector<std::string> tested;
  for (const Machine& machine : kMachines) tested.emplace_back(machine.name);
  EXPECT_EQ(tested, files) << "each has a row here and in docs/reference/presets.md";
}

TEST(Presets, AreNumberedAndNamedAsDefaultAxes) {
  const std::vector<NamedAxis> axes = preset_axes("ball-screw", 3);
  ASSERT_EQ(axes.size(), 3U);
  EXPECT_EQ(axes[0].number, 1);
  EXPECT_EQ(axes[2].number, 3);
  EXPECT_EQ(axes[2].name, "axis3");
  // 4096 UU a turn of 10 mm.
  for (const NamedAxis& axis : axes) {
    EXPECT_EQ(axis.unit, (Unit{.kind = UnitKind::linear, .name = "mm", .size = 409.6}));
  }
}

TEST(Presets, AnUnknownNameListsThose) {
  const std::string refusal = refusal_of_preset("ball-skrew", 1);
  for (const Machine& machine : kMachines) EXPECT_THAT(refusal, HasSubstr(machine.name));
  EXPECT_THAT(refusal, HasSubstr("did you mean"));
  EXPECT_THAT(refusal_of_preset("", 1), HasSubstr("winder"));
  EXPECT_THAT(refusal_of_preset("winder", 0), HasSubstr("from 1 to"));
}

class Preset : public testing::TestWithParam<Machine> {};

TEST_P(Preset, HasLoopsAndLimitsThatNeedNoWarning) {
  const std::filesystem::path file = file_of(GetParam().name);
  EXPECT_THAT(start_warnings(load_configuration(file)), IsEmpty());
  EXPECT_THAT(loop_warnings(file), IsEmpty());
}

/// Windows about the target [UU]: a thousandth and a hundredth of a turn of the encoder.
constexpr std::int64_t kNear = 4;
constexpr std::int64_t kSwing = 41;

constexpr int kLongestMotion = 20'000;  // [ticks]
constexpr int kWatched = 2'000;         // [ticks] behind the end of the demand

void put_value(AxisBank& bank, ObjectRow row, std::int64_t value) {
  ASSERT_EQ(bank.write(0, row, value), AbortCode::none) << describe(row).variable_name;
}

std::int64_t get_value(const AxisBank& bank, ObjectRow row) {
  return bank.read(0, row).value;
}

/// An axis of a preset, enabled in profile position mode; a holding brake has opened.
AxisBank enabled_axis(const std::string& preset) {
  const std::vector<NamedAxis> axes = preset_axes(preset, 1);
  AxisBank bank(std::span(&axes.front().configuration, 1), 1ms);
  put_value(bank, "op_mode_cmd"_object, 1);
  put_value(bank, "ds402_controlword"_object, 0x000F);
  for (int tick = 0; tick < 100; ++tick) bank.step();
  return bank;
}

/// @return a target that is far enough for the speed of the axis: its ramps take v²/a.
std::int32_t far_target(const AxisBank& bank) {
  const std::int64_t speed = get_value(bank, "profile_velocity"_object);
  const std::int64_t ramp = get_value(bank, "profile_acc"_object);
  EXPECT_EQ(get_value(bank, "profile_dec"_object), ramp);
  return static_cast<std::int32_t>(speed * speed / ramp * 6 / 5);
}

void start_move(AxisBank& bank, std::int32_t target) {
  put_value(bank, "position_user_target_value"_object, target);
  put_value(bank, "ds402_controlword"_object, 0x000F);
  put_value(bank, "ds402_controlword"_object, 0x001F);
}

/// Moves to `target`. A home switch (5E21h) about it sees where the load is, which the encoder of
/// the motor does not. @return ticks behind the end of the demand after which the load has been
/// within `window` of the target for good.
std::int64_t ticks_beyond(AxisBank& bank, std::int32_t target, std::int64_t window) {
  constexpr unsigned kHomeSwitch = 1U << 2U;  // of 60FDh
  put_value(bank, "test_switch_home"_object, target - window);
  put_value(bank, "test_switch_home_length"_object, 2 * window);
  start_move(bank, target);
  const auto has_arrived = [&bank, target] {
    const AxisStatus& status = bank.status(0);
    return status.position_demand_value == target && status.velocity_demand_value == 0;
  };
  for (int tick = 0; tick < kLongestMotion && !has_arrived(); ++tick) bank.step();
  EXPECT_TRUE(has_arrived()) << "at " << bank.status(0).position_demand_value << " of " << target;
  std::int64_t last = 0;
  for (int tick = 1; tick <= kWatched; ++tick) {
    bank.step();
    if ((bank.status(0).digital_inputs & kHomeSwitch) == 0) last = tick;
  }
  EXPECT_EQ(bank.power_state(0), PowerState::operation_enabled) << "no fault on the way";
  return last;
}

TEST_P(Preset, MovesWithoutRingingAndSettlesInItsTime) {
  AxisBank bank = enabled_axis(GetParam().name);
  const std::int32_t far = far_target(bank);
  EXPECT_EQ(ticks_beyond(bank, far, kSwing), 0) << "the load swings";
  EXPECT_EQ(ticks_beyond(bank, 0, kSwing), 0) << "the load swings";
  const std::int64_t there = ticks_beyond(bank, far, kNear);
  const std::int64_t back = ticks_beyond(bank, 0, kNear);
  RecordProperty("settling_ms", std::to_string(std::max(there, back)));
  EXPECT_LE(there, GetParam().settling_ms) << "ms behind the end of the demand";
  EXPECT_LE(back, GetParam().settling_ms) << "ms behind the end of the demand";
}

TEST_P(Preset, ReachesItsSpeedAndStopsQuicklyFromItWithoutAFault) {
  AxisBank bank = enabled_axis(GetParam().name);
  start_move(bank, far_target(bank));
  const std::int64_t speed = get_value(bank, "profile_velocity"_object);
  for (int tick = 0; tick < kLongestMotion; ++tick) {
    bank.step();
    if (bank.status(0).velocity_demand_value == speed) break;
  }
  ASSERT_EQ(bank.status(0).velocity_demand_value, speed);
  EXPECT_GE(get_value(bank, "quick_stop_deceleration"_object),
            get_value(bank, "profile_dec"_object));
  put_value(bank, "ds402_controlword"_object, 0x0002);
  for (int tick = 0; tick < kWatched; ++tick) bank.step();
  EXPECT_EQ(bank.power_state(0), PowerState::switch_on_disabled);
  EXPECT_EQ(bank.status(0).fault_count, 0U);
}

INSTANTIATE_TEST_SUITE_P(Machines, Preset, testing::ValuesIn(kMachines), [](const auto& row) {
  std::string name = row.param.name;
  std::ranges::replace(name, '-', '_');
  return name;
});

}  // namespace
}  // namespace vdrive::service
