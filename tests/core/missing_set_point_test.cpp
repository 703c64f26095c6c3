// SPDX-License-Identifier: Apache-2.0
// 5E12h: the reaction of an axis whose master omits set-points in the modes 7 to 10.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

/// A mode that gets a set-point every 10 ms.
struct StreamedMode {
  std::int64_t mode;
  const char* object;  // the object that is streamed
  std::uint16_t word;  // the controlword that lets the axis follow it
};

constexpr std::array<StreamedMode, 4> kStreamedModes{{
    {7, "interpolation_data_record", 0x001F},
    {8, "position_user_target_value", 0x000F},
    {9, "target_velocity", 0x000F},
    {10, "target_torque", 0x000F},
}};

void enable_streamed(AxisUnderTest& axis, const StreamedMode& row) {
  axis.write("interpolation_time_period", 10);
  axis.write("op_mode_cmd", row.mode);
  axis.command(row.word);
}

/// Five set-points, each 100 more than the last: positions at 10 UU per tick.
void stream_five(AxisUnderTest& axis, const StreamedMode& row) {
  for (int sync = 1; sync <= 5; ++sync) {
    axis.write(row.object, 100 * sync);
    axis.step(10);
  }
}

TEST(MissingSetPoints, AreHeldAndNoFaultByDefault) {
  for (const StreamedMode& row : kStreamedModes) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    EXPECT_EQ(axis.read("missing_set_points_extrapolated"), 0);
    EXPECT_EQ(axis.read("missing_set_points_until_fault"), 0);
    enable_streamed(axis, row);
    axis.write(row.object, 0);
    axis.step(3'000);
    EXPECT_EQ(axis.state(), operation_enabled);
    EXPECT_TRUE(axis.follows_command()) << "the drive follows the last command";
  }
}

TEST(MissingSetPoints, ArePositionsThatTheDriveReplacesByGoingOn) {
  for (const StreamedMode& row : {kStreamedModes[0], kStreamedModes[1]}) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("missing_set_points_extrapolated", 2);
    enable_streamed(axis, row);
    stream_five(axis, row);
    ASSERT_EQ(axis.demand(), 500);
    for (int tick = 1; tick <= 20; ++tick) {  // twice 10 ms
      axis.step();
      ASSERT_EQ(axis.demand(), 500 + 10 * tick);
      ASSERT_EQ(axis.demand_velocity(), 10'000);
    }
    axis.step(100);
    EXPECT_EQ(axis.demand(), 700) << "the third one is not replaced";
    EXPECT_EQ(axis.demand_velocity(), 0);
    EXPECT_EQ(axis.state(), operation_enabled);
  }
}

TEST(MissingSetPoints, ThatAreReplacedAreNoCommandThatIsFollowed) {
  AxisUnderTest axis;
  axis.write("missing_set_points_extrapolated", 2);
  enable_streamed(axis, kStreamedModes[1]);
  stream_five(axis, kStreamedModes[1]);
  EXPECT_TRUE(axis.follows_command());
  for (int tick = 0; tick < 50; ++tick) {
    axis.step();
    ASSERT_FALSE(axis.follows_command()) << tick;
  }
}

// Bit 12 of mode 7 shows that bit 4 enables the interpolation, not where the demand comes from.
TEST(MissingSetPoints, ThatAreReplacedLeaveTheInterpolationActive) {
  AxisUnderTest axis;
  axis.write("missing_set_points_extrapolated", 2);
  enable_streamed(axis, kStreamedModes[0]);
  stream_five(axis, kStreamedModes[0]);
  for (int tick = 1; tick <= 50; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 500 + 10 * std::min(tick, 20));
    ASSERT_TRUE(axis.follows_command()) << tick;
  }
}

