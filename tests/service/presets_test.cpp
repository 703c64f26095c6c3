// SPDX-License-Identifier: Apache-2.0
// The axes of deploy/axes: each is valid, has the units, speeds and ramps of
// docs/reference/presets.md, moves without ringing and settles within 5 ms.
#include "configuration/presets.hpp"

#include "configuration/configuration_file.hpp"
#include "configuration/configuration_warnings.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/quantity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;
using namespace vdrive::literals;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;

/// A row of docs/reference/presets.md.
struct Machine {
  const char* name;
  UnitKind kind;
  const char* unit;
  double gear;        ///< turns of the motor per turn of the load
  const char* turn;   ///< travel per turn of the load
  const char* speed;  ///< 6081h
  const char* ramp;   ///< 6083h and 6084h
  std::int64_t settling_ms;
  std::int64_t jerk_time_ms = 0;  ///< of each ramp; 0 = the jerk has no limit

  friend std::ostream& operator<<(std::ostream& out, const Machine& machine) {
    return out << machine.name;
  }
};

constexpr UnitKind kLinear = UnitKind::linear;
constexpr UnitKind kRotary = UnitKind::rotary;

// A belt on a drum of 80 mm moves by 80 mm x pi = 251.3 mm a turn, one on 20 mm by 62.83 mm. A
// toothed belt moves by 20 teeth of 2 mm a turn.
const std::vector<Machine> kMachines{
    {"ball-screw", kLinear, "mm", 1, "10 mm", "400 mm/s", "4 m/s2", 5},
    {"conveyor", kLinear, "mm", 10, "251.3 mm", "500 mm/s", "1 m/s2", 5},
    {"geared-elastic", kRotary, "deg", 50, "360 deg", "270 deg/s", "1000 deg/s2", 5, 50},
    {"linear-motor", kLinear, "mm", 1, "24 mm", "2 m/s", "20 m/s2", 5},
    {"nema23-belt", kLinear, "mm", 1, "40 mm", "500 mm/s", "4 m/s2", 5},
    {"pick-and-place", kLinear, "mm", 1, "62.83 mm", "2 m/s", "20 m/s2", 5},
    {"rotary-table", kRotary, "deg", 36, "360 deg", "300 deg/s", "720 deg/s2", 5},
    {"scara-joint", kRotary, "deg", 80, "360 deg", "180 deg/s", "900 deg/s2", 5, 56},
    {"vertical", kLinear, "mm", 1, "5 mm", "200 mm/s", "2 m/s2", 5},
    {"winder", kRotary, "rev", 20, "1 rev", "1 rev/s", "0.5 rev/s2", 5},
};

std::filesystem::path file_of(const std::string& name) {
  return std::filesystem::path(VDRIVE_SOURCE_DIR) / "deploy" / "axes" / (name + ".yaml");
}

/// @return the line about the preset in docs/reference/presets.md; empty = none.
std::string row_of_document(const std::string& name) {
  std::ifstream document(std::filesystem::path(VDRIVE_SOURCE_DIR) / "docs/reference/presets.md");
  const std::string begin = "| `" + name + "` |";
  for (std::string line; std::getline(document, line);) {
    if (line.starts_with(begin)) return line;
  }
  return "";
}

