// SPDX-License-Identifier: Apache-2.0
// 5E21h: limit switches and a home switch at positions along the travel of the axis.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;

// 60FDh
constexpr std::int64_t kNegativeSwitch = 1;
constexpr std::int64_t kPositiveSwitch = 2;
constexpr std::int64_t kHomeSwitch = 4;

/// Starts an absolute move at 40000 UU/s immediately.
void start_to(AxisUnderTest& axis, std::int32_t target) {
  axis.write("profile_velocity", 40'000);
  axis.write("position_user_target_value", target);
  axis.write("positioning_option_code", 0);
  axis.command(0x000F);
  axis.command(0x003F);
}

void move_to(AxisUnderTest& axis, std::int32_t target) {
  start_to(axis, target);
  ASSERT_GT(axis.step_until_status(Statusword::kTargetReached, Statusword::kTargetReached, 20'000),
            0U);
  axis.step(100);
}

TEST(SwitchPlaces, AreNowhereByDefault) {
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kGreatest = std::numeric_limits<std::int32_t>::max();
  for (const std::int32_t position : {kLeast, 0, kGreatest}) {
    AxisConfiguration configuration;
    configuration.initial_position = position;
    AxisUnderTest axis(configuration);
    axis.step(10);
    EXPECT_EQ(axis.read("digital_inputs"), 0) << position;
  }
}

TEST(SwitchPlaces, MakeTheInputsFollowThePosition) {
  AxisUnderTest axis;
  axis.write("test_switch_negative_limit", -5'000);
  axis.write("test_switch_positive_limit", 12'000);
  axis.write("test_switch_home", 3'000);
  axis.write("test_switch_home_length", 2'000);
  axis.enable();
  start_to(axis, 11'900);
  for (int tick = 0; tick < 1'000; ++tick) {
    axis.step();
    const std::int32_t actual = axis.actual();
    // 6064h is rounded: at the edge itself either value is right.
    if (actual == 3'000 || actual == 5'000) continue;
    const bool is_home = actual > 3'000 && actual < 5'000;
    ASSERT_EQ(axis.read("digital_inputs"), is_home ? kHomeSwitch : 0) << actual;
  }
  ASSERT_EQ(axis.actual(), 11'900);
}

// A table of 4096 UU per turn, which starts at 500 and moves in one direction.
TEST(SwitchPlaces, OfAHomeSwitchAreInEachTurnOfAModuloAxis) {
  for (const int sign : {1, -1}) {
    AxisConfiguration configuration;
    configuration.initial_position = 500;
    configuration.parameters = {{AxisUnderTest::address_of("max_position_range_limit"), 4'096}};
    AxisUnderTest axis(configuration);
    axis.write("test_switch_home", 3'000);
    axis.write("test_switch_home_length", 200);
    axis.write("op_mode_cmd", 3);
    axis.command(0x000F);
    axis.write("target_velocity", sign * 20'000);
    int seen = 0;
    bool is_on = false;
    for (int tick = 0; tick < 1'000; ++tick) {
      axis.step();
      const std::int32_t actual = axis.actual();
      const bool was_on = is_on;
      is_on = axis.read("digital_inputs") == kHomeSwitch;
      seen += is_on && !was_on ? 1 : 0;
      if (actual == 3'000 || actual == 3'200) continue;  // at the edge itself either value is right
      ASSERT_EQ(is_on, actual > 3'000 && actual < 3'200) << actual;
    }
    // 1 s at 20000 UU/s, minus half the ramp of 0.05 s: 19500 UU, 4.7 turns.
    EXPECT_EQ(seen, 5);
  }
}

TEST(SwitchPlaces, AreSeenWithoutPowerToo) {
  AxisUnderTest axis;
  axis.write("test_switch_negative_limit", -1'000);
  axis.write("test_load_torque", -300);
  axis.step(1'000);
  ASSERT_LT(axis.actual(), -2'000) << "pushed by the load";
  EXPECT_EQ(axis.read("digital_inputs"), kNegativeSwitch);
}

TEST(SwitchPlaces, ALimitSwitchStopsAMotionTowardsItAndLetsTheAxisBack) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("quick_stop_deceleration", 400'000);
    axis.write("test_switch_negative_limit", -30'000);
    axis.write("test_switch_positive_limit", 30'000);
    axis.enable();
    start_to(axis, sign * 1'000'000);
    axis.step(3'000);
    // Detected within a tick, 40 UU; 40000²/(2 x 400000) = 2000 UU to brake; the load lags a
    // little.
    EXPECT_GT(sign * axis.actual(), 30'000);
    EXPECT_LT(sign * axis.actual(), 30'000 + 2'000 + 200);
    EXPECT_EQ(axis.demand_velocity(), 0);
    EXPECT_TRUE(axis.limit_active());
    EXPECT_EQ(axis.read("digital_inputs"), sign > 0 ? kPositiveSwitch : kNegativeSwitch);
    ASSERT_NO_FATAL_FAILURE(move_to(axis, 0));
    EXPECT_EQ(axis.demand(), 0);
    EXPECT_FALSE(axis.limit_active());
    EXPECT_EQ(axis.read("digital_inputs"), 0);
  }
}

TEST(SwitchPlaces, AddToTheInputsThatTheTestBenchSets) {
  AxisUnderTest axis;
  axis.write("test_switch_home", -10);
  axis.write("test_switch_home_length", 20);
  axis.write("test_home_input", 1);
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), kHomeSwitch);
  axis.write("test_home_input", 0);
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), kHomeSwitch) << "the axis stands on the switch";
  axis.write("test_switch_home", 10);
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), 0);
  axis.write("test_home_input", 1);
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), kHomeSwitch) << "set by hand";
}

TEST(SwitchPlaces, StayAtTheirPlaceOfTheMachineWhenHomingMovesThePositions) {
  AxisUnderTest axis;
  axis.write("test_switch_positive_limit", 30'000);
  axis.enable();
  ASSERT_NO_FATAL_FAILURE(move_to(axis, 20'000));
  axis.write("homing_method", 35);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.command(0x001F);
  ASSERT_GT(axis.step_until_status(0x1400, 0x1400, 1'000), 0U);
  axis.write("op_mode_cmd", 1);
  axis.command(0x000F);
  ASSERT_NO_FATAL_FAILURE(move_to(axis, 9'900));
  EXPECT_EQ(axis.read("digital_inputs"), 0) << "29900 of the machine";
  start_to(axis, 10'100);
  axis.step(1'000);
  EXPECT_EQ(axis.read("digital_inputs"), kPositiveSwitch) << "beyond 30000 of the machine";
}

TEST(SwitchPlaces, OutlastAPowerCycle) {
  AxisUnderTest axis;
  axis.write("test_switch_positive_limit", -100);
  axis.step();
  axis.axis().power_cycle();
  EXPECT_EQ(axis.read("test_switch_positive_limit"), -100);
  EXPECT_EQ(axis.status().digital_inputs, kPositiveSwitch) << "at once";
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), kPositiveSwitch);
}

TEST(SwitchPlaces, HaveTheUnitsOf6064hWithAGearToo) {
  for (const Feedback feedback : {Feedback::single_encoder, Feedback::dual_encoder}) {
    for (const Coupling coupling : {Coupling::rigid, Coupling::two_inertia}) {
      AxisConfiguration configuration;
      configuration.model.feedback = feedback;
      configuration.model.coupling = coupling;
      configuration.initial_position = 700;
      AxisUnderTest axis(configuration);
      axis.write("gear_ratio_denominator", 4);
      axis.write("test_switch_home", 5'000);
      axis.write("test_switch_home_length", 1'000);
      axis.enable();
      ASSERT_NO_FATAL_FAILURE(move_to(axis, 4'980));
      EXPECT_EQ(axis.read("digital_inputs"), 0);
      ASSERT_NO_FATAL_FAILURE(move_to(axis, 5'020));
      EXPECT_EQ(axis.read("digital_inputs"), kHomeSwitch);
      ASSERT_NO_FATAL_FAILURE(move_to(axis, 6'020));
      EXPECT_EQ(axis.read("digital_inputs"), 0);
    }
  }
}

TEST(SwitchPlaces, LetHomingFindASwitchWithoutAnyoneWhoSetsTheInput) {
  // Method 17: to the negative limit switch at -8000, and back to where it opens, which becomes 0.
  AxisUnderTest axis;
  axis.write("test_switch_negative_limit", -8'000);
  axis.write("test_switch_home", 0);
  axis.write("test_switch_home_length", 1'000);
  axis.write("homing_method", 17);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.command(0x001F);
  ASSERT_GT(axis.step_until_status(0x1400, 0x1400, 20'000), 0U);
  EXPECT_EQ(axis.read("digital_inputs"), 0);
  // Position 0 of the machine is now 8000 minus up to 6.8 UU, two ticks at 6099h:02 = 3413 UU/s:
  // the switch is seen open in one tick, and home is the reading of the next.
  axis.write("op_mode_cmd", 1);
  axis.write("touch_probe_function", 0x0011);
  axis.command(0x000F);
  ASSERT_NO_FATAL_FAILURE(move_to(axis, 8'500));
  ASSERT_EQ(axis.read("touch_probe_status"), 3);
  EXPECT_NEAR(static_cast<double>(axis.read("touch_probe_position_1_positive_value")), 8'000.0,
              10.0);
}

TEST(SwitchPlaces, ChangeNoBitOfAMotionThatDoesNotReachThem) {
  const auto bank_with = [](std::int64_t place) {
    AxisBank bank(std::vector<AxisConfiguration>(3), std::chrono::milliseconds{1});
    const auto write = [&bank](std::size_t axis, std::string_view name, std::int64_t value) {
      EXPECT_EQ(bank.write(axis, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
    };
    for (std::size_t axis = 0; axis < bank.size(); ++axis) {
      if (axis != 1) write(axis, "test_switch_positive_limit", place);
      write(axis, "profile_velocity", 40'000);
      write(axis, "op_mode_cmd", 1);
      write(axis, "ds402_controlword", 0x000F);
    }
    bank.step();
    for (std::size_t axis = 0; axis < bank.size(); ++axis) {
      write(axis, "position_user_target_value", 30'000);
      write(axis, "ds402_controlword", 0x001F);
    }
    return bank;
  };
  AxisBank without = bank_with(std::numeric_limits<std::int32_t>::max());
  AxisBank with = bank_with(40'000);
  for (int tick = 0; tick < 5'000; ++tick) {
    without.step();
    with.step();
    ASSERT_EQ(with.status_hash(), without.status_hash()) << tick;
  }
}

}  // namespace
}  // namespace vdrive
