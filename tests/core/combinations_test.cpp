// SPDX-License-Identifier: Apache-2.0
// Two functions of the drive at the same time: limited jerk on a real plant and on a modulo range,
// touch probes of a modulo axis, homing of drives with habits, quick stops of the modes without a
// profile while 6086h asks for limited jerk. Figures are derived by hand; 4096 user units are one
// turn.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace vdrive {
namespace {

using test::AxisUnderTest;

constexpr std::uint16_t kBits10To13 = 0x3400;

/// 6086h = 3 with a jerk [UU/s³].
void round_profiles(AxisUnderTest& axis, std::int64_t jerk) {
  axis.write("motion_profile_type", 3);
  axis.write("profile_jerk_1", jerk);
}

/// Takes the absolute target immediately, even in motion, and runs the first tick of its plan.
void go_to(AxisUnderTest& axis, std::int64_t target) {
  axis.write("position_user_target_value", target);
  axis.controlword(0x002F);
  axis.command(0x003F);
}

// ---- limited jerk and the plant -----------------------------------------------------------------

/// A weight of 0.6 N.m on a motor of 3 N.m, held by a brake without power; no friction.
AxisConfiguration lifting_axis() {
  AxisConfiguration configuration;
  configuration.model.viscous_friction = 0.0;
  configuration.model.coulomb_friction = 0.0;
  configuration.model.gravity_torque = -0.6;
  configuration.model.brake_torque = 2.0;
  return configuration;
}

TEST(LimitedJerkOfAPlant, NeedsTheTorqueOfTheWeightAndOfItsRoundedRamp) {
  // The acceleration of 409600 UU/s², 628.3 rad/s², takes 0.377 N.m on 6e-4 kg.m²: 125.7 per mille
  // on top of the 200 for the weight. With 4096000 UU/s³ it is reached after 0.1 s, half of it
  // after 0.05 s, and the speed of 100000 UU/s after 100000/409600 + 0.1 = 0.344 s.
  AxisUnderTest axis(lifting_axis());
  round_profiles(axis, 4'096'000);
  axis.write("profile_velocity", 100'000);
  axis.enable();
  axis.step(3'000);
  ASSERT_NEAR(axis.status().torque_actual_value, 200, 1);
  go_to(axis, 1'000'000);
  axis.step(49);
  EXPECT_NEAR(axis.status().torque_actual_value, 263, 5);
  axis.step(150);
  EXPECT_NEAR(axis.status().torque_actual_value, 326, 5) << "after 0.2 s";
  axis.step(300);
  EXPECT_NEAR(axis.status().torque_actual_value, 200, 5) << "after 0.5 s, at 100000 UU/s";
  EXPECT_EQ(axis.demand_velocity(), 100'000);
}

TEST(LimitedJerkOfAPlant, IsThatOfTheDemandWhateverThePlantDoes) {
  AxisConfiguration configuration = lifting_axis();
  configuration.model.cogging_torque = 0.05;
  configuration.model.torque_ripple = 2.0;
  configuration.model.motor_thermal_time_constant = 1'000.0;
  AxisUnderTest real(configuration);
  AxisUnderTest plain;
  for (AxisUnderTest* const axis : {&real, &plain}) {
    round_profiles(*axis, 4'096'000);
    axis->enable();
    axis->step(1'000);
    go_to(*axis, 20'000);
  }
  for (int tick = 0; tick < 1'500; ++tick) {
    ASSERT_NEAR(real.demand(), plain.demand(), 1) << tick;
    ASSERT_NEAR(real.demand_velocity(), plain.demand_velocity(), 1) << tick;
    real.step();
    plain.step();
  }
  EXPECT_EQ(real.demand(), 20'000);
  EXPECT_NEAR(real.actual(), 20'000, 5);
}

TEST(LimitedJerkOfAPlant, EndsInAFollowingErrorAtAnEndStop) {
  AxisConfiguration configuration;
  configuration.model.upper_end_stop = 1'000.0;
  AxisUnderTest axis(configuration);
  round_profiles(axis, 4'096'000);
  axis.write("profile_velocity", 10'000);
  axis.enable();
  go_to(axis, 1'000'000);
  // 6065h = 20480 UU beyond the stop: about 2.2 s at 10000 UU/s.
  ASSERT_NE(axis.step_until_state(PowerState::fault, 5'000), 0U);
  EXPECT_EQ(axis.status().error_code, 0x8611);
  EXPECT_NEAR(axis.actual(), 1'000, 1);
}

// ---- limited jerk on a modulo range ------------------------------------------------------------

constexpr std::int64_t kSpanOfTable = 4'096;
constexpr std::int64_t kPositiveWay = 2 + 128;  // 60F2h
constexpr std::int64_t kShorterWay = 2 + 192;

/// Shows positions in [0, span).
AxisConfiguration turntable(std::int32_t position, std::int64_t span = kSpanOfTable) {
  AxisConfiguration configuration;
  configuration.initial_position = position;
  configuration.parameters = {{AxisUnderTest::address_of("min_position_range_limit"), 0},
                              {AxisUnderTest::address_of("max_position_range_limit"), span}};
  return configuration;
}

/// Moves from 3900 across the end of the range to 204: 400 UU with 1600000 UU/s³, in four phases of
/// 0.05 s: 400 = 2 x 1600000 x 0.05³; at most 80000 UU/s² and 4000 UU/s.
class RoundedTurn : public testing::Test {
 protected:
  static constexpr std::int64_t kTurnJerk = 1'600'000;

  void SetUp() override {
    round_profiles(axis_, kTurnJerk);
    axis_.enable();
    set_off(204, kShorterWay);
  }

  void set_off(std::int64_t target, std::int64_t option) {
    axis_.write("positioning_option_code", option);
    go_to(axis_, target);
    note();
  }

  void step(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      axis_.step();
      note();
    }
  }

  void step_to_the_end() {
    for (int ticks = 0; ticks < 5'000 && !axis_.reached(); ++ticks) step(1);
    ASSERT_TRUE(axis_.reached());
  }

  AxisUnderTest& axis() { return axis_; }

  /// Distance from 3900.
  [[nodiscard]] std::int64_t whole_way() const { return way_; }

 private:
  /// Checks the tick: in the range, forward, and with the second difference of limited jerk.
  void note() {
    const std::int32_t velocity = axis_.demand_velocity();
    const std::int32_t change = velocity - velocity_;
    EXPECT_GE(axis_.demand(), 0);
    EXPECT_LT(axis_.demand(), kSpanOfTable);
    EXPECT_GE(velocity, 0) << "tick " << axis_.ticks();
    // 1600000 UU/s³ x (1 ms)² is 1.6 UU/s; 2 more for rounding.
    EXPECT_LE(std::abs(change - change_), 4) << "tick " << axis_.ticks();
    velocity_ = velocity;
    change_ = change;
    std::int64_t moved = axis_.demand() - place_;
    if (moved < -kSpanOfTable / 2) moved += kSpanOfTable;
    way_ += moved;
    place_ = axis_.demand();
  }

  AxisUnderTest axis_{turntable(3'900)};
  std::int32_t velocity_ = 0;
  std::int32_t change_ = 0;
  std::int64_t place_ = 3'900;
  std::int64_t way_ = 0;
};

TEST_F(RoundedTurn, CrossesTheEndOfTheRangeInOnePiece) {
  step(49);
  EXPECT_EQ(axis().demand(), 3'933);  // 1600000 x 0.05³ / 6 = 33.33
  EXPECT_NEAR(axis().demand_velocity(), 2'000, 1);
  step(50);
  EXPECT_EQ(axis().demand(), 4);  // half the distance: 4100
  EXPECT_NEAR(axis().demand_velocity(), 4'000, 1);
  step(50);
  EXPECT_EQ(axis().demand(), 171);  // 33.33 before the end: 170.67
  EXPECT_NEAR(axis().demand_velocity(), 2'000, 1);
  step(50);
  EXPECT_EQ(axis().demand(), 204);
  EXPECT_EQ(axis().demand_velocity(), 0);
  EXPECT_EQ(whole_way(), 400);
}

// After 0.1 s the axis is at 4 with 4000 UU/s; with this jerk it would come to rest 200 UU further
// on, at 204. With the ramp of 6084h alone it would come to rest at 24.
TEST_F(RoundedTurn, ReachesATargetShortOfTheJerkLimitedStopATurnLater) {
  step(99);
  set_off(190, kPositiveWay);
  step_to_the_end();
  EXPECT_EQ(axis().demand(), 190);
  EXPECT_EQ(whole_way(), 196 + 190 + kSpanOfTable);
}

TEST_F(RoundedTurn, ReachesATargetPastTheJerkLimitedStopInThisTurn) {
  step(99);
  set_off(220, kPositiveWay);
  step_to_the_end();
  EXPECT_EQ(axis().demand(), 220);
  EXPECT_EQ(whole_way(), 196 + 220);
}

// ---- touch probes of a modulo axis --------------------------------------------------------------

TEST(TouchProbeOfAModuloAxis, LatchesPositionsInTheRangeAfterAWrap) {
  // From 4000 through 0 to 500, 596 UU with 409600 UU/s²: 12671 UU/s at the first edge, after 196
  // UU, and 12800 UU/s at the second, 200 UU before the end. At these speeds a sub-step of 125 us
  // is 1.6 UU.
  AxisUnderTest axis(turntable(4'000));
  axis.write("test_switch_home", 4'196);  // in machine coordinates: 100 in the range
  axis.write("test_switch_home_length", 200);
  axis.write("touch_probe_function", 0x0031);  // both edges of the home switch
  axis.write("positioning_option_code", kPositiveWay);
  axis.enable();
  go_to(axis, 500);
  axis.step(500);
  ASSERT_EQ(axis.demand(), 500);
  EXPECT_EQ(axis.read("touch_probe_status"), 0x0007);
  EXPECT_GE(axis.read("touch_probe_position_1_positive_value"), 100);
  EXPECT_LE(axis.read("touch_probe_position_1_positive_value"), 102);
  EXPECT_GE(axis.read("touch_probe_position_1_negative_value"), 300);
  EXPECT_LE(axis.read("touch_probe_position_1_negative_value"), 302);
}

TEST(TouchProbeOfAModuloAxis, LatchesEachIndexPulseInTheRange) {
  // A range of 1000 UU and a pulse every 4096 UU: the n-th pulse is at 96 n modulo 1000. At 40960
  // UU/s it is detected at most 5.12 UU late. In 4.2 s there are 41 pulses.
  constexpr std::int64_t kRange = 1'000;
  constexpr std::int64_t kPulse = 4'096;
  AxisUnderTest axis(turntable(0, kRange));
  axis.write("touch_probe_function", 0x0017);  // index pulse, each positive edge
  axis.write("op_mode_cmd", 3);
  axis.command(0x000F);
  axis.write("target_velocity", 40'960);
  std::int64_t counted = 0;
  for (int tick = 0; tick < 4'200; ++tick) {
    axis.step();
    const std::int64_t count = axis.read("touch_probe_1_positive_edge_counter");
    if (count == counted) continue;
    ASSERT_EQ(count, counted + 1);
    counted = count;
    const std::int64_t position = axis.read("touch_probe_position_1_positive_value");
    ASSERT_GE(position, counted * kPulse % kRange) << counted;
    ASSERT_LE(position, counted * kPulse % kRange + 6) << counted;
    ASSERT_LT(position, kRange);
  }
  EXPECT_EQ(counted, 41);
}

// ---- homing of drives with habits ---------------------------------------------------------------

/// Homing mode with `method`, enabled; no run has started.
void enable_homing(AxisUnderTest& axis, std::int64_t method) {
  axis.write("homing_method", method);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
}

TEST(HomingWithHabits, APulseOfBit4BetweenTwoLooksStartsNoRun) {
  for (const std::int64_t loop : {0, 4}) {  // 5E20h:06
    SCOPED_TRACE(loop);
    AxisUnderTest axis;
    enable_homing(axis, 37);
    axis.write("habit_controlword_loop", loop);
    axis.controlword(0x001F);
    axis.command(0x000F);
    axis.step(100);
    EXPECT_EQ(axis.statusword() & kBits10To13, loop == 0 ? 0x1400 : 0x0400) << "attained, or idle";
    EXPECT_EQ(axis.status().ignored_set_points, loop == 0 ? 0U : 1U);
    axis.command(0x001F);
    axis.step(100);
    EXPECT_EQ(axis.statusword() & kBits10To13, 0x1400) << "an edge that lasts";
  }
}

TEST(HomingWithHabits, AnEdgeBeforeALateModeStartsNoRun) {
  AxisUnderTest axis;
  axis.write("homing_method", 37);
  axis.enable();
  axis.write("habit_mode_display_delay", 20);
  axis.write("op_mode_cmd", 6);
  axis.command(0x001F);
  axis.step(100);
  ASSERT_EQ(axis.status().op_mode_actual, 6);
  EXPECT_EQ(axis.statusword() & kBits10To13, 0x0400) << "idle";
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
  axis.command(0x000F);
  axis.command(0x001F);
  axis.step(100);
  EXPECT_EQ(axis.statusword() & kBits10To13, 0x1400);
}

TEST(HomingWithHabits, DroppingBit4EndsTheSearchForAMechanicalStop) {
  for (const std::int64_t habit : {0, 1}) {  // 5E20h:0D
    SCOPED_TRACE(habit);
    AxisConfiguration configuration;
    configuration.model.upper_end_stop = 2'000.0;
    AxisUnderTest axis(configuration);
    axis.write("habit_homing_by_level", habit);
    axis.write("homing_stop_time", 1'000);
    enable_homing(axis, -4);
    axis.command(0x001F);
    axis.step(400);
    ASSERT_NEAR(axis.actual(), 2'000, 1) << "pressed, and 1 s is not over";
    ASSERT_EQ(axis.statusword() & kBits10To13, 0);
    axis.command(0x000F);
    axis.step(4'000);
    EXPECT_EQ(axis.statusword() & kBits10To13, habit == 0 ? 0x1400 : 0x0400) << "attained, or idle";
    EXPECT_EQ(axis.state(), PowerState::operation_enabled);
  }
}

// ---- quick stops of the modes without a profile -------------------------------------------------

struct UnroundedRow {
  std::int64_t mode;
  const char* name;
  const char* object;  // written in each tick
  std::int64_t first;  // its first value, and the increment per tick
  std::int64_t step;
  std::uint16_t word;
};

/// At about 20000 UU/s: 300 rpm x 4096 / 60 in mode 2; in mode 10 from 0.3 N.m on 6e-4 kg.m².
constexpr std::array<UnroundedRow, 4> kUnroundedRows{{
    {2, "velocity", "vl_target_velocity", 300, 0, 0x007F},
    {7, "interpolated_position", "interpolation_data_record", 20, 20, 0x001F},
    {9, "cyclic_velocity", "target_velocity", 20'480, 0, 0x000F},
    {10, "cyclic_torque", "target_torque", 100, 0, 0x000F},
}};

class UnroundedQuickStop : public testing::TestWithParam<UnroundedRow> {
 protected:
  static void run(AxisUnderTest& axis) {
    const UnroundedRow& row = GetParam();
    round_profiles(axis, 4'096'000);
    axis.write("following_error_window", 0xFFFFFFFF);
    axis.write("op_mode_cmd", row.mode);
    axis.command(row.word);
    for (std::int64_t tick = 0; tick < 100; ++tick) {
      axis.write(row.object, row.first + row.step * tick);
      axis.step();
    }
    ASSERT_GT(axis.velocity(), 15'000);
  }

  /// @return the decrease of 606Bh per tick [UU/s], from the third tick of a stop on.
  static std::int32_t loss(AxisUnderTest& axis) {
    axis.step(2);
    const std::int32_t before = axis.demand_velocity();
    axis.step(5);
    return (before - axis.demand_velocity()) / 5;
  }
};

// With limited jerk the ramps would begin with 4096000 UU/s³: 4 UU/s more from tick to tick.
TEST_P(UnroundedQuickStop, HasNoJerkLimit) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run(axis));
  axis.write("quick_stop_option_code", 2);
  axis.controlword(0x0002);
  EXPECT_NEAR(loss(axis), 2'048, 1) << "6085h and 604Ah: 2048000 UU/s² by default";
}

TEST_P(UnroundedQuickStop, HasTheWholeNormalRampAtOnce) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run(axis));
  axis.write("quick_stop_option_code", 1);
  axis.controlword(0x0002);
  if (GetParam().mode == 10) {
    axis.step(20);  // 100 per mille, 10 per tick by 6087h
    EXPECT_EQ(axis.status().torque_demand, 0);
    EXPECT_EQ(axis.demand_velocity(), 0);
  } else {
    EXPECT_NEAR(loss(axis), 410, 1) << "6084h and 6049h: 409600 UU/s² by default";
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, UnroundedQuickStop, testing::ValuesIn(kUnroundedRows),
                         [](const auto& row) {
                           return std::string(row.param.name);
                         });

}  // namespace
}  // namespace vdrive
