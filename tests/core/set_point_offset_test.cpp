// SPDX-License-Identifier: Apache-2.0
// 60B0h, 60B1h, 60B2h: offsets of cyclic synchronous position and velocity mode. The tests of these
// modes cover the offset of torque mode and the sum of velocities.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <numbers>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

/// In `mode`, Operation enabled, at rest; the stream of `object` has begun with 0.
void begin_stream_of_zero(AxisUnderTest& axis, std::int64_t mode, const char* object) {
  axis.write("op_mode_cmd", mode);
  axis.command(0x000F);
  axis.write(object, 0);
  axis.step();
}

struct ModeOfOffset {
  std::int64_t mode;
  const char* object;  // the object that is streamed
};

/// Modes whose velocity loop uses 60B2h.
constexpr std::array<ModeOfOffset, 2> kModesWithTorqueOffset{
    {{8, "position_user_target_value"}, {9, "target_velocity"}}};

// ---- 60B0h --------------------------------------------------------------------------------------

TEST(PositionOffset, IsAddedToTheTargetAndActsByItself) {
  AxisUnderTest axis;
  begin_stream_of_zero(axis, 8, "position_user_target_value");
  axis.write("position_offset", -30);
  axis.write("position_user_target_value", 100);
  EXPECT_EQ(axis.step(), 0x1237);
  EXPECT_EQ(axis.demand(), 70);
  axis.write("position_offset", 50);
  EXPECT_EQ(axis.step(), 0x1237);
  EXPECT_EQ(axis.demand(), 150);
  EXPECT_EQ(axis.read("position_user_target_value"), 100);
}

TEST(PositionOffset, BeginsNoStream) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
  axis.write("position_offset", 100);
  axis.step(100);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.statusword(), 0x0237);
}

TEST(PositionOffset, IsReachedAfter60C2hAsAnyOtherSetPoint) {
  AxisUnderTest axis;
  axis.write("interpolation_time_period", 10);
  begin_stream_of_zero(axis, 8, "position_user_target_value");
  axis.write("position_offset", 100);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 10 * tick);
  }
}

