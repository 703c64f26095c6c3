// SPDX-License-Identifier: Apache-2.0
// Cyclic synchronous velocity mode (6060h = 9).
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using enum PowerState;

/// Cyclic velocity, Operation enabled, at rest.
void enable_cyclic_velocity(AxisUnderTest& axis) {
  axis.write("op_mode_cmd", 9);
  axis.command(0x000F);
}

/// One tick of a stream of velocities.
void stream_velocity(AxisUnderTest& axis, std::int32_t velocity) {
  axis.write("target_velocity", velocity);
  axis.step();
}

TEST(CyclicVelocity, TheDemandIsTheTargetAtTheEndOfItsTick) {
  AxisUnderTest axis;
  enable_cyclic_velocity(axis);
  for (int i = 0; i < 500; ++i) {
    const std::int32_t velocity = (i * 37) % 12'000 - 4'000;
    stream_velocity(axis, velocity);
    ASSERT_EQ(axis.demand_velocity(), velocity);
    ASSERT_EQ(axis.statusword(), 0x1237) << "bits 10 and 13 are reserved";
    ASSERT_EQ(axis.demand(), axis.actual()) << "the position loop is open";
  }
}

TEST(CyclicVelocity, TheAxisRunsAtTheVelocity) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    enable_cyclic_velocity(axis);
    stream_velocity(axis, sign * 40'000);
    axis.step(1'000);
    EXPECT_NEAR(axis.velocity(), sign * 40'000, 40);
    const std::int32_t start = axis.actual();
    axis.step(1'000);
    EXPECT_NEAR(axis.actual() - start, sign * 40'000, 40);
  }
}

// With a blocked load the torque of the velocity loop shows its demand. 6074h is the command of the
// last of the 8 sub-steps of a tick, which samples the demand at 7/8 of its way. The loop of 100 Hz
// (gain 200π/s, integrator 0.1·(200π)²/s² · 125 µs = 4.935/s per sub-step) commands this
// acceleration per unit of velocity:
//   first tick: 628.3·7/8 + 4.935·(0 + 1 + ... + 6)/8 + 1/1 ms fed forward = 1562.7/s
//   second tick: 628.3 + 4.935·(28/8 + 7) = 680.1/s, and nothing fed forward.
// 1000 UU/s at 1/s are 2π·1000/4096 rad/s², which are 0.30680 per mille with 6e-4 kg.m² and 3 N.m:
// 479.4 and 208.7. A step at the beginning of the tick would command 628.3 + 4.935·7 = 662.8/s
// without the part that is fed forward.
TEST(CyclicVelocity, TheVelocityRampsWithinItsTick) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  enable_cyclic_velocity(axis);
  stream_velocity(axis, 1'000);
  EXPECT_NEAR(axis.status().torque_demand, 479, 1);
  stream_velocity(axis, 1'000);
  EXPECT_NEAR(axis.status().torque_demand, 209, 1);
}

TEST(CyclicVelocity, AnOldTargetMovesNothing) {
  AxisUnderTest axis;
  axis.write("target_velocity", 50'000);
  enable_cyclic_velocity(axis);
  EXPECT_EQ(axis.statusword(), 0x0237) << "no command is followed yet";
  axis.step(200);
  EXPECT_EQ(axis.actual(), 0);
  stream_velocity(axis, 50'000);  // the same value, but the first one that counts
  EXPECT_EQ(axis.demand_velocity(), 50'000);
  EXPECT_TRUE(axis.follows_command());
}

TEST(CyclicVelocity, UntilTheFirstTargetTheAxisHoldsItsPosition) {
  AxisUnderTest axis;
  enable_cyclic_velocity(axis);
  axis.write("test_load_torque", 500);
  axis.step(2'000);
  EXPECT_NEAR(axis.actual(), 0, 1);
}

TEST(CyclicVelocity, EnablingAgainNeedsANewTarget) {
  AxisUnderTest axis;
  enable_cyclic_velocity(axis);
  stream_velocity(axis, 10'000);
  axis.step(100);
  axis.command(0x0000);
  axis.step(2'000);
  axis.command(0x000F);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_FALSE(axis.follows_command());
}

TEST(CyclicVelocity, AMissingUpdateHoldsTheVelocity) {
  AxisUnderTest axis;
  enable_cyclic_velocity(axis);
  stream_velocity(axis, 20'000);
  for (int tick = 0; tick < 1'000; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand_velocity(), 20'000);
    ASSERT_TRUE(axis.follows_command());
  }
}

TEST(CyclicVelocity, TheSpeedIsCappedBy607FhAndBit12ShowsIt) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("app_speed_limit", 50'000);
    enable_cyclic_velocity(axis);
    stream_velocity(axis, sign * 60'000);
    EXPECT_EQ(axis.demand_velocity(), sign * 50'000);
    EXPECT_FALSE(axis.follows_command());
    EXPECT_EQ(axis.read("target_velocity"), sign * 60'000);
    stream_velocity(axis, sign * 50'000);
    EXPECT_EQ(axis.demand_velocity(), sign * 50'000);
    EXPECT_TRUE(axis.follows_command());
  }
}

TEST(CyclicVelocity, TheVelocityChangesInEqualPartsOver60C2h) {
  AxisUnderTest axis;
  axis.write("interpolation_time_period", 10);
  enable_cyclic_velocity(axis);
  axis.write("target_velocity", 10'000);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand_velocity(), 1'000 * tick);
    ASSERT_TRUE(axis.follows_command()) << "on its way";
  }
  axis.step();
  EXPECT_EQ(axis.demand_velocity(), 10'000);
  axis.write("target_velocity", 0);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand_velocity(), 10'000 - 1'000 * tick);
  }
}

TEST(CyclicVelocity, AVelocityThatIsWrittenAgainDoesNotDelayItsWay) {
  AxisUnderTest axis;
  axis.write("interpolation_time_period", 10);
  enable_cyclic_velocity(axis);
  for (int tick = 1; tick <= 10; ++tick) {
    stream_velocity(axis, 10'000);
    ASSERT_EQ(axis.demand_velocity(), 1'000 * tick);
  }
}

TEST(CyclicVelocity, QuickStopBrakesFromTheSpeedOfTheStream) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 100'000);
  axis.write("quick_stop_option_code", 6);
  enable_cyclic_velocity(axis);
  stream_velocity(axis, 30'000);
  axis.step(200);
  axis.controlword(0x0002);
  for (int tick = 1; tick <= 300; ++tick) {
    stream_velocity(axis, 30'000);
    ASSERT_NEAR(axis.demand_velocity(), 30'000 - 100 * tick, 1);
    ASSERT_FALSE(axis.follows_command());
  }
  axis.step(300);
  EXPECT_EQ(axis.statusword(), 0x0617);
  axis.command(0x000F);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 0) << "after transition 16 a new target is needed";
  stream_velocity(axis, 5'000);
  EXPECT_EQ(axis.demand_velocity(), 5'000);
}

TEST(CyclicVelocity, HaltBrakesAndEndsTheStream) {
  AxisUnderTest axis;
  axis.write("profile_dec", 100'000);
  enable_cyclic_velocity(axis);
  stream_velocity(axis, 30'000);
  axis.step(200);
  axis.controlword(0x010F);
  for (int tick = 1; tick <= 300; ++tick) {
    stream_velocity(axis, 30'000);
    ASSERT_NEAR(axis.demand_velocity(), 30'000 - 100 * tick, 1);
    ASSERT_FALSE(axis.follows_command());
  }
  axis.command(0x000F);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 0) << "what was written under halt does not start";
  stream_velocity(axis, 5'000);
  EXPECT_EQ(axis.demand_velocity(), 5'000);
}

TEST(CyclicVelocity, ALimitSwitchStopsWith6085hAndOnlyTheOtherDirectionIsLeft) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 100'000);
  enable_cyclic_velocity(axis);
  stream_velocity(axis, 30'000);
  axis.step(200);
  axis.write("test_positive_limit_input", 1);
  for (int tick = 1; tick <= 300; ++tick) {
    stream_velocity(axis, 30'000);
    ASSERT_NEAR(axis.demand_velocity(), 30'000 - 100 * tick, 1);
    ASSERT_FALSE(axis.follows_command());
  }
  stream_velocity(axis, 100);
  EXPECT_EQ(axis.demand_velocity(), 0);
  stream_velocity(axis, -100);
  EXPECT_EQ(axis.demand_velocity(), -100);
  EXPECT_TRUE(axis.follows_command());
  axis.write("test_positive_limit_input", 0);
  stream_velocity(axis, 100);
  EXPECT_EQ(axis.demand_velocity(), 100);
}

TEST(CyclicVelocity, ABlockedAxisHasNoFollowingError) {
  AxisUnderTest axis;
  axis.write("following_error_window", 10);
  axis.write("following_error_time_out", 0);
  axis.write("test_blocked_load", 1);
  enable_cyclic_velocity(axis);
  stream_velocity(axis, 10'000);
  axis.step(1'000);
  EXPECT_EQ(axis.statusword(), 0x1237);
}

TEST(CyclicVelocity, TheOffset60B1hIsAddedAndActsByItself) {
  AxisUnderTest axis;
  enable_cyclic_velocity(axis);
  axis.write("velocity_offset", 500);
  axis.step(10);
  EXPECT_EQ(axis.demand_velocity(), 0) << "an offset begins no stream";
  stream_velocity(axis, 1'000);
  EXPECT_EQ(axis.demand_velocity(), 1'500);
  EXPECT_TRUE(axis.follows_command());
  axis.write("velocity_offset", -1'200);
  axis.step();
  EXPECT_EQ(axis.demand_velocity(), -200);
  EXPECT_TRUE(axis.follows_command());
}

TEST(CyclicVelocity, TheSumWithTheOffsetEndsAtTheEndOfTheRegister) {
  AxisUnderTest axis;
  enable_cyclic_velocity(axis);
  axis.write("velocity_offset", std::numeric_limits<std::int32_t>::max());
  stream_velocity(axis, std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(axis.demand_velocity(), 136'533) << "607Fh, and not a sum that has wrapped";
  EXPECT_FALSE(axis.follows_command());
}

TEST(CyclicVelocity, RunsAtEveryPeriod) {
  for (const std::int64_t period : {125, 1'000, 10'000}) {
    AxisUnderTest axis({}, microseconds{period});
    enable_cyclic_velocity(axis);
    for (int i = 1; i <= 200; ++i) {
      stream_velocity(axis, 30 * i);
      ASSERT_EQ(axis.demand_velocity(), 30 * i);
    }
    axis.step_for(microseconds{400'000});
    EXPECT_NEAR(axis.velocity(), 6'000, 20);
  }
}

}  // namespace
}  // namespace vdrive
