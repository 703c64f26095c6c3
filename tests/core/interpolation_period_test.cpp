// SPDX-License-Identifier: Apache-2.0
// 60C2h: cyclic synchronous position mode spreads the path to a set-point over several ticks.
#include "core/support/axis_under_test.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using test::Random;
using enum PowerState;

/// Cyclic position, Operation enabled, at rest, with this 60C2h:01 [ms].
void enable_interpolating(AxisUnderTest& axis, std::int64_t milliseconds) {
  axis.write("interpolation_time_period", milliseconds);
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
}

/// Writes 607Ah.
void aim_at(AxisUnderTest& axis, std::int32_t position) {
  axis.write("position_user_target_value", position);
}

// ---- the way ------------------------------------------------------------------------------------

TEST(InterpolationPeriod, EndsExactlyOnTheTargetAfterItsTime) {
  AxisUnderTest axis;
  enable_interpolating(axis, 10);
  aim_at(axis, 1'000);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 100 * tick);
    ASSERT_EQ(axis.demand_velocity(), 100'000);
    ASSERT_TRUE(axis.follows_command());
  }
  axis.step();
  EXPECT_EQ(axis.demand(), 1'000);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_TRUE(axis.follows_command());
}

TEST(InterpolationPeriod, MovesTheDemandByTheSamePartInEachTickOfBothDirections) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    enable_interpolating(axis, 7);
    aim_at(axis, sign * 500);
    for (int tick = 1; tick <= 7; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), std::lround(sign * 500.0 * tick / 7.0)) << tick;
      ASSERT_EQ(axis.demand_velocity(), sign * 71'429) << "500/7 in 1 ms";
    }
    axis.step();
    EXPECT_EQ(axis.demand(), sign * 500);
    EXPECT_EQ(axis.demand_velocity(), 0);
  }
}

TEST(InterpolationPeriod, MovesLessThanOneUnitInATick) {
  AxisUnderTest axis;
  enable_interpolating(axis, 100);
  aim_at(axis, 1);
  for (int tick = 1; tick <= 100; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand_velocity(), 10) << "1 UU in 0.1 s";
  }
  EXPECT_EQ(axis.demand(), 1);
  axis.step();
  EXPECT_EQ(axis.demand_velocity(), 0);
}

TEST(InterpolationPeriod, GivesAConstantSpeedToAStreamWhoseSyncHasThisPeriod) {
  AxisUnderTest axis;
  enable_interpolating(axis, 10);
  for (int sync = 0; sync < 50; ++sync) {
    aim_at(axis, 200 * (sync + 1));
    for (int tick = 1; tick <= 10; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), 200 * sync + 20 * tick);
      ASSERT_EQ(axis.demand_velocity(), 20'000);
      ASSERT_TRUE(axis.follows_command());
    }
  }
}