TEST(PositionOffset, WrapsWithTheRegisterOfThePosition) {
  AxisConfiguration configuration;
  configuration.initial_position = 2'147'483'600;
  AxisUnderTest axis(configuration);
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
  axis.write("position_user_target_value", 2'147'483'600);
  axis.write("position_offset", 100);
  EXPECT_EQ(axis.step(), 0x1237);
  EXPECT_EQ(axis.demand(), -2'147'483'596) << "2147483700 less 2^32";
  EXPECT_EQ(axis.demand_velocity(), 100'000);
}

TEST(PositionOffset, ChangesNothingInOtherModes) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("position_offset", 5'000);
  axis.write("position_user_target_value", 1'000);
  axis.command(0x001F);
  axis.step(2'000);
  EXPECT_EQ(axis.demand(), 1'000);
}

// ---- 60B1h in cyclic position -------------------------------------------------------------------

// At rest the position loop cancels the offset: the position error times its gain of 2π·16 Hz is
// the offset, so the error is 1000 / 100.5 = 9.95. Friction may hold the axis a unit away from
// that.
TEST(VelocityOffset, IsAddedToWhatThePositionLoopAsksFor) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    begin_stream_of_zero(axis, 8, "position_user_target_value");
    axis.write("velocity_offset", sign * 1'000);
    axis.step(3'000);
    EXPECT_EQ(axis.demand(), 0);
    EXPECT_EQ(axis.demand_velocity(), 0) << "606Bh is the demand's own";
    EXPECT_NEAR(axis.actual(), sign * 1'000.0 / (2.0 * std::numbers::pi * 16.0), 2.0);
    EXPECT_EQ(axis.status().load_position_error_value, -axis.actual());
    axis.write("velocity_offset", 0);
    axis.step(3'000);
    EXPECT_NEAR(axis.actual(), 0, 1);
  }
}

TEST(VelocityOffset, KeepsTheDemandOnTheStream) {
  AxisUnderTest axis;
  begin_stream_of_zero(axis, 8, "position_user_target_value");
  axis.write("velocity_offset", -700);
  for (int i = 1; i <= 500; ++i) {
    axis.write("position_user_target_value", 20 * i);
    ASSERT_EQ(axis.step(), 0x1237);
    ASSERT_EQ(axis.demand(), 20 * i);
    ASSERT_EQ(axis.demand_velocity(), 20'000);
  }
}

TEST(VelocityOffset, ChangesNothingInOtherModes) {
  for (const std::int64_t mode : {1, 3, 7}) {
    AxisUnderTest axis;
    axis.write("op_mode_cmd", mode);
    axis.command(0x000F);
    axis.write("velocity_offset", 10'000);
    axis.step(500);
    EXPECT_EQ(axis.demand_velocity(), 0) << mode;
    EXPECT_EQ(axis.actual(), 0) << mode;
  }
}

// ---- 60B2h --------------------------------------------------------------------------------------

TEST(TorqueOffset, IsAddedToTheCommandOfTheVelocityLoopInTheSameTick) {
  for (const ModeOfOffset& row : kModesWithTorqueOffset) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);  // no speed, so the loops demand nothing
    begin_stream_of_zero(axis, row.mode, row.object);
    ASSERT_EQ(axis.status().torque_demand, 0);
    axis.write("torque_offset", 100);
    axis.step();
    EXPECT_EQ(axis.status().torque_demand, 100);
    axis.step(100);
    EXPECT_EQ(axis.status().torque_demand, 100) << "added once, not in each tick";
    axis.write("torque_offset", -250);
    axis.step();
    EXPECT_EQ(axis.status().torque_demand, -250);
    axis.write("torque_offset", 0);
    axis.step();
    EXPECT_EQ(axis.status().torque_demand, 0);
  }
}

/// @return the highest speed that a load of 0.6 N.m gives to an axis that holds its position.
std::int32_t highest_speed_under_load(const ModeOfOffset& row, std::int64_t torque_offset) {
  AxisUnderTest axis;
  begin_stream_of_zero(axis, row.mode, row.object);
  axis.write("test_load_torque", 600);
  axis.write("torque_offset", torque_offset);
  std::int32_t highest = 0;
  for (int tick = 0; tick < 200; ++tick) {
    axis.step();
    highest = std::max(highest, std::abs(axis.velocity()));
  }
  return highest;
}

// The load needs 200 per mille of 3 N.m: if the offset provides them, only the lag of the current
// loop remains.
TEST(TorqueOffset, TakesALoadThatTheMasterKnows) {
  for (const ModeOfOffset& row : kModesWithTorqueOffset) {
    EXPECT_LT(3 * highest_speed_under_load(row, -200), highest_speed_under_load(row, 0))
        << row.object;
  }
}

TEST(TorqueOffset, StaysInAQuickStop) {
  for (const ModeOfOffset& row : kModesWithTorqueOffset) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    axis.write("quick_stop_option_code", 6);
    begin_stream_of_zero(axis, row.mode, row.object);
    axis.write("torque_offset", 100);
    axis.step();
    axis.command(0x0002);
    EXPECT_EQ(axis.state(), quick_stop_active);
    EXPECT_EQ(axis.status().torque_demand, 100);
  }
}

TEST(TorqueOffset, EndsWithTheModeAndWithThePower) {
  for (const ModeOfOffset& row : kModesWithTorqueOffset) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    begin_stream_of_zero(axis, row.mode, row.object);
    axis.write("torque_offset", 100);
    axis.step(10);
    axis.write("op_mode_cmd", 1);
    axis.step();
    EXPECT_EQ(axis.read("op_mode_actual"), 1);
    EXPECT_EQ(axis.status().torque_demand, 0);
    axis.write("op_mode_cmd", row.mode);
    axis.step();
    EXPECT_EQ(axis.status().torque_demand, 100);
    axis.command(0x0000);
    EXPECT_EQ(axis.status().torque_demand, 0);
    axis.command(0x000F);
    EXPECT_EQ(axis.status().torque_demand, 100) << "once, not on top of what was there";
  }
}

TEST(TorqueOffset, IsHandedOverToTorqueModeAndBack) {
  AxisUnderTest axis;
  axis.write("test_blocked_load", 1);
  begin_stream_of_zero(axis, 9, "target_velocity");
  axis.write("torque_offset", 100);
  axis.step(10);
  axis.write("op_mode_cmd", 10);
  axis.write("target_torque", 50);
  axis.step(2);
  axis.write("target_torque", 50);
  axis.step(2);
  EXPECT_EQ(axis.status().torque_demand, 150) << "6071h and 60B2h";
}

TEST(TorqueOffset, IsWithinTheTorqueLimits) {
  for (const ModeOfOffset& row : kModesWithTorqueOffset) {
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    axis.write("max_torque", 300);
    begin_stream_of_zero(axis, row.mode, row.object);
    axis.write("torque_offset", 1'000);
    axis.step(10);
    EXPECT_EQ(axis.status().torque_demand, 300) << row.object;
  }
}

TEST(TorqueOffset, ChangesNothingInOtherModes) {
  for (const std::int64_t mode : {0, 1, 2, 3, 4, 6, 7}) {
    AxisUnderTest axis;
    axis.write("op_mode_cmd", mode);
    axis.command(0x000F);
    axis.write("torque_offset", 500);
    axis.step(100);
    EXPECT_EQ(axis.status().torque_demand, 0) << mode;
    EXPECT_EQ(axis.actual(), 0) << mode;
  }
}

TEST(Offsets, AreForgottenWithThePowerSupply) {
  AxisUnderTest axis;
  for (const char* const object : {"position_offset", "velocity_offset", "torque_offset"}) {
    axis.write(object, 7);
  }
  axis.axis().power_cycle();
  for (const char* const object : {"position_offset", "velocity_offset", "torque_offset"}) {
    EXPECT_EQ(axis.read(object), 0) << object;
  }
}

}  // namespace
}  // namespace vdrive
