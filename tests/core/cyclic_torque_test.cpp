// SPDX-License-Identifier: Apache-2.0
// Cyclic synchronous torque mode (6060h = 10).
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using enum PowerState;

/// Cyclic torque, Operation enabled, at rest.
void enable_cyclic_torque(AxisUnderTest& axis) {
  axis.write("op_mode_cmd", 10);
  axis.command(0x000F);
}

/// One tick of a stream of torques.
void stream_torque(AxisUnderTest& axis, std::int32_t torque) {
  axis.write("target_torque", torque);
  axis.step();
}

/// Runs with `torque` up to the speed limit 607Fh of 40000 UU/s. 6084h, 6085h and 60C6h are ramps
/// of 50, 100 and 200 UU/s per tick.
void run_with_streamed(AxisUnderTest& axis, std::int32_t torque) {
  axis.write("profile_dec", 50'000);
  axis.write("quick_stop_deceleration", 100'000);
  axis.write("app_dec_limit", 200'000);
  axis.write("app_speed_limit", 40'000);
  enable_cyclic_torque(axis);
  stream_torque(axis, torque);
  axis.step(1'000);
  ASSERT_GT(axis.velocity() * (torque < 0 ? -1 : 1), 35'000);
}

// 6074h is the command of the last of the 8 sub-steps of a tick. At the end of the tick the torque
// is the target; in the last sub-step it is 7/8 of the way there.
TEST(CyclicTorque, TheTorqueIsTheTargetAtTheEndOfItsTick) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    enable_cyclic_torque(axis);
    stream_torque(axis, sign * 400);
    EXPECT_EQ(axis.status().torque_demand, sign * 350);
    EXPECT_EQ(axis.statusword(), 0x1237) << "bits 10 and 13 are reserved";
    axis.step();
    EXPECT_EQ(axis.status().torque_demand, sign * 400);
    EXPECT_EQ(axis.statusword(), 0x1237);
  }
}

TEST(CyclicTorque, TheTorqueChangesInEqualPartsOver60C2h) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  axis.write("interpolation_time_period", 10);
  enable_cyclic_torque(axis);
  axis.write("target_torque", 800);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    // 80 per tick, 10 per sub-step: the last sub-step commands 10 less than the value at the end.
    ASSERT_EQ(axis.status().torque_demand, 80 * tick - 10);
    ASSERT_TRUE(axis.follows_command()) << "on its way";
  }
  axis.step();
  EXPECT_EQ(axis.status().torque_demand, 800);
}

TEST(CyclicTorque, AnOldTargetMovesNothing) {
  AxisUnderTest axis;
  axis.write("target_torque", 500);
  enable_cyclic_torque(axis);
  EXPECT_EQ(axis.statusword(), 0x0237) << "no command is followed yet";
  axis.step(200);
  EXPECT_EQ(axis.actual(), 0) << "the axis holds its position";
  stream_torque(axis, 500);
  axis.step(100);
  EXPECT_GT(axis.velocity(), 0);
}

TEST(CyclicTorque, AMissingUpdateHoldsTheTorque) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  enable_cyclic_torque(axis);
  stream_torque(axis, 300);
  axis.step(1'000);
  EXPECT_EQ(axis.status().torque_demand, 300);
  EXPECT_TRUE(axis.follows_command());
}

TEST(CyclicTorque, TakesTheTorqueOverFromTheLoopThatHeldTheAxis) {
  AxisUnderTest axis;
  enable_cyclic_torque(axis);
  axis.write("test_load_torque", -600);  // held by 200 per mille of 3 N.m, plus or minus friction
  axis.step(3'000);
  ASSERT_NEAR(axis.status().torque_demand, 200, 18);
  const std::int32_t held = axis.status().torque_demand;
  axis.write("interpolation_time_period", 100);
  stream_torque(axis, held);
  EXPECT_NEAR(axis.status().torque_demand, held, 1) << "no step to 0 and back";
}

TEST(CyclicTorque, TheTorqueIsLimitedBy6072h60E0hAnd60E1hAndBit12ShowsIt) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  axis.write("max_torque", 500);
  axis.write("negative_torque_limit_relative", 200);
  enable_cyclic_torque(axis);
  stream_torque(axis, 1'000);
  axis.step();
  EXPECT_EQ(axis.status().torque_demand, 500);
  EXPECT_FALSE(axis.follows_command());
  stream_torque(axis, -1'000);
  axis.step();
  EXPECT_EQ(axis.status().torque_demand, -200);
  EXPECT_FALSE(axis.follows_command());
  EXPECT_EQ(axis.read("target_torque"), -1'000);
  stream_torque(axis, -200);
  axis.step();
  EXPECT_TRUE(axis.follows_command());
}

TEST(CyclicTorque, TheSpeedIsBoundedBy607FhAndBit12ShowsIt) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(run_with_streamed(axis, sign * 1'000));
    EXPECT_LE(std::abs(axis.velocity()), 40'001);
    EXPECT_FALSE(axis.follows_command()) << "the speed limit holds the torque back";
    EXPECT_EQ(axis.demand(), axis.actual());
  }
}

TEST(CyclicTorque, QuickStopBrakesUnderPositionControl) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  ASSERT_NO_FATAL_FAILURE(run_with_streamed(axis, 1'000));
  axis.command(0x0002);
  EXPECT_FALSE(axis.follows_command());
  const std::int32_t first = axis.demand_velocity();
  axis.step(100);
  EXPECT_NEAR(axis.demand_velocity(), first - 100 * 100, 1) << "6085h";
  axis.step(500);
  EXPECT_EQ(axis.statusword(), 0x0617);
  axis.command(0x000F);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 0) << "after transition 16 a new target is needed";
  EXPECT_FALSE(axis.follows_command());
}

TEST(CyclicTorque, HaltTakesTheTorqueBackWith6087hAndEndsTheStream) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  axis.write("torque_slope", 8'000);  // 8 per mille per tick
  enable_cyclic_torque(axis);
  stream_torque(axis, 400);
  axis.step();
  axis.controlword(0x010F);
  for (int tick = 1; tick <= 50; ++tick) {
    stream_torque(axis, 400);
    ASSERT_EQ(axis.status().torque_demand, 400 - 8 * tick + 1) << tick;
    ASSERT_FALSE(axis.follows_command());
  }
  axis.step();
  EXPECT_EQ(axis.status().torque_demand, 0);
}

TEST(CyclicTorque, HaltOfAnAxisThatHasNoTorqueYetHoldsIt) {
  AxisUnderTest axis;
  enable_cyclic_torque(axis);
  axis.command(0x010F);
  axis.write("test_load_torque", 500);
  axis.step(2'000);
  EXPECT_NEAR(axis.actual(), 0, 1);
}

TEST(CyclicTorque, ALimitSwitchStopsWith6085hAndOnlyTheOtherDirectionIsLeft) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run_with_streamed(axis, 1'000));
  axis.write("test_positive_limit_input", 1);
  axis.step();
  const std::int32_t first = axis.demand_velocity();
  for (int tick = 0; tick < 100; ++tick) stream_torque(axis, 1'000);
  EXPECT_NEAR(axis.demand_velocity(), first - 100 * 100, 1);
  EXPECT_FALSE(axis.follows_command());
  axis.step(1'000);
  EXPECT_EQ(axis.velocity(), 0);
  stream_torque(axis, -100);
  axis.step(100);
  EXPECT_LT(axis.velocity(), 0) << "away from the switch";
}

TEST(CyclicTorque, DisableOperationTakesTheTorqueBackWith6087hFirst) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  axis.write("torque_slope", 8'000);
  enable_cyclic_torque(axis);
  stream_torque(axis, 400);
  axis.step();
  axis.controlword(0x0007);
  for (int tick = 1; tick <= 40; ++tick) {
    axis.step();
    ASSERT_EQ(axis.status().torque_demand, 400 - 8 * tick + 1) << tick;
    ASSERT_EQ(axis.state(), operation_enabled);
  }
  axis.step(20);
  EXPECT_EQ(axis.state(), switched_on);
}

TEST(CyclicTorque, TheOffset60B2hIsAddedAndActsByItself) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  enable_cyclic_torque(axis);
  axis.write("torque_offset", 100);
  axis.step(10);
  EXPECT_EQ(axis.status().torque_demand, 0) << "an offset begins no stream";
  stream_torque(axis, 200);
  axis.step();
  EXPECT_EQ(axis.status().torque_demand, 300);
  EXPECT_TRUE(axis.follows_command());
  axis.write("torque_offset", -500);
  axis.step(2);
  EXPECT_EQ(axis.status().torque_demand, -300);
  EXPECT_TRUE(axis.follows_command());
}

TEST(CyclicTorque, AppliesNoTorqueWithoutPower) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 10);
  stream_torque(axis, 500);
  axis.step(10);
  EXPECT_EQ(axis.status().torque_demand, 0);
  axis.command(0x000F);
  stream_torque(axis, 500);
  axis.step(10);
  EXPECT_GT(axis.velocity(), 0);
  axis.command(0x0000);
  EXPECT_EQ(axis.status().torque_demand, 0);
}

TEST(CyclicTorque, ABlockedAxisHasNoFollowingError) {
  AxisUnderTest axis;
  axis.write("following_error_window", 0);
  axis.write("following_error_time_out", 0);
  axis.write("test_blocked_load", 1);
  enable_cyclic_torque(axis);
  stream_torque(axis, 500);
  axis.step(1'000);
  EXPECT_EQ(axis.statusword(), 0x1237) << "bit 13 is reserved";
}

TEST(CyclicTorque, RunsAtEveryPeriod) {
  for (const std::int64_t period : {125, 1'000, 10'000}) {
    AxisUnderTest axis({}, microseconds{period});
    axis.write("test_blocked_load", 1);
    enable_cyclic_torque(axis);
    for (int i = 1; i <= 50; ++i) {
      stream_torque(axis, 8 * i);
      axis.step();
      ASSERT_EQ(axis.status().torque_demand, 8 * i);
      ASSERT_TRUE(axis.follows_command());
    }
  }
}

}  // namespace
}  // namespace vdrive