TEST(InterpolationPeriod, TakesTheShortWayAcrossTheEndsOfTheRegister) {
  constexpr std::int32_t kLastPosition = std::numeric_limits<std::int32_t>::max();
  for (const int sign : {1, -1}) {
    AxisConfiguration configuration;
    configuration.initial_position = sign * (kLastPosition - 450);
    const auto behind = [&configuration, sign](int distance) {
      return static_cast<std::int32_t>(static_cast<std::uint32_t>(configuration.initial_position) +
                                       static_cast<std::uint32_t>(sign * distance));
    };
    AxisUnderTest axis(configuration);
    enable_interpolating(axis, 10);
    aim_at(axis, behind(1'000));
    for (int tick = 1; tick <= 10; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), behind(100 * tick));
      ASSERT_EQ(axis.demand_velocity(), sign * 100'000);
      ASSERT_TRUE(axis.follows_command());
    }
    axis.step(1'000);
    EXPECT_NEAR(axis.actual(), behind(1'000), 1);
    EXPECT_EQ(axis.state(), operation_enabled);
  }
}

/// The position that the master streams: a sine of 1 Hz that starts at rest.
std::int32_t streamed_turn(int tick) {
  return static_cast<std::int32_t>(
      std::lround(5'000.0 * (1.0 - std::cos(2.0 * std::numbers::pi * tick * 1.0e-3))));
}

/// @return the largest 60F4h during a stream with a SYNC every 10 ms.
std::int32_t largest_error_with(std::int64_t milliseconds) {
  AxisUnderTest axis;
  enable_interpolating(axis, milliseconds);
  std::int32_t largest = 0;
  for (int tick = 0; tick < 2'000; ++tick) {
    if (tick % 10 == 0) aim_at(axis, streamed_turn(tick + 10));
    axis.step();
    largest = std::max(largest, std::abs(axis.status().load_position_error_value));
  }
  return largest;
}

// At 31416 UU/s the positions of two SYNCs, 10 ms apart, differ by 314 UU: without 60C2h the demand
// jumps by that much.
TEST(InterpolationPeriod, LetsTheAxisFollowASlowStreamWithoutJumps) {
  EXPECT_LT(5 * largest_error_with(10), largest_error_with(0));
}

// ---- set-points ---------------------------------------------------------------------------------

TEST(InterpolationPeriod, StartsANewWayFromThePresentDemand) {
  AxisUnderTest axis;
  enable_interpolating(axis, 10);
  aim_at(axis, 1'000);
  axis.step(4);
  ASSERT_EQ(axis.demand(), 400);
  aim_at(axis, 0);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 400 - 40 * tick);
    ASSERT_EQ(axis.demand_velocity(), -40'000);
    ASSERT_TRUE(axis.follows_command());
  }
  axis.step();
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.demand_velocity(), 0);
}

TEST(InterpolationPeriod, IsNotStartedAgainByTheSameSetPoint) {
  AxisUnderTest axis;
  enable_interpolating(axis, 10);
  for (int tick = 1; tick <= 10; ++tick) {
    aim_at(axis, 1'000);
    axis.step();
    ASSERT_EQ(axis.demand(), 100 * tick);
  }
}

TEST(InterpolationPeriod, KnowsOnlyTheLastSetPointOfATick) {
  AxisUnderTest axis;
  enable_interpolating(axis, 10);
  aim_at(axis, 1'000);
  axis.step(4);
  aim_at(axis, -5'000);
  aim_at(axis, 1'000);
  for (int tick = 5; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 100 * tick) << "the way continues";
  }
}

TEST(InterpolationPeriod, HoldsTheTargetWithoutANewSetPoint) {
  AxisUnderTest axis;
  enable_interpolating(axis, 10);
  aim_at(axis, 1'000);
  axis.step(11);
  for (int tick = 0; tick < 300; ++tick) {
    ASSERT_EQ(axis.demand(), 1'000);
    ASSERT_EQ(axis.demand_velocity(), 0);
    ASSERT_TRUE(axis.follows_command());
    axis.step();
  }
  EXPECT_NEAR(axis.actual(), 1'000, 1);
  aim_at(axis, 900);
  axis.step();
  EXPECT_EQ(axis.demand(), 990);
}

TEST(InterpolationPeriod, DoesNotBeginWithASetPointFromBeforeTheMode) {
  AxisUnderTest axis;
  aim_at(axis, 1'000);
  enable_interpolating(axis, 10);
  axis.step(50);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_FALSE(axis.follows_command());
  aim_at(axis, 1'000);  // the same value, but the first one that counts
  axis.step();
  EXPECT_EQ(axis.demand(), 100);
}

TEST(InterpolationPeriod, OfAWayThatHasBegunStays) {
  AxisUnderTest axis;
  enable_interpolating(axis, 10);
  aim_at(axis, 1'000);
  axis.step(4);
  axis.write("interpolation_time_period", 20);
  axis.step(6);
  EXPECT_EQ(axis.demand(), 1'000);
  EXPECT_EQ(axis.demand_velocity(), 100'000);
  aim_at(axis, 0);
  for (int tick = 1; tick <= 20; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 1'000 - 50 * tick) << "the next way has the new time";
  }
}

TEST(InterpolationPeriod, CountsForASetPointOfTheSameTickInAnyOrder) {
  for (const bool is_first : {true, false}) {
    AxisUnderTest axis;
    enable_interpolating(axis, 0);
    if (is_first) axis.write("interpolation_time_period", 5);
    aim_at(axis, 100);
    if (!is_first) axis.write("interpolation_time_period", 5);
    axis.step();
    EXPECT_EQ(axis.demand(), 20) << is_first;
  }
}

/// Random set-points at random ticks against the formula: in each tick the demand moves by the
/// remaining distance divided by the remaining ticks.
TEST(InterpolationPeriod, FollowsItsFormulaForAnySetPoints) {
  const std::uint64_t seeds = test::case_count(40, 1'000);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const auto period = static_cast<int>(1 + random.below(30));
    AxisUnderTest axis;
    axis.write("following_error_window", 0xFFFFFFFF);
    axis.write("app_speed_limit", 0xFFFFFFFF);
    axis.write("motor_max_speed_rpm", 1'000'000'000);
    enable_interpolating(axis, period);
    double demand = 0.0;
    std::int32_t target = 0;
    int left = 0;
    bool streams = false;
    for (int tick = 0; tick < 200; ++tick) {
      if (random.one_in(12)) {
        const std::int32_t next = static_cast<std::int32_t>(random.below(2'001)) - 1'000;
        aim_at(axis, next);
        if (next != target || !streams) left = period;
        target = next;
        streams = true;
      }
      axis.step();
      if (left > 0) {
        demand += (target - demand) / left;
        --left;
      }
      ASSERT_NEAR(axis.demand(), demand, 0.5 + 1.0e-6) << tick;
      ASSERT_EQ(axis.follows_command(), streams) << tick;
    }
  }
}

// ---- the duration ------------------------------------------------------------------------------

struct TimeOfAWay {
  std::int64_t tick_us;  // of the bench
  std::int64_t period;   // 60C2h:01
  std::int64_t index;    // 60C2h:02
  int ticks;
};

// A fraction of a tick counts as a full tick: 2.5 ms are three ticks of 1 ms, 1 ms is four
// of 333 us.
constexpr std::array<TimeOfAWay, 19> kTimesOfWays{{
    {1'000, 10, -3, 10}, {1'000, 100, -4, 10}, {1'000, 1, -2, 10},    {1'000, 250, -4, 25},
    {1'000, 1, -1, 100}, {1'000, 1, 0, 1'000}, {1'000, 2, -3, 2},     {1'000, 25, -4, 3},
    {1'000, 1, -3, 1},   {1'000, 255, -6, 1},  {1'000, 1, -6, 1},     {1'000, 0, 0, 1},
    {125, 1, -3, 8},     {125, 125, -6, 1},    {125, 126, -6, 2},     {333, 1, -3, 4},
    {2'000, 5, -3, 3},   {10'000, 10, -3, 1},  {10'000, 255, -3, 26},
}};

TEST(InterpolationPeriod, IsItsValueTimesThePowerOfTenOfItsIndexRoundedUpToTicks) {
  for (const TimeOfAWay& row : kTimesOfWays) {
    SCOPED_TRACE(std::to_string(row.period) + " x 10^" + std::to_string(row.index) + " s, tick " +
                 std::to_string(row.tick_us) + " us");
    AxisUnderTest axis({}, microseconds{row.tick_us});
    axis.write("interpolation_time_index", row.index);
    enable_interpolating(axis, row.period);
    aim_at(axis, 10);
    for (int tick = 1; tick <= row.ticks; ++tick) {
      axis.step();
      ASSERT_GT(axis.demand_velocity(), 0) << tick;
    }
    EXPECT_EQ(axis.demand(), 10);
    axis.step();
    EXPECT_EQ(axis.demand_velocity(), 0);
  }
}

TEST(InterpolationPeriod, IsOneTickOfEveryBenchByDefault) {
  for (const std::int64_t tick_us : {125, 250, 333, 500, 1'000, 2'000, 10'000}) {
    AxisUnderTest axis({}, microseconds{tick_us});
    EXPECT_EQ(axis.read("interpolation_time_period"), 0);
    EXPECT_EQ(axis.read("interpolation_time_index"), -3);
    axis.write("op_mode_cmd", 8);
    axis.command(0x000F);
    for (int i = 1; i <= 100; ++i) {
      aim_at(axis, 3 * i);
      axis.step();
      ASSERT_EQ(axis.demand(), 3 * i) << tick_us;
    }
  }
}

TEST(InterpolationPeriod, RefusesAnotherTimeWithTheAbortCodeOfItsSide) {
  AxisUnderTest axis;
  EXPECT_EQ(axis.try_write("interpolation_time_period", 256), AbortCode::value_too_high);
  EXPECT_EQ(axis.try_write("interpolation_time_period", -1), AbortCode::value_too_low);
  EXPECT_EQ(axis.try_write("interpolation_time_index", 1), AbortCode::value_too_high);
  EXPECT_EQ(axis.try_write("interpolation_time_index", -7), AbortCode::value_too_low);
  EXPECT_EQ(axis.axis().read({0x60C2, 0}).code, AbortCode::subindex_does_not_exist);
  EXPECT_EQ(axis.axis().read({0x60C2, 3}).code, AbortCode::subindex_does_not_exist);
}

TEST(InterpolationPeriod, IsStored) {
  AxisUnderTest axis;
  EXPECT_EQ(axis.axis().set_stored({0x60C2, 1}, 10), AbortCode::none);
  EXPECT_EQ(axis.axis().set_stored({0x60C2, 2}, -4), AbortCode::none);
  axis.write("interpolation_time_period", 77);
  axis.axis().power_cycle();
  EXPECT_EQ(axis.read("interpolation_time_period"), 10);
  EXPECT_EQ(axis.read("interpolation_time_index"), -4);
  axis.axis().forget_stored();
  axis.axis().power_cycle();
  EXPECT_EQ(axis.read("interpolation_time_period"), 0);
  EXPECT_EQ(axis.read("interpolation_time_index"), -3);
}

// ---- no bit changes -----------------------------------------------------------------------------

/// @return the status hash after each tick of three axes in these modes under random commands.
std::vector<std::uint64_t> hashes_with(const std::array<std::int64_t, 3>& modes, microseconds tick,
                                       std::int64_t period, std::int64_t index) {
  constexpr std::array<std::uint16_t, 8> kWords{0x0F, 0x1F, 0x0F, 0x3F, 0x010F, 0x02, 0x06, 0x0F};
  AxisBank bank(std::vector<AxisConfiguration>(modes.size()), tick);
  const auto put = [&bank](std::size_t axis, std::string_view name, std::int64_t value) {
    bank.write(axis, AxisUnderTest::address_of(name), value);
  };
  for (std::size_t axis = 0; axis < modes.size(); ++axis) {
    put(axis, "interpolation_time_period", period);
    put(axis, "interpolation_time_index", index);
    put(axis, "op_mode_cmd", modes.at(axis));
    put(axis, "ds402_controlword", 0x0F);
  }
  Random random(7);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 2'000; ++i) {
    for (std::size_t axis = 0; axis < modes.size(); ++axis) {
      const auto value = static_cast<std::int64_t>(random.below(4'001)) - 2'000;
      if (random.one_in(4)) put(axis, "position_user_target_value", value);
      if (random.one_in(30)) put(axis, "target_velocity", 20 * value);
      if (random.one_in(30)) put(axis, "target_torque", value / 10);
      if (random.one_in(60)) put(axis, "ds402_controlword", kWords.at(random.below(8)));
      if (random.one_in(300)) put(axis, "test_positive_limit_input", value > 0 ? 1 : 0);
    }
    bank.step();
    hashes.push_back(bank.status_hash());
  }
  return hashes;
}

TEST(InterpolationPeriod, OfAtMostATickChangesNoBit) {
  constexpr std::array<std::int64_t, 3> kModes{8, 1, 8};
  const auto of_default = hashes_with(kModes, microseconds{1'000}, 0, -3);
  EXPECT_EQ(hashes_with(kModes, microseconds{1'000}, 1, -3), of_default);
  EXPECT_EQ(hashes_with(kModes, microseconds{1'000}, 255, -6), of_default);
  const auto of_short_tick = hashes_with(kModes, microseconds{125}, 0, -3);
  EXPECT_EQ(hashes_with(kModes, microseconds{125}, 125, -6), of_short_tick);
  EXPECT_EQ(hashes_with(kModes, microseconds{125}, 0, 0), of_short_tick);
  EXPECT_NE(hashes_with(kModes, microseconds{125}, 1, -3), of_short_tick);
}

TEST(InterpolationPeriod, ChangesNoBitOfAnAxisInAnotherMode) {
  for (const std::array<std::int64_t, 3>& modes :
       {std::array<std::int64_t, 3>{1, 3, 4}, std::array<std::int64_t, 3>{6, 0, 1}}) {
    EXPECT_EQ(hashes_with(modes, microseconds{1'000}, 255, 0),
              hashes_with(modes, microseconds{1'000}, 0, -3));
  }
}

// ---- limits -------------------------------------------------------------------------------------

TEST(InterpolationPeriod, LeavesTheSpeedWithin607FhAndBit12ShowsIt) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("app_speed_limit", 50'000);
    enable_interpolating(axis, 10);
    aim_at(axis, sign * 1'020);  // 102 per tick would be needed
    for (int tick = 1; tick <= 20; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), sign * 50 * tick);
      ASSERT_EQ(axis.demand_velocity(), sign * 50'000);
      ASSERT_FALSE(axis.follows_command()) << "also when the time is over";
    }
    axis.step();
    EXPECT_EQ(axis.demand(), sign * 1'020);
    EXPECT_TRUE(axis.follows_command());
  }
}

TEST(InterpolationPeriod, LeadsToTheSoftwareLimitAndBit12ShowsIt) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("app_position_limit_switch", 1);
    axis.write("user_position_lower_limit", -200);
    axis.write("user_position_upper_limit", 200);
    enable_interpolating(axis, 10);
    aim_at(axis, sign * 400);
    for (int tick = 1; tick <= 10; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), sign * 20 * tick);
      ASSERT_FALSE(axis.follows_command()) << "not to the position that was written";
    }
    EXPECT_TRUE(axis.limit_active());
    axis.step(50);
    EXPECT_EQ(axis.demand(), sign * 200);
    aim_at(axis, sign * 100);
    for (int tick = 1; tick <= 10; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), sign * (200 - 10 * tick));
      ASSERT_TRUE(axis.follows_command());
    }
  }
}

TEST(InterpolationPeriod, BringsAnAxisBackFromBeyondASoftwareLimitInEqualParts) {
  AxisConfiguration configuration;
  configuration.initial_position = -500;
  AxisUnderTest axis(configuration);
  axis.write("app_position_limit_switch", 1);
  axis.write("user_position_lower_limit", -100);
  axis.write("user_position_upper_limit", 100);
  enable_interpolating(axis, 10);
  aim_at(axis, -50);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), -500 + 45 * tick);
    ASSERT_TRUE(axis.follows_command());
  }
}

TEST(InterpolationPeriod, IsTheDemandThatTheFollowingErrorCounts) {
  AxisUnderTest axis;
  axis.write("following_error_window", 100);
  axis.write("following_error_time_out", 0);
  axis.write("interpolation_time_index", 0);
  enable_interpolating(axis, 1);
  axis.write("test_blocked_load", 1);
  aim_at(axis, 20'000);  // 20 per tick: outside the window after six, a fault in the next
  EXPECT_EQ(axis.step_until(
                [&axis] {
                  return axis.read("error_code") == 0x8611;
                },
                50),
            7U);
}

// ---- ends of a way -----------------------------------------------------------------------------

/// Halfway to 1000, at 100000 UU/s; stops brake with 1000000 UU/s².
void go_half_the_way(AxisUnderTest& axis) {
  axis.write("quick_stop_deceleration", 1'000'000);
  axis.write("profile_dec", 1'000'000);
  axis.write("quick_stop_option_code", 6);
  enable_interpolating(axis, 10);
  aim_at(axis, 1'000);
  axis.step(5);
  ASSERT_EQ(axis.demand(), 500);
}

/// After go_half_the_way() the axis brakes for 100 ticks, by 1000 UU/s each, over
/// 100000²/(2·1000000) = 5000 UU.
void expect_braking_on_the_way(AxisUnderTest& axis) {
  for (int tick = 1; tick <= 99; ++tick) {
    axis.step();
    ASSERT_NEAR(axis.demand_velocity(), 100'000 - 1'000 * tick, 1) << tick;
    ASSERT_FALSE(axis.follows_command());
  }
  axis.step(300);
  ASSERT_EQ(axis.demand(), 5'500);
}

TEST(InterpolationPeriod, IsOverAtALimitSwitchAndAWayFromItHasTheWholeTime) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(go_half_the_way(axis));
  axis.write("test_positive_limit_input", 1);
  ASSERT_NO_FATAL_FAILURE(expect_braking_on_the_way(axis));
  aim_at(axis, 5'400);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 5'500 - 10 * tick);
    ASSERT_TRUE(axis.follows_command());
  }
}

TEST(InterpolationPeriod, IsOverAtAQuickStop) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(go_half_the_way(axis));
  axis.controlword(0x0002);
  ASSERT_NO_FATAL_FAILURE(expect_braking_on_the_way(axis));
  axis.command(0x000F);
  axis.step(50);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.demand(), 5'500) << "the rest of the way is forgotten";
  EXPECT_FALSE(axis.follows_command());
  aim_at(axis, 5'600);
  axis.step();
  EXPECT_EQ(axis.demand(), 5'510);
}

TEST(InterpolationPeriod, IsOverInAFault) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(go_half_the_way(axis));
  axis.write("test_over_temperature", 1);
  for (int tick = 1; tick <= 99; ++tick) {
    axis.step();
    ASSERT_NEAR(axis.demand_velocity(), 100'000 - 1'000 * tick, 1) << "605Eh = 2";
  }
  axis.step(500);
  EXPECT_EQ(axis.statusword(), 0x0218);
  axis.write("test_over_temperature", 0);
  axis.command(0x0080);
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), operation_enabled);
  const std::int32_t rest = axis.demand();
  axis.step(50);
  EXPECT_EQ(axis.demand(), rest);
  EXPECT_FALSE(axis.follows_command());
}

TEST(InterpolationPeriod, IsOverWhenTheModeChanges) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(go_half_the_way(axis));
  axis.write("op_mode_cmd", 1);
  for (int tick = 1; tick <= 99; ++tick) {
    axis.step();
    ASSERT_NEAR(axis.demand_velocity(), 100'000 - 1'000 * tick, 1) << "6084h";
  }
  axis.step(300);
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
  axis.write("op_mode_cmd", 8);
  axis.step(50);
  EXPECT_EQ(axis.read("op_mode_actual"), 8);
  EXPECT_EQ(axis.demand(), 5'500);
  EXPECT_FALSE(axis.follows_command());
}

TEST(InterpolationPeriod, IsNotChangedByAHalt) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(go_half_the_way(axis));
  axis.controlword(0x010F);
  for (int tick = 6; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 100 * tick) << "this mode ignores it";
    ASSERT_TRUE(axis.follows_command());
  }
}

TEST(InterpolationPeriod, IsOverWithThePower) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(go_half_the_way(axis));
  axis.axis().power_cycle();
  axis.step();
  EXPECT_EQ(axis.read("interpolation_time_period"), 0) << "the default again";
  enable_interpolating(axis, 10);
  const std::int32_t rest = axis.demand();
  axis.step(50);
  EXPECT_EQ(axis.demand(), rest);
}

// ---- snapshots ----------------------------------------------------------------------------------

TEST(InterpolationPeriod, ContinuesFromASnapshotInTheMiddle) {
  const std::vector<AxisConfiguration> axes(1);
  AxisBank bank(axes, microseconds{1'000});
  const auto put = [&bank](std::string_view name, std::int64_t value) {
    ASSERT_EQ(bank.write(0, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
  };
  put("interpolation_time_period", 10);
  put("op_mode_cmd", 8);
  put("ds402_controlword", 0x0F);
  bank.step();
  put("position_user_target_value", 1'000);
  for (int tick = 0; tick < 4; ++tick) bank.step();
  const AxisBank::Snapshot middle = bank.snapshot();
  const auto rest_of_the_way = [](AxisBank& from) {
    std::vector<std::uint64_t> hashes;
    for (int tick = 5; tick <= 20; ++tick) {
      from.step();
      EXPECT_EQ(from.status(0).position_demand_value, std::min(100 * tick, 1'000));
      hashes.push_back(from.status_hash());
    }
    return hashes;
  };
  const std::vector<std::uint64_t> hashes = rest_of_the_way(bank);
  bank.restore(middle);
  EXPECT_EQ(rest_of_the_way(bank), hashes);
  AxisBank other(axes, microseconds{1'000});
  other.restore(other.snapshot_from(middle.bytes()));
  EXPECT_EQ(rest_of_the_way(other), hashes);
}

}  // namespace
}  // namespace vdrive
