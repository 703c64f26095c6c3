// SPDX-License-Identifier: Apache-2.0
// Profile torque mode (6060h = 4): slope, limits, the speed limit 607Fh, stops.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using enum PowerState;

constexpr std::int64_t kAtOnce = 4'294'967'295;  // 6087h: any torque within one tick

/// Profile torque, Operation enabled, at rest.
void enable_profile_torque(AxisUnderTest& axis) {
  axis.write("op_mode_cmd", 4);
  axis.command(0x000F);
}

AxisConfiguration without_friction() {
  AxisConfiguration configuration;
  configuration.model.viscous_friction = 0.0;
  configuration.model.coulomb_friction = 0.0;
  return configuration;
}

/// Runs with `torque` up to the speed limit 607Fh of 40000 UU/s. 6084h, 6085h and 60C6h are ramps
/// of 50, 100 and 200 UU/s per tick.
void run_with(AxisUnderTest& axis, std::int64_t torque) {
  axis.write("profile_dec", 50'000);
  axis.write("quick_stop_deceleration", 100'000);
  axis.write("app_dec_limit", 200'000);
  axis.write("app_speed_limit", 40'000);
  axis.write("torque_slope", kAtOnce);
  enable_profile_torque(axis);
  axis.write("target_torque", torque);
  axis.step(1'000);
  ASSERT_GT(axis.velocity() * (torque < 0 ? -1 : 1), 35'000);
}

// ---- torque ------------------------------------------------------------------------------------

TEST(ProfileTorque, TheDemandRampsWithTheSlope6087h) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    axis.write("torque_slope", 8'000);  // 1 per mille in each of the 8 sub-steps of a tick
    enable_profile_torque(axis);
    axis.write("target_torque", sign * 400);
    for (int tick = 1; tick <= 50; ++tick) {
      axis.step();
      // 6074h is the command of the last sub-step; the first one of the ramp commands 0.
      ASSERT_EQ(axis.status().torque_demand, sign * (8 * tick - 1)) << tick;
      ASSERT_FALSE(axis.reached());
    }
    axis.step();
    EXPECT_EQ(axis.status().torque_demand, sign * 400);
    EXPECT_TRUE(axis.reached());
    axis.write("target_torque", 0);
    for (int tick = 1; tick <= 50; ++tick) {
      axis.step();
      ASSERT_EQ(axis.status().torque_demand, sign * (400 - 8 * tick + 1)) << tick;
    }
    axis.step();
    EXPECT_EQ(axis.status().torque_demand, 0);
    EXPECT_EQ(axis.statusword(), 0x0637);
  }
}

TEST(ProfileTorque, ASlopeOf0CountsAs1AndTakesEffectDuringMotion) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  axis.write("torque_slope", 0);
  enable_profile_torque(axis);
  axis.write("target_torque", 100);
  axis.step(3'000);
  EXPECT_EQ(axis.status().torque_demand, 3);
  axis.write("target_torque", 4);
  axis.step(900);
  EXPECT_EQ(axis.status().torque_demand, 4) << "rounded";
  EXPECT_FALSE(axis.reached()) << "still on its way";
  axis.step(102);
  EXPECT_TRUE(axis.reached());
  axis.write("target_torque", 100);
  axis.write("torque_slope", 10'000);
  axis.step(11);
  EXPECT_EQ(axis.status().torque_demand, 100);
}

TEST(ProfileTorque, ConstantTorqueAcceleratesTheInertia) {
  // 100 per mille of 3 N.m on 6e-4 kg.m2: 500 rad/s² = 325949 UU/s². The current loop of 1000 Hz
  // delays the velocity by one of its time constants.
  const double acceleration = 0.3 / 6.0e-4 * 4096.0 / (2.0 * std::numbers::pi);
  const double lag = 1.0 / (2.0 * std::numbers::pi * 1000.0);
  for (const int sign : {1, -1}) {
    AxisUnderTest axis(without_friction());
    axis.write("torque_slope", kAtOnce);
    enable_profile_torque(axis);
    axis.write("target_torque", sign * 100);
    axis.step();  // the ramp: 0 to 7/8 of the torque in 8 sub-steps, 7/16 on average
    for (int tick = 2; tick <= 300; ++tick) {
      axis.step();
      // 606Ch is the mean over the tick: the velocity half a tick before its end.
      const double time = (tick - 0.5 - 9.0 / 16.0) * 1.0e-3 - lag;
      ASSERT_NEAR(axis.velocity(), sign * acceleration * time, 3.0) << tick;
    }
    EXPECT_EQ(axis.status().torque_actual_value, sign * 100);
  }
}

TEST(ProfileTorque, ATorqueBelowFrictionMovesNothing) {
  AxisUnderTest axis;
  enable_profile_torque(axis);
  axis.write("target_torque", 16);  // 0.048 N.m against 0.05 N.m
  axis.step(500);
  EXPECT_EQ(axis.actual(), 0);
  EXPECT_TRUE(axis.reached());
  axis.write("target_torque", 18);
  axis.step(500);
  EXPECT_GT(axis.actual(), 0);
}

TEST(ProfileTorque, TheTorqueIsLimitedBy6072h60E0hAnd60E1h) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  axis.write("max_torque", 500);
  axis.write("torque_slope", 100'000);
  enable_profile_torque(axis);
  axis.write("target_torque", 1'000);
  axis.step(50);
  EXPECT_EQ(axis.status().torque_demand, 500);
  EXPECT_FALSE(axis.reached()) << "the torque of 6071h is not there";
  axis.write("positive_torque_limit_relative", 300);
  axis.write("negative_torque_limit_relative", 200);
  axis.step(5);
  EXPECT_EQ(axis.status().torque_demand, 300);
  axis.write("target_torque", -1'000);
  axis.step(50);
  EXPECT_EQ(axis.status().torque_demand, -200);
  EXPECT_EQ(axis.status().torque_actual_value, -200);
  EXPECT_EQ(axis.read("target_torque"), -1'000);
}

TEST(ProfileTorque, TheDemandContinuesItsRampAfterALimitIsRaised) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  axis.write("max_torque", 500);
  axis.write("positive_torque_limit_relative", 900);
  axis.write("torque_slope", 8'000);
  enable_profile_torque(axis);
  axis.write("target_torque", 2'000);
  axis.step(500);
  ASSERT_EQ(axis.status().torque_demand, 500);
  axis.write("max_torque", 3'000);
  axis.step(10);
  EXPECT_EQ(axis.status().torque_demand, 500 + 79);
  axis.step(500);
  ASSERT_EQ(axis.status().torque_demand, 900);
  axis.write("positive_torque_limit_relative", 0);
  axis.step(10);
  EXPECT_EQ(axis.status().torque_demand, 900 + 79);
}

TEST(ProfileTorque, TheTorqueLeavesTheSpeedLimitAtOnce) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run_with(axis, 1'000));
  axis.write("torque_slope", 8'000);
  axis.step();
  const std::int32_t commanded = axis.status().torque_demand;
  ASSERT_LT(commanded, 100) << "just what friction needs at 607Fh";
  axis.write("target_torque", 0);
  axis.step();
  EXPECT_NEAR(axis.status().torque_demand, commanded - 7, 2);
}

TEST(ProfileTorque, TheDemandLeavesATorqueLimitAtOnce) {
  for (const std::int64_t relative : {0, 500, 2'000}) {  // 60E0h off, equal, above 6072h
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    axis.write("max_torque", relative == 500 ? 3'000 : 500);
    axis.write("positive_torque_limit_relative", relative);
    axis.write("torque_slope", 8'000);
    enable_profile_torque(axis);
    axis.write("target_torque", 30'000);
    axis.step(2'000);
    ASSERT_EQ(axis.status().torque_demand, 500);
    axis.write("target_torque", 0);
    axis.step(10);
    EXPECT_EQ(axis.status().torque_demand, 500 - 79);
  }
}

TEST(ProfileTorque, AppliesNoTorqueWithoutPower) {
  AxisUnderTest axis;
  axis.write("target_torque", 500);
  axis.write("op_mode_cmd", 4);
  axis.step(10);
  EXPECT_EQ(axis.status().torque_demand, 0);
  EXPECT_EQ(axis.velocity(), 0);
  axis.command(0x000F);
  axis.step(100);
  EXPECT_GT(axis.velocity(), 0);
  axis.command(0x0000);
  EXPECT_EQ(axis.status().torque_demand, 0);
  EXPECT_EQ(axis.status().torque_actual_value, 0);
  EXPECT_EQ(axis.status().motor_op_status, 0);
}

TEST(ProfileTorque, HasNoFollowingError) {
  AxisUnderTest axis;
  enable_profile_torque(axis);
  axis.write("target_torque", 500);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    ASSERT_EQ(axis.demand(), axis.actual());
  }
  EXPECT_EQ(axis.state(), operation_enabled);
}

// ---- speed -------------------------------------------------------------------------------------

TEST(ProfileTorque, TheRunningSpeedIsBoundedBy607Fh) {
  for (const std::int64_t period : {125, 1'000, 10'000}) {
    for (const std::int64_t torque : {100, -100, 1'000, -3'000}) {
      SCOPED_TRACE(torque);
      AxisUnderTest axis({}, microseconds{period});
      axis.write("app_speed_limit", 20'000);
      axis.write("torque_slope", kAtOnce);
      enable_profile_torque(axis);
      axis.write("target_torque", torque);
      for (std::int64_t time = 0; time < 600'000; time += period) {
        axis.step();
        ASSERT_LE(std::abs(axis.velocity()), 20'001);
      }
      EXPECT_GT(std::abs(axis.velocity()), 19'000);
      EXPECT_FALSE(axis.reached()) << "the speed limit holds the torque back";
    }
  }
}

TEST(ProfileTorque, TheRunningSpeedIsBoundedBy6080h) {
  AxisUnderTest axis;
  axis.write("motor_max_speed_rpm", 300);  // 20480 UU/s
  enable_profile_torque(axis);
  axis.write("target_torque", 500);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    ASSERT_LE(axis.velocity(), 20'481);
  }
  EXPECT_GT(axis.velocity(), 19'500);
}

TEST(ProfileTorque, ANew607FhIsInForceAfterTheNextEnabling) {
  AxisUnderTest axis;
  axis.write("app_speed_limit", 20'000);
  enable_profile_torque(axis);
  axis.write("app_speed_limit", 10'000);
  axis.write("target_torque", 500);
  axis.step(500);
  EXPECT_GT(axis.velocity(), 19'000);
}

TEST(ProfileTorque, TheSpeedLimitHoldsInBothDirectionsOfAGear) {
  AxisConfiguration configuration;
  configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_numerator"), 3},
                              {AxisUnderTest::address_of("gear_ratio_denominator"), 2}};
  AxisUnderTest axis(configuration);
  axis.write("app_speed_limit", 20'000);
  enable_profile_torque(axis);
  axis.write("target_torque", 500);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    ASSERT_LE(axis.velocity(), 20'001);
  }
  EXPECT_GT(axis.velocity(), 19'000) << "607Fh counts at 606Ch";
}

// ---- halt and stops ----------------------------------------------------------------------------

TEST(ProfileTorque, HaltWithOption1ReducesTheTorqueWithItsSlope) {
  AxisUnderTest axis;
  axis.write("torque_slope", 8'000);
  enable_profile_torque(axis);
  axis.write("target_torque", 80);
  axis.step(30);
  ASSERT_EQ(axis.status().torque_demand, 80);
  axis.controlword(0x010F);
  axis.step(5);
  EXPECT_EQ(axis.status().torque_demand, 80 - 39);
  EXPECT_FALSE(axis.reached());
  axis.step(5);
  EXPECT_EQ(axis.status().torque_demand, 1);
  axis.step(3'000);  // friction stops it
  EXPECT_EQ(axis.statusword(), 0x0637);
  axis.command(0x000F);
  axis.step(11);
  EXPECT_EQ(axis.status().torque_demand, 80) << "6071h acts again";
}

class TorqueStop : public testing::TestWithParam<std::int64_t> {
 protected:
  [[nodiscard]] static std::int32_t ramp() { return GetParam() == 2 ? 100'000 : 200'000; }

  static void expect_braking(AxisUnderTest& axis, std::int32_t from) {
    const int sign = from < 0 ? -1 : 1;
    for (int tick = 1; tick <= 150; ++tick) {
      axis.step();
      const std::int32_t left = std::max(std::abs(from) - tick * ramp() / 1'000, 0);
      ASSERT_NEAR(axis.demand_velocity(), sign * left, 2) << tick;
      ASSERT_NEAR(axis.velocity(), sign * left, 400) << tick;
    }
  }
};

TEST_P(TorqueStop, HaltBrakesWithTheRampOf605Dh) {
  for (const std::int64_t torque : {500, -500}) {
    AxisUnderTest axis;
    axis.write("halt_option_code", GetParam());
    ASSERT_NO_FATAL_FAILURE(run_with(axis, torque));
    const std::int32_t speed = axis.velocity();
    axis.controlword(0x010F);
    ASSERT_NO_FATAL_FAILURE(expect_braking(axis, speed));
    axis.step(500);
    EXPECT_EQ(axis.statusword(), 0x0637);
    EXPECT_EQ(axis.velocity(), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Options, TorqueStop, testing::Values(2, 3, 4),
                         testing::PrintToStringParamName());

TEST(ProfileTorque, QuickStopWithOption1ReducesTheTorque) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 5);
  ASSERT_NO_FATAL_FAILURE(run_with(axis, 500));
  axis.write("torque_slope", 8'000);
  axis.controlword(0x0002);
  const std::int32_t before = axis.status().torque_demand;
  axis.step(3);
  EXPECT_LT(axis.status().torque_demand, before);
  axis.step(2'000);
  EXPECT_EQ(axis.status().torque_demand, 0);
  EXPECT_EQ(axis.statusword(), 0x0617);
}

TEST(ProfileTorque, DisableOperationReducesTheTorqueAndWaitsForStandstill) {
  AxisUnderTest axis;
  enable_profile_torque(axis);
  axis.write("target_torque", 50);
  axis.step(300);
  ASSERT_GT(axis.velocity(), 10'000);
  axis.command(0x0007);
  EXPECT_EQ(axis.state(), operation_enabled);
  ASSERT_NE(axis.step_until_status(0x006F, 0x0023, 1'500), 0U);
  EXPECT_LE(std::abs(axis.velocity()), 10) << "stopped by friction within the longest wait of 1 s";
}

TEST(ProfileTorque, DisableOperationAndShutdownReduceATorqueThatPressesFirst) {
  for (const std::uint16_t word : {std::uint16_t{0x0007}, std::uint16_t{0x0006}}) {
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    axis.write("torque_slope", 8'000);  // 8 per mille per tick
    axis.write("shutdown_option_code", 1);
    axis.write("disable_operation_option_code", 1);
    enable_profile_torque(axis);
    axis.write("target_torque", 400);
    axis.step(100);
    ASSERT_EQ(axis.status().torque_demand, 400);
    axis.controlword(word);
    for (int tick = 1; tick <= 50; ++tick) {
      axis.step();
      ASSERT_EQ(axis.status().torque_demand, 400 - 8 * tick + 1) << tick;
      ASSERT_EQ(axis.state(), operation_enabled);
    }
    axis.step(2);
    EXPECT_EQ(axis.state(), word == 0x0007 ? switched_on : ready_to_switch_on);
  }
}

TEST(ProfileTorque, AModeChangeWhileRunningBrakesWith6084h) {
  for (const std::int64_t mode : {1, 3, 6, 8}) {
    SCOPED_TRACE(mode);
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(run_with(axis, 500));
    const std::int32_t speed = axis.velocity();
    std::int32_t last = axis.actual();
    axis.write("op_mode_cmd", mode);
    for (int tick = 1; tick <= 700; ++tick) {
      axis.step();
      ASSERT_NEAR(axis.demand_velocity(), std::max(speed - 50 * tick, 0), 2) << tick;
      ASSERT_LE(std::abs(axis.actual() - last), 41) << "no jump";
      last = axis.actual();
    }
    axis.step(300);
    EXPECT_EQ(axis.read("op_mode_actual"), mode);
    EXPECT_EQ(axis.velocity(), 0);
  }
}

TEST(ProfileTorque, EnteringTheModeContinuesWithTheTorqueThatHoldsTheLoad) {
  AxisUnderTest axis;
  axis.write("test_load_torque", -600);  // 200 per mille
  axis.enable();
  axis.step(1'000);
  const std::int32_t holding = axis.status().torque_demand;
  ASSERT_GT(holding, 150);
  const std::int32_t place = axis.actual();
  axis.write("torque_slope", 1'000);
  axis.write("target_torque", 200);
  axis.write("op_mode_cmd", 4);
  axis.step();
  EXPECT_NEAR(axis.status().torque_demand, holding, 1) << "no step";
  axis.step(200);
  EXPECT_NEAR(axis.actual(), place, 1);
}

// ---- limit switches ----------------------------------------------------------------------------

TEST(ProfileTorque, ALimitSwitchStopsWith6085hAndOnlyANewTorqueStartsAgain) {
  for (const int sign : {1, -1}) {
    const char* const input = sign > 0 ? "test_positive_limit_input" : "test_negative_limit_input";
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(run_with(axis, sign * 500));
    const std::int32_t speed = axis.velocity();
    axis.write(input, 1);
    axis.step(100);
    EXPECT_NEAR(axis.demand_velocity(), speed - sign * 10'000, 2);
    axis.step(500);
    EXPECT_EQ(axis.velocity(), 0);
    EXPECT_TRUE(axis.limit_active());
    EXPECT_FALSE(axis.reached());
    const std::int32_t rest = axis.actual();
    axis.write(input, 0);
    axis.step(300);
    EXPECT_EQ(axis.actual(), rest) << "nothing resumes when the switch opens";
    axis.write("target_torque", sign * 500);
    axis.step(300);
    EXPECT_GT(sign * (axis.actual() - rest), 100);
  }
}

TEST(ProfileTorque, ALimitSwitchAllowsATorqueAwayFromIt) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run_with(axis, 500));
  axis.write("test_positive_limit_input", 1);
  axis.step(600);
  const std::int32_t rest = axis.actual();
  axis.write("target_torque", -100);
  axis.step(200);
  EXPECT_LT(axis.actual(), rest - 100);
}

TEST(ProfileTorque, ALoadCannotPushTheAxisThroughALimitSwitch) {
  AxisUnderTest axis;
  axis.write("app_speed_limit", 40'000);
  enable_profile_torque(axis);
  axis.write("test_load_torque", 300);
  axis.step(200);
  ASSERT_GT(axis.velocity(), 1'000);
  axis.write("test_positive_limit_input", 1);
  axis.step(500);
  const std::int32_t rest = axis.actual();
  axis.step(2'000);
  EXPECT_NEAR(axis.actual(), rest, 2);
}

TEST(ProfileTorque, ALimitSwitchOverridesHalt) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run_with(axis, 500));
  const std::int32_t speed = axis.velocity();
  axis.write("test_positive_limit_input", 1);
  axis.controlword(0x010F);
  axis.step(100);
  EXPECT_NEAR(axis.demand_velocity(), speed - 10'000, 2);
}

}  // namespace
}  // namespace vdrive