// The speed of the demand ends with the last replaced set-point, without a ramp.
TEST(MissingSetPoints, ThatAreReplacedNoLongerStopTheDemandInOneTick) {
  for (const StreamedMode& row : {kStreamedModes[0], kStreamedModes[1]}) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("missing_set_points_extrapolated", 2);
    enable_streamed(axis, row);
    stream_five(axis, row);
    axis.step(20);
    ASSERT_EQ(axis.demand_velocity(), 10'000);
    axis.step();
    EXPECT_EQ(axis.demand_velocity(), 0);
    EXPECT_EQ(axis.demand(), 700);
  }
}

// The demand returns from 700 to 500, which the master still commands, by 20 per tick.
TEST(MissingSetPoints, AreOverWithTheNextOneAlsoOfTheSameValue) {
  AxisUnderTest axis;
  axis.write("missing_set_points_extrapolated", 2);
  enable_streamed(axis, kStreamedModes[1]);
  stream_five(axis, kStreamedModes[1]);
  axis.step(50);
  ASSERT_EQ(axis.demand(), 700);
  axis.write("position_user_target_value", 500);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 700 - 20 * tick);
    ASSERT_TRUE(axis.follows_command());
  }
}

TEST(MissingSetPoints, ALateOneContinuesFromTheExtrapolatedPosition) {
  AxisUnderTest axis;
  axis.write("missing_set_points_extrapolated", 2);
  enable_streamed(axis, kStreamedModes[1]);
  stream_five(axis, kStreamedModes[1]);
  axis.step(3);
  ASSERT_EQ(axis.demand(), 530);
  axis.write("position_user_target_value", 630);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 530 + 10 * tick) << "no step";
    ASSERT_EQ(axis.demand_velocity(), 10'000);
  }
}

TEST(MissingSetPoints, AreNotReplacedBeyondASoftwareLimit) {
  AxisUnderTest axis;
  axis.write("app_position_limit_switch", 1);
  axis.write("user_position_lower_limit", -1'000);
  axis.write("user_position_upper_limit", 535);
  axis.write("missing_set_points_extrapolated", 255);
  enable_streamed(axis, kStreamedModes[1]);
  stream_five(axis, kStreamedModes[1]);
  axis.step(3);
  ASSERT_EQ(axis.demand(), 530);
  axis.step(200);
  EXPECT_EQ(axis.demand(), 535);
}

TEST(MissingSetPoints, AreNotReplacedBeyondALimitSwitch) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 1'000'000);  // 1000 UU/s per tick: 10 ticks, 50 UU
  axis.write("missing_set_points_extrapolated", 255);
  enable_streamed(axis, kStreamedModes[1]);
  stream_five(axis, kStreamedModes[1]);
  axis.step(3);
  axis.write("test_positive_limit_input", 1);
  axis.step(200);
  EXPECT_EQ(axis.demand(), 580);
}

TEST(MissingSetPoints, AreHeldWhereTheyAreVelocitiesOrTorques) {
  for (const StreamedMode& row : {kStreamedModes[2], kStreamedModes[3]}) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("test_blocked_load", 1);
    axis.write("missing_set_points_extrapolated", 2);
    enable_streamed(axis, row);
    stream_five(axis, row);
    axis.step(100);
    EXPECT_EQ(row.mode == 9 ? axis.demand_velocity() : axis.status().torque_demand, 500);
    EXPECT_TRUE(axis.follows_command());
  }
}

