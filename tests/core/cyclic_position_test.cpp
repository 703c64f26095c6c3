// SPDX-License-Identifier: Apache-2.0
// Cyclic synchronous position mode (6060h = 8); also, that the mode of an axis does not change the
// bits of its neighbours.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <string_view>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using enum PowerState;

constexpr std::uint16_t kFollows = 0x1000;  // bit 12

/// Cyclic position, Operation enabled, at rest.
void enable_cyclic_position(AxisUnderTest& axis) {
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
}

/// One tick of a stream.
void stream(AxisUnderTest& axis, std::int32_t position) {
  axis.write("position_user_target_value", position);
  axis.step();
}

bool follows(const AxisUnderTest& axis) {
  return (axis.statusword() & kFollows) != 0;
}

/// Streams at constant speed [UU per tick], from 0.
/// @return the last position
std::int32_t stream_at(AxisUnderTest& axis, std::int32_t speed, int ticks) {
  for (int i = 1; i <= ticks; ++i) stream(axis, speed * i);
  return speed * ticks;
}

TEST(CyclicPosition, TheDemandIsTheTargetInTheSameTick) {
  AxisUnderTest axis;
  enable_cyclic_position(axis);
  std::int32_t position = 0;
  for (int i = 0; i < 500; ++i) {
    const std::int32_t step = (i * 37) % 120 - 40;
    position += step;
    stream(axis, position);
    ASSERT_EQ(axis.demand(), position);
    ASSERT_EQ(axis.demand_velocity(), step * 1'000);
    ASSERT_TRUE(follows(axis));
  }
}

TEST(CyclicPosition, AnOldTargetCausesNoJump) {
  AxisUnderTest axis;
  axis.write("position_user_target_value", 50'000);
  enable_cyclic_position(axis);
  EXPECT_EQ(axis.statusword(), 0x0237) << "bit 12: no command is followed yet";
  axis.step(200);
  EXPECT_EQ(axis.actual(), 0);
  EXPECT_FALSE(follows(axis));
  stream(axis, 10);
  EXPECT_EQ(axis.demand(), 10);
  EXPECT_EQ(axis.statusword(), 0x1237);
}

TEST(CyclicPosition, EnteringTheModeNeedsANewTarget) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("position_user_target_value", 2'000);
  axis.command(0x001F);
  axis.step(1'000);
  axis.write("position_user_target_value", 9'000);
  axis.write("op_mode_cmd", 8);
  axis.step(100);
  EXPECT_EQ(axis.read("op_mode_actual"), 8);
  EXPECT_EQ(axis.demand(), 2'000);
  stream(axis, 2'050);
  EXPECT_EQ(axis.demand(), 2'050);
}

TEST(CyclicPosition, EnablingAgainNeedsANewTarget) {
  AxisUnderTest axis;
  enable_cyclic_position(axis);
  stream_at(axis, 10, 100);
  axis.step(200);
  axis.command(0x0000);
  axis.write("position_user_target_value", 40'000);
  axis.command(0x000F);
  axis.step(100);
  EXPECT_NEAR(axis.demand(), 1'000, 2);
  EXPECT_FALSE(follows(axis));
  stream(axis, 1'010);
  EXPECT_EQ(axis.demand(), 1'010);
}

TEST(CyclicPosition, ATargetFromBeforeAnInterruptionIsForgotten) {
  for (const bool quick_stop : {false, true}) {
    AxisUnderTest axis;
    axis.write("quick_stop_option_code", 6);
    enable_cyclic_position(axis);
    const std::int32_t last = stream_at(axis, 40, 200);
    axis.command(quick_stop ? 0x0002 : 0x0000);  // brakes or coasts beyond the last target
    axis.step(2'000);
    const std::int32_t rest = axis.actual();
    ASSERT_GT(rest, last + 200);
    axis.command(0x000F);
    axis.step(200);
    EXPECT_NEAR(axis.actual(), rest, 1);
    EXPECT_FALSE(follows(axis));
  }
}

TEST(CyclicPosition, AMissingUpdateHoldsTheTarget) {
  AxisUnderTest axis;
  enable_cyclic_position(axis);
  stream_at(axis, 20, 50);
  axis.step(10);
  EXPECT_EQ(axis.demand(), 1'000);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_TRUE(follows(axis));
  axis.step(300);
  EXPECT_EQ(axis.actual(), 1'000);
  stream(axis, 1'020);
  EXPECT_EQ(axis.demand(), 1'020);
}

TEST(CyclicPosition, TheSpeedIsCappedBy607FhAndBit12ShowsIt) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("app_speed_limit", 50'000);
    enable_cyclic_position(axis);
    axis.write("position_user_target_value", sign * 1'020);
    for (int tick = 1; tick <= 20; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), sign * 50 * tick);
      ASSERT_EQ(axis.demand_velocity(), sign * 50'000);
      ASSERT_FALSE(follows(axis));
    }
    axis.step();
    EXPECT_EQ(axis.demand(), sign * 1'020);
    EXPECT_TRUE(follows(axis));
  }
}

TEST(CyclicPosition, AStreamTakesTheShortWayAcrossTheEndsOfTheRegister) {
  constexpr std::int32_t kHighest = std::numeric_limits<std::int32_t>::max();
  for (const bool up : {true, false}) {
    AxisConfiguration configuration;
    configuration.initial_position = up ? kHighest - 500 : -kHighest + 500;
    AxisUnderTest axis(configuration);
    enable_cyclic_position(axis);
    std::uint32_t position = static_cast<std::uint32_t>(configuration.initial_position);
    for (int i = 0; i < 100; ++i) {
      position += up ? 15U : -15U;
      stream(axis, static_cast<std::int32_t>(position));
      ASSERT_EQ(axis.demand(), static_cast<std::int32_t>(position));
      ASSERT_EQ(axis.demand_velocity(), up ? 15'000 : -15'000);
      ASSERT_TRUE(follows(axis));
    }
    axis.step(300);
    EXPECT_EQ(axis.actual(), static_cast<std::int32_t>(position));
    EXPECT_EQ(axis.state(), operation_enabled);
  }
}

TEST(CyclicPosition, StopsAtTheSoftwareLimitsAndBit12ShowsIt) {
  AxisUnderTest axis;
  axis.write("app_position_limit_switch", 1);
  axis.write("user_position_lower_limit", -100);
  axis.write("user_position_upper_limit", 200);
  enable_cyclic_position(axis);
  for (const std::int32_t way : {30, -30}) {
    const std::int32_t limit = way > 0 ? 200 : -100;
    std::int32_t position = 0;
    stream(axis, 0);
    for (int i = 0; i < 20; ++i) {
      position += way;
      stream(axis, position);
      const bool beyond = way > 0 ? position > limit : position < limit;
      ASSERT_EQ(axis.demand(), beyond ? limit : position);
      ASSERT_EQ(follows(axis), !beyond) << position;
      ASSERT_EQ(axis.read("position_user_target_value"), position);
    }
    EXPECT_TRUE(axis.limit_active());
    stream(axis, limit / 2);
    axis.step(50);
    EXPECT_EQ(axis.demand(), limit / 2);
  }
}

TEST(CyclicPosition, SoftwareLimitsPreventAMoveAcrossTheEndsOfTheRegister) {
  AxisConfiguration configuration;
  configuration.initial_position = 2'000'000'000;
  AxisUnderTest axis(configuration);
  axis.write("app_position_limit_switch", 1);
  axis.write("user_position_lower_limit", -2'100'000'000);
  axis.write("user_position_upper_limit", 2'100'000'000);
  enable_cyclic_position(axis);
  stream(axis, -2'000'000'000);
  EXPECT_LT(axis.demand_velocity(), 0) << "the short way leads through the limits";
  axis.step(100);
  EXPECT_LT(axis.demand(), 2'000'000'000);
}

TEST(CyclicPosition, HaltIsIgnored) {
  AxisUnderTest axis;
  enable_cyclic_position(axis);
  axis.controlword(0x010F);
  for (int i = 1; i <= 100; ++i) {
    stream(axis, 20 * i);
    ASSERT_EQ(axis.demand(), 20 * i);
    ASSERT_TRUE(follows(axis));
  }
}

TEST(CyclicPosition, QuickStopBrakesFromTheSpeedOfTheStream) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 100'000);
  axis.write("quick_stop_option_code", 6);
  enable_cyclic_position(axis);
  const std::int32_t last = stream_at(axis, 30, 100);
  axis.controlword(0x0002);
  for (int tick = 1; tick <= 300; ++tick) {
    stream(axis, last + 30 * tick);
    ASSERT_NEAR(axis.demand_velocity(), 30'000 - 100 * tick, 1);
    ASSERT_FALSE(follows(axis));
  }
  // 30000²/(2·100000) = 4500
  EXPECT_EQ(axis.demand(), last + 4'500);
  axis.step(300);
  axis.command(0x000F);
  axis.step(100);
  EXPECT_EQ(axis.demand(), last + 4'500) << "after transition 16 a new target is needed";
  stream(axis, last + 4'550);
  EXPECT_EQ(axis.demand(), last + 4'550);
}

TEST(CyclicPosition, ABlockedAxisHasAFollowingError) {
  AxisUnderTest axis;
  enable_cyclic_position(axis);
  axis.write("test_blocked_load", 1);
  stream_at(axis, 100, 400);  // 6065h = 20480 is exceeded after 205 ticks; fault 20 ms later
  axis.step(10);
  EXPECT_EQ(axis.statusword(), 0x2218);
  EXPECT_EQ(axis.read("error_code"), 0x8611);
}

TEST(CyclicPosition, ALimitSwitchStopsWith6085hAndOnlyANewTargetRestartsMotion) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 100'000);
  enable_cyclic_position(axis);
  const std::int32_t last = stream_at(axis, 30, 100);
  axis.write("test_positive_limit_input", 1);
  for (int tick = 1; tick <= 300; ++tick) {
    stream(axis, last + 30 * tick);
    ASSERT_NEAR(axis.demand_velocity(), 30'000 - 100 * tick, 1);
    ASSERT_FALSE(follows(axis));
  }
  const std::int32_t rest = axis.demand();
  axis.write("test_positive_limit_input", 0);
  axis.step(100);
  EXPECT_EQ(axis.demand(), rest) << "nothing resumes when the switch opens";
  stream(axis, rest + 20);
  EXPECT_EQ(axis.demand(), rest + 20);
  axis.write("test_positive_limit_input", 1);
  stream(axis, rest - 10);
  axis.step(300);
  EXPECT_EQ(axis.demand(), rest - 10) << "away from the switch";
}

TEST(CyclicPosition, AModeChangeWhileStreamingBrakesWith6084h) {
  for (const std::int64_t mode : {0, 1, 2, 3, 4, 6, 7, 9, 10}) {
    SCOPED_TRACE(mode);
    AxisUnderTest axis;
    axis.write("profile_dec", 100'000);
    enable_cyclic_position(axis);
    const std::int32_t last = stream_at(axis, 30, 100);
    axis.write("op_mode_cmd", mode);
    for (int tick = 1; tick <= 299; ++tick) {
      stream(axis, last + 30 * tick);
      ASSERT_NEAR(axis.demand_velocity(), 30'000 - 100 * tick, 1);
      ASSERT_EQ(axis.read("op_mode_actual"), 8);
    }
    axis.step(100);
    EXPECT_EQ(axis.read("op_mode_actual"), mode);
    EXPECT_NEAR(axis.actual(), last + 4'500, mode == 4 ? 20 : 2);
  }
}

TEST(CyclicPosition, AStreamedSineIsFollowedWithinTheLagOfTheLoops) {
  // Speed is fed forward, acceleration is not: with its gain of 2π·100 Hz the velocity loop needs a
  // speed error of a/628, for which the position loop, with its gain of 2π·16 Hz, needs
  // a/(628·100.5). Coulomb friction, 0.05 N.m on 6e-4 kg.m2 = 54325 UU/s², changes its sign at the
  // turning points.
  constexpr double kAmplitude = 5'000.0;
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  const double acceleration = kAmplitude * kTwoPi * kTwoPi;  // 1 Hz
  const double friction = 0.05 / 6.0e-4 * 4096.0 / kTwoPi;
  const double bound =
      (acceleration + 2.0 * friction) / (kTwoPi * 100.0 * kTwoPi * 16.0) + 1.0;  // 1 for rounding
  ASSERT_LT(bound, 7.0);
  AxisUnderTest axis;
  enable_cyclic_position(axis);
  for (int i = 1; i <= 3'000; ++i) {
    // Starts at a turning point: no step in speed.
    const double position = kAmplitude * (1.0 - std::cos(kTwoPi * i * 1.0e-3));
    stream(axis, static_cast<std::int32_t>(std::lround(position)));
    if (i > 50) {
      ASSERT_LE(std::abs(axis.status().load_position_error_value), bound) << i;
    }
  }
}

TEST(CyclicPosition, RunsAtEveryPeriod) {
  for (const std::int64_t period : {125, 1'000, 10'000}) {
    AxisUnderTest axis({}, microseconds{period});
    enable_cyclic_position(axis);
    for (int i = 1; i <= 200; ++i) {
      stream(axis, 3 * i);
      ASSERT_EQ(axis.demand(), 3 * i);
      ASSERT_EQ(axis.demand_velocity(), 3 * 1'000'000 / period);
    }
    axis.step_for(microseconds{400'000});
    EXPECT_EQ(axis.actual(), 600);
  }
}

// ---- modes of the drive ------------------------------------------------------------------------

TEST(SupportedDriveModes, AreThoseOfTheManualPlusVelocityAndCyclicModes) {
  constexpr std::array<std::int64_t, 10> kWorking{0, 1, 2, 3, 4, 6, 7, 8, 9, 10};
  AxisUnderTest axis;
  // 6502h: bit n - 1 for mode n; modes 1 to 4 and 6 to 10.
  EXPECT_EQ(axis.read("supported_drive_modes"), 0x3EF);
  for (std::int64_t mode = -128; mode <= 127; ++mode) {
    const bool works = std::ranges::find(kWorking, mode) != kWorking.end();
    const std::int64_t before = axis.read("op_mode_cmd");
    EXPECT_EQ(axis.try_write("op_mode_cmd", mode),
              works ? AbortCode::none : AbortCode::value_range_exceeded)
        << mode;
    axis.step();
    EXPECT_EQ(axis.read("op_mode_actual"), works ? mode : before) << mode;
  }
}

TEST(ModesWithoutSetPoints, IgnoreAndCountAnEdgeOfBit4) {
  for (const std::int64_t mode : {3, 8, 9, 10}) {
    SCOPED_TRACE(mode);
    AxisUnderTest axis;
    axis.write("position_user_target_value", 1'000);
    axis.write("op_mode_cmd", mode);
    axis.command(0x000F);
    axis.command(0x001F);
    axis.step(100);
    EXPECT_EQ(axis.actual(), 0);
    EXPECT_EQ(axis.acknowledged(), mode == 3) << "no acknowledge; of mode 3 it is a speed of 0";
    EXPECT_EQ(axis.status().ignored_set_points, 1U);
  }
}

// ---- neighbours --------------------------------------------------------------------------------

ObjectAddress object(std::string_view name) {
  return AxisUnderTest::address_of(name);
}

using StatusWords = std::array<std::uint32_t, sizeof(AxisStatus) / sizeof(std::uint32_t)>;

/// Eight axes in one block. The fourth runs profile position, its neighbours run `modes`.
std::vector<StatusWords> run_beside(Coupling coupling, const std::array<std::int64_t, 7>& modes) {
  std::vector<AxisConfiguration> axes(8);
  for (AxisConfiguration& axis : axes) axis.model.coupling = coupling;
  axes[3].parameters = {{object("test_load_torque"), 500}};
  AxisBank bank(axes, microseconds{1000});
  for (std::size_t axis = 0; axis < 8; ++axis) {
    bank.write(axis, object("op_mode_cmd"), axis == 3 ? 1 : modes.at(axis < 3 ? axis : axis - 1));
    bank.write(axis, object("ds402_controlword"), 0x0F);
  }
  bank.step();
  std::vector<StatusWords> seen;
  for (int tick = 0; tick < 1'500; ++tick) {
    if (tick == 10 || tick == 400) {
      bank.write(3, object("position_user_target_value"), tick == 10 ? 20'000 : -3'000);
      bank.write(3, object("ds402_controlword"), 0x0F);
      bank.write(3, object("ds402_controlword"), 0x3F);
    }
    for (std::size_t axis = 0; axis < 8; ++axis) {
      if (axis != 3) {
        bank.write(axis, object("target_velocity"), 1'000 * tick);
        bank.write(axis, object("target_torque"), tick % 200 - 100);
        bank.write(axis, object("position_user_target_value"), 5 * tick);
      }
    }
    bank.step();
    seen.push_back(std::bit_cast<StatusWords>(bank.status(3)));
  }
  EXPECT_EQ(bank.status(3).position_demand_value, -3'000);
  return seen;
}

TEST(AxisBankModes, AnAxisGivesTheSameBitsInAnyModesOfOtherAxes) {
  for (const Coupling coupling : {Coupling::rigid, Coupling::two_inertia}) {
    const std::vector<StatusWords> alone = run_beside(coupling, {1, 1, 1, 1, 1, 1, 1});
    for (const std::array<std::int64_t, 7>& modes :
         {std::array<std::int64_t, 7>{3, 4, 8, 3, 4, 8, 6},
          std::array<std::int64_t, 7>{9, 10, 8, 9, 10, 7, 7},
          std::array<std::int64_t, 7>{4, 4, 4, 4, 4, 4, 4},
          std::array<std::int64_t, 7>{3, 3, 3, 3, 3, 3, 3}}) {
      EXPECT_TRUE(run_beside(coupling, modes) == alone);
    }
  }
}

}  // namespace
}  // namespace vdrive
