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
#include <cstdlib>
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
    {"ball-screw", 100},  {"conveyor", 250},       {"geared-elastic", 400}, {"linear-motor", 100},
    {"nema23-belt", 150}, {"pick-and-place", 100}, {"rotary-table", 150},   {"scara-joint", 400},
    {"vertical", 100},    {"winder", 400}};

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

/// What an axis does behind the end of its demand.
struct Settling {
  std::int64_t ticks = 0;  // until it stays near the target
  int swings = 0;          // from one side of the target to the other, out of reach of the window
};

/// A hundredth of a turn of the encoder [UU].
constexpr std::int64_t kNear = 41;

void put_value(AxisBank& bank, ObjectRow row, std::int64_t value) {
  ASSERT_EQ(bank.write(0, row, value), AbortCode::none) << describe(row).variable_name;
}

Settling move_axis(AxisBank& bank, std::int32_t target) {
  put_value(bank, "position_user_target_value"_object, target);
  put_value(bank, "ds402_controlword"_object, 0x000F);
  put_value(bank, "ds402_controlword"_object, 0x001F);
  for (int tick = 0; tick < 20'000; ++tick) {
    bank.step();
    if (bank.status(0).position_demand_value == target) break;
  }
  EXPECT_EQ(bank.status(0).position_demand_value, target) << "the demand arrives";
  Settling settling;
  int side = 0;
  for (std::int64_t tick = 1; tick <= 2'000; ++tick) {
    bank.step();
    const std::int64_t error = std::int64_t{bank.status(0).load_position_actual_value} - target;
    if (std::abs(error) <= kNear) continue;
    settling.ticks = tick;
    const int now = error > 0 ? 1 : -1;
    settling.swings += side == -now ? 1 : 0;
    side = now;
  }
  EXPECT_EQ(bank.power_state(0), PowerState::operation_enabled) << "no fault on the way";
  return settling;
}

TEST_P(Preset, MovesWithoutRingingAndSettlesInItsTime) {
  const std::vector<NamedAxis> axes = preset_axes(GetParam().name, 1);
  AxisBank bank(std::span(&axes.front().configuration, 1), 1ms);
  put_value(bank, "op_mode_cmd"_object, 1);
  put_value(bank, "ds402_controlword"_object, 0x000F);
  for (int tick = 0; tick < 100; ++tick) bank.step();  // a holding brake opens
  // Three turns of the encoder, forth and back.
  std::int64_t longest = 0;
  for (const std::int32_t target : {12'288, 0}) {
    const Settling settling = move_axis(bank, target);
    EXPECT_LE(settling.swings, 1) << "to " << target;
    longest = std::max(longest, settling.ticks);
  }
  RecordProperty("settling_ms", std::to_string(longest));
  EXPECT_LE(longest, GetParam().settling_ms) << "ms behind the end of the demand";
}

INSTANTIATE_TEST_SUITE_P(Machines, Preset, testing::ValuesIn(kMachines), [](const auto& row) {
  std::string name = row.param.name;
  std::ranges::replace(name, '-', '_');
  return name;
});

}  // namespace
}  // namespace vdrive::service
