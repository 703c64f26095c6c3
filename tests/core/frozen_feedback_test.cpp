// SPDX-License-Identifier: Apache-2.0
// 5E0Ch: the shown feedback stays as it is, while the axis goes on with the true feedback.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

constexpr ObjectAddress kFrozenFeedback{0x5E0C, 0};

/// Members that show feedback, or a difference from it.
constexpr std::array<std::string_view, 8> kFeedback{
    "load_position_actual_value",  "load_position_error_value",  "motor_position_actual_value",
    "motor_position_error_value",  "load_velocity_actual_value", "load_velocity_error_value",
    "motor_velocity_actual_value", "motor_velocity_error_value"};

/// On a long move at 10000 UU/s, with a following error window of 2000 UU.
void run_in_window(AxisUnderTest& axis) {
  axis.write("following_error_window", 2'000);
  axis.write("following_error_time_out", 0);
  axis.write("profile_velocity", 10'000);
  axis.write("profile_acc", 100'000);
  axis.enable();
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x001F);
  axis.step(500);
  ASSERT_EQ(axis.demand_velocity(), 10'000);
}

/// 6064h, 3572h, 606Ch, 3574h and 6044h.
std::array<std::int64_t, 5> readings_of(const AxisUnderTest& axis) {
  return {axis.actual(), axis.read("motor_position_actual_value"), axis.velocity(),
          axis.read("motor_velocity_actual_value"), axis.read("vl_velocity_actual_value")};
}

TEST(FrozenFeedback, KeepsThePositionsAndShowsStandstill) {
  AxisUnderTest axis;
  run_in_window(axis);
  const auto before = readings_of(axis);
  ASSERT_NE(before.back(), 0);
  axis.write("test_frozen_feedback", 1);
  for (int tick = 0; tick < 1'000; ++tick) {
    axis.step();
    ASSERT_EQ(readings_of(axis), (std::array<std::int64_t, 5>{before[0], before[1], 0, 0, 0}))
        << tick;
  }
}

TEST(FrozenFeedback, ShowsTheDifferencesToWhatIsShown) {
  AxisUnderTest axis;
  run_in_window(axis);
  axis.write("test_frozen_feedback", 1);
  axis.step(1'000);
  // 10000 UU/s for 1 s, plus the following error at the time of the freeze, which is below 100 UU.
  EXPECT_NEAR(axis.demand() - axis.actual(), 10'000, 100);
  EXPECT_EQ(axis.read("load_position_error_value"), axis.demand() - axis.actual());
  EXPECT_EQ(axis.read("motor_position_error_value"),
            axis.demand() - axis.read("motor_position_actual_value"));
  EXPECT_EQ(axis.read("load_velocity_error_value"), 10'000) << "606Bh less 0";
  EXPECT_EQ(axis.read("motor_velocity_error_value"), 10'000);
}

// The shown error is five times 6065h; the monitoring uses the true feedback.
TEST(FrozenFeedback, IsNoFollowingErrorAndShowsTheTruthAfterwards) {
  AxisUnderTest axis;
  run_in_window(axis);
  axis.write("test_frozen_feedback", 1);
  axis.step(1'000);
  ASSERT_GT(axis.read("load_position_error_value"), 4 * 2'000);
  EXPECT_EQ(axis.statusword() & Statusword::kFollowingError, 0);
  EXPECT_EQ(axis.state(), operation_enabled);
  axis.write("test_frozen_feedback", 0);
  axis.step();
  EXPECT_NEAR(axis.actual(), axis.demand(), 100);
  EXPECT_NEAR(axis.velocity(), 10'000, 100);
}

/// Two axes of a bank that get the same writes.
class Twins {
 public:
  Twins() : bank_(std::vector<AxisConfiguration>(2), std::chrono::milliseconds{1}) {}

  void write(std::string_view name, std::int64_t value) {
    for (const std::size_t axis : {0U, 1U}) {
      EXPECT_EQ(bank_.write(axis, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
    }
  }

  void freeze_second(bool frozen) { bank_.write(1, kFrozenFeedback, frozen ? 1 : 0); }

  /// After each tick compares everything, or while `frozen` everything except the feedback.
  void step(int ticks, bool frozen) {
    for (int tick = 0; tick < ticks; ++tick) {
      bank_.step();
      for (const StatusMember& member : status_members()) {
        const bool is_feedback = std::ranges::find(kFeedback, member.name) != kFeedback.end();
        if (frozen && is_feedback) continue;
        ASSERT_EQ(member.value(bank_.status(1)), member.value(bank_.status(0)))
            << member.name << " in tick " << tick;
      }
    }
  }

 private:
  AxisBank bank_;
};

/// A move, its end, a push, a stop, and rest without power.
void run_program(Twins& twins, bool frozen) {
  for (const auto& [name, value, ticks] :
       {std::tuple{"op_mode_cmd", 1, 1}, std::tuple{"ds402_controlword", 0x0F, 1},
        std::tuple{"position_user_target_value", 20'000, 1},
        std::tuple{"ds402_controlword", 0x1F, 2'000}, std::tuple{"test_load_torque", 1'000, 200},
        std::tuple{"test_load_torque", 0, 500}, std::tuple{"position_user_target_value", 0, 1},
        std::tuple{"ds402_controlword", 0x0F, 1}, std::tuple{"ds402_controlword", 0x1F, 100},
        std::tuple{"ds402_controlword", 0x02, 500}, std::tuple{"ds402_controlword", 0x00, 500}}) {
    SCOPED_TRACE(std::string(name) + " = " + std::to_string(value));
    twins.write(name, value);
    twins.step(ticks, frozen);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(FrozenFeedback, ChangesNothingButWhatIsShown) {
  Twins twins;
  twins.freeze_second(true);
  ASSERT_NO_FATAL_FAILURE(run_program(twins, true));
  twins.freeze_second(false);
  ASSERT_NO_FATAL_FAILURE(twins.step(1, false)) << "the truth is back with the next tick";
  ASSERT_NO_FATAL_FAILURE(run_program(twins, false));
}

// The demand moves from 4000 across the end of the range, 4095, to 500. The shorter distance
// between the two, 596, crosses that end, too.
TEST(FrozenFeedback, ShowsTheErrorOfAModuloAxisByTheShorterWay) {
  AxisConfiguration table;
  table.initial_position = 4'000;
  table.parameters = {{AxisUnderTest::address_of("min_position_range_limit"), 0},
                      {AxisUnderTest::address_of("max_position_range_limit"), 4'096}};
  AxisUnderTest axis(table);
  axis.enable();
  axis.write("test_frozen_feedback", 1);
  axis.write("position_user_target_value", 500);
  axis.write("positioning_option_code", 2 + 128);  // in positive direction
  axis.command(0x001F);
  ASSERT_NE(axis.step_until_reached(5'000), 0U);
  EXPECT_EQ(axis.demand(), 500);
  EXPECT_EQ(axis.actual(), 4'000);
  EXPECT_EQ(axis.read("load_position_error_value"), 96 + 500);
}

TEST(FrozenFeedback, OfTheConfigurationBeginsAtTheInitialPositionAndOutlastsAPowerCycle) {
  AxisConfiguration configuration;
  configuration.initial_position = 1'000;
  configuration.parameters = {{kFrozenFeedback, 1}};
  AxisUnderTest axis(configuration);
  EXPECT_EQ(axis.actual(), 1'000);
  axis.write("test_load_torque", 1'000);
  axis.step(500);
  EXPECT_EQ(axis.actual(), 1'000) << "pushed without power";
  axis.axis().power_cycle();
  axis.step(10);
  EXPECT_EQ(axis.actual(), 1'000);
  EXPECT_EQ(axis.read("test_frozen_feedback"), 1);
  axis.write("test_frozen_feedback", 0);
  axis.step();
  EXPECT_GT(axis.actual(), 2'000);
}

TEST(FrozenFeedback, IsPartOfASnapshot) {
  AxisBank bank(std::vector<AxisConfiguration>(1), std::chrono::milliseconds{1});
  bank.write(0, AxisUnderTest::address_of("test_load_torque"), 1'000);
  for (int tick = 0; tick < 100; ++tick) bank.step();
  bank.write(0, kFrozenFeedback, 1);
  const AxisBank::Snapshot frozen = bank.snapshot();
  const std::int32_t shown = bank.status(0).load_position_actual_value;
  bank.write(0, kFrozenFeedback, 0);
  bank.step();
  ASSERT_NE(bank.status(0).load_position_actual_value, shown);
  AxisBank other(std::vector<AxisConfiguration>(1), std::chrono::milliseconds{1});
  other.restore(other.snapshot_from(frozen.bytes()));
  for (int tick = 0; tick < 100; ++tick) other.step();
  EXPECT_EQ(other.status(0).load_position_actual_value, shown);
}

TEST(FrozenFeedback, RefusesOtherValuesAndIsNotStored) {
  AxisUnderTest axis;
  EXPECT_EQ(axis.try_write("test_frozen_feedback", 2), AbortCode::value_too_high);
  EXPECT_EQ(axis.try_write("test_frozen_feedback", -1), AbortCode::value_too_low);
  EXPECT_EQ(axis.axis().set_stored(kFrozenFeedback, 1), AbortCode::cannot_store_or_transfer);
}

}  // namespace
}  // namespace vdrive