// The last set-point was written ten ticks before the first tick below. The first missing one is
// due in that tick, the second ten ticks later, the third in the 21st tick.
TEST(MissingSetPoints, AreFault8700hWhereSoManyInARowDoNotCome) {
  for (const StreamedMode& row : kStreamedModes) {
    for (const std::int64_t extrapolated : {0, 1}) {
      SCOPED_TRACE(row.object);
      AxisUnderTest axis;
      axis.write("missing_set_points_extrapolated", extrapolated);
      axis.write("missing_set_points_until_fault", 3);
      enable_streamed(axis, row);
      stream_five(axis, row);
      EXPECT_EQ(axis.step_until(
                    [&axis] {
                      return axis.read("error_code") == 0x8700;
                    },
                    100),
                21U);
      EXPECT_EQ(axis.read("error_register"), 0x21);
      axis.step(2'000);
      EXPECT_EQ(axis.statusword(), 0x0218);
      axis.command(0x0080);
      EXPECT_EQ(axis.state(), switch_on_disabled) << "a cause that is over: the reset succeeds";
    }
  }
}

TEST(MissingSetPoints, TheFaultBrakesBy605Eh) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 100'000);
  axis.write("missing_set_points_until_fault", 1);
  enable_streamed(axis, kStreamedModes[2]);
  axis.write("target_velocity", 30'000);
  axis.step(10);
  ASSERT_EQ(axis.demand_velocity(), 30'000);
  for (int tick = 1; tick <= 299; ++tick) {
    axis.step();
    ASSERT_NEAR(axis.demand_velocity(), 30'000 - 100 * tick, 1);
    ASSERT_EQ(axis.state(), fault_reaction_active);
  }
}

TEST(MissingSetPoints, AMasterThatRepeatsItsSetPointMissesNone) {
  for (const StreamedMode& row : kStreamedModes) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("missing_set_points_extrapolated", 1);
    axis.write("missing_set_points_until_fault", 1);
    enable_streamed(axis, row);
    for (int sync = 0; sync < 100; ++sync) {
      axis.write(row.object, 0);
      axis.step(10);
    }
    EXPECT_EQ(axis.state(), operation_enabled);
  }
}

TEST(MissingSetPoints, CountFromTheFirstOneThatIsStreamed) {
  for (const StreamedMode& row : kStreamedModes) {
    SCOPED_TRACE(row.object);
    AxisUnderTest axis;
    axis.write("missing_set_points_until_fault", 1);
    enable_streamed(axis, row);
    axis.step(1'000);
    EXPECT_EQ(axis.state(), operation_enabled) << "nothing was streamed yet";
  }
}

TEST(MissingSetPoints, AnOffsetIsNone) {
  AxisUnderTest axis;
  axis.write("missing_set_points_until_fault", 1);
  enable_streamed(axis, kStreamedModes[1]);
  axis.write("position_user_target_value", 0);
  for (int tick = 0; tick < 50; ++tick) {
    axis.write("position_offset", tick);
    axis.step();
  }
  EXPECT_EQ(axis.read("error_code"), 0x8700);
}

TEST(MissingSetPoints, WithoutA60C2hAreDueInEachTick) {
  AxisUnderTest axis;
  axis.write("missing_set_points_until_fault", 2);
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
  for (int i = 1; i <= 50; ++i) {
    axis.write("position_user_target_value", i);
    axis.step();
  }
  axis.step();
  EXPECT_EQ(axis.read("error_code"), 0) << "one is missing";
  axis.step();
  EXPECT_EQ(axis.read("error_code"), 0x8700);
}

TEST(MissingSetPoints, ATickThatFollowsThemAllIsTheSameWithAndWithoutTheirSettings) {
  const auto follow = [](bool has_settings) {
    AxisUnderTest axis;
    if (has_settings) {
      axis.write("missing_set_points_extrapolated", 3);
      axis.write("missing_set_points_until_fault", 5);
    }
    enable_streamed(axis, kStreamedModes[1]);
    stream_five(axis, kStreamedModes[1]);
    return axis.status();
  };
  const AxisStatus with = follow(true);
  const AxisStatus without = follow(false);
  EXPECT_EQ(with.position_demand_value, without.position_demand_value);
  EXPECT_EQ(with.load_position_actual_value, without.load_position_actual_value);
  EXPECT_EQ(with.torque_demand, without.torque_demand);
  EXPECT_EQ(with.ds402_statusword, without.ds402_statusword);
}

}  // namespace
}  // namespace vdrive