/// @return the value in [UU], [UU/s] or [UU/s²]; 0 if the axis has no unit of this dimension.
double in_user_units(std::string text, Dimension dimension, const Unit& unit) {
  std::erase(text, ' ');
  return to_user_units(read_quantity(text, dimension), unit).value_or(0.0);
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
  // 4096 UU are a turn of 10 mm.
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

/// Windows around the target [UU]: a thousandth and a hundredth of an encoder turn.
constexpr std::int64_t kNear = 4;
constexpr std::int64_t kSwing = 41;

constexpr int kLongestMotion = 20'000;  // [ticks]
constexpr int kWatched = 2'000;         // [ticks] after the end of the demand

void put_value(AxisBank& bank, ObjectRow row, std::int64_t value) {
  ASSERT_EQ(bank.write(0, row, value), AbortCode::none) << describe(row).variable_name;
}

std::int64_t get_value(const AxisBank& bank, ObjectRow row) {
  return bank.read(0, row).value;
}

/// An axis of the preset, enabled in profile position mode, with its holding brake open.
AxisBank enabled_axis(const std::string& preset) {
  const std::vector<NamedAxis> axes = preset_axes(preset, 1);
  AxisBank bank(std::span(&axes.front().configuration, 1), 1ms);
  put_value(bank, "op_mode_cmd"_object, 1);
  put_value(bank, "ds402_controlword"_object, 0x000F);
  for (int tick = 0; tick < 100; ++tick) bank.step();
  return bank;
}

/// @return the time in which a ramp's acceleration builds up [ms]; 0 = jerk is not limited.
double jerk_time(const AxisBank& bank) {
  if (get_value(bank, "motion_profile_type"_object) != 3) return 0.0;
  const auto ramp = static_cast<double>(get_value(bank, "profile_acc"_object));
  return 1'000.0 * ramp / static_cast<double>(get_value(bank, "profile_jerk_1"_object));
}

/// @return a target far enough for the axis to reach its speed: each ramp takes v/a plus the jerk
///         time, at v/2 on average.
std::int32_t far_target(const AxisBank& bank) {
  constexpr double kMore = 1.2;
  const auto speed = static_cast<double>(get_value(bank, "profile_velocity"_object));
  const auto ramp = static_cast<double>(get_value(bank, "profile_acc"_object));
  EXPECT_EQ(get_value(bank, "profile_dec"_object), get_value(bank, "profile_acc"_object));
  return static_cast<std::int32_t>(kMore * speed * (speed / ramp + 1.0e-3 * jerk_time(bank)));
}

void start_move(AxisBank& bank, std::int32_t target) {
  put_value(bank, "position_user_target_value"_object, target);
  put_value(bank, "ds402_controlword"_object, 0x000F);
  put_value(bank, "ds402_controlword"_object, 0x001F);
}

/// How the load comes to rest after the end of the demand.
struct SearchCompletion {
  std::int64_t ticks = 0;   ///< until it stays within the window
  std::int64_t swings = 0;  ///< times that it left the window
};

/// Moves to `target`. A home switch (5E21h) around the target detects where the load is, which the
/// motor's encoder does not.
SearchCompletion settle_at(AxisBank& bank, std::int32_t target, std::int64_t window) {
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
  SearchCompletion settling;
  bool was_outside = false;
  for (int tick = 1; tick <= kWatched; ++tick) {
    bank.step();
    const bool outside = (bank.status(0).digital_inputs & kHomeSwitch) == 0;
    if (outside) settling.ticks = tick;
    if (outside && !was_outside) ++settling.swings;
    was_outside = outside;
  }
  EXPECT_EQ(bank.power_state(0), PowerState::operation_enabled) << "no fault on the way";
  return settling;
}

TEST_P(Preset, HasTheUnitsOfItsMachineAndItsSpeeds) {
  const Machine& machine = GetParam();
  const NamedAxis axis = preset_axes(machine.name, 1).front();
  const AxisBank bank(std::span(&axis.configuration, 1), 1ms);
  EXPECT_EQ(axis.unit.kind, machine.kind);
  EXPECT_EQ(axis.unit.name, machine.unit);
  // All have one encoder, on the motor. The lengths of a turn in the table have four digits.
  const double turn = kUserUnitsPerRevolution * machine.gear;
  EXPECT_NEAR(in_user_units(machine.turn, Dimension::position, axis.unit), turn, 2.0e-4 * turn);
  const auto speed = static_cast<double>(get_value(bank, "profile_velocity"_object));
  EXPECT_NEAR(in_user_units(machine.speed, Dimension::velocity, axis.unit), speed, 1.0);
  const auto ramp = static_cast<double>(get_value(bank, "profile_acc"_object));
  EXPECT_NEAR(in_user_units(machine.ramp, Dimension::acceleration, axis.unit), ramp, 1.0);
  EXPECT_NEAR(jerk_time(bank), static_cast<double>(machine.jerk_time_ms), 0.5);
}

TEST_P(Preset, HasItsRowInTheDocument) {
  const Machine& machine = GetParam();
  std::string cells =
      std::string("| ") + machine.turn + " | " + machine.speed + ", " + machine.ramp;
  if (machine.jerk_time_ms != 0) {
    cells += ", jerk time " + std::to_string(machine.jerk_time_ms) + " ms";
  }
  cells += " |";
  EXPECT_THAT(row_of_document(machine.name), EndsWith(cells));
}

// A load that rings leaves the window again and again, on both sides. One that does not may
// approach from one side and swing once to the other.
constexpr std::int64_t kMostSwings = 2;

TEST_P(Preset, MovesWithoutRingingAndSettlesInItsTime) {
  AxisBank bank = enabled_axis(GetParam().name);
  const std::int32_t far = far_target(bank);
  EXPECT_EQ(settle_at(bank, far, kSwing).ticks, 0) << "the load swings";
  EXPECT_EQ(settle_at(bank, 0, kSwing).ticks, 0) << "the load swings";
  const SearchCompletion there = settle_at(bank, far, kNear);
  const SearchCompletion back = settle_at(bank, 0, kNear);
  RecordProperty("settling_ms", std::to_string(std::max(there.ticks, back.ticks)));
  EXPECT_LE(there.ticks, GetParam().settling_ms) << "ms behind the end of the demand";
  EXPECT_LE(back.ticks, GetParam().settling_ms) << "ms behind the end of the demand";
  EXPECT_LE(there.swings, kMostSwings) << "the load rings";
  EXPECT_LE(back.swings, kMostSwings) << "the load rings";
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
