// SPDX-License-Identifier: Apache-2.0
// Profile position mode of a complete axis, from the manual and docs/explanation/decisions.md.
// Ticks take 1 ms; the tick of the command is tick 1. Statuswords are the manual's.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;

class ProfilePosition : public testing::Test {
 protected:
  /// 6081h, 6083h, 6084h.
  void set_profile(std::int64_t velocity, std::int64_t acceleration, std::int64_t deceleration) {
    axis.write("profile_velocity", velocity);
    axis.write("profile_acc", acceleration);
    axis.write("profile_dec", deceleration);
  }

  /// Sets bit 4 with `word` in the tick of the target and clears it in the next.
  void start(std::int64_t target, std::uint16_t word = 0x003F) {
    axis.write("position_user_target_value", target);
    axis.command(word);
    axis.command(static_cast<std::uint16_t>(word & ~0x0070U));
  }

  /// Runs until bit 10 is set; fails the test if it is not.
  std::uint64_t run_to_target(std::uint64_t deadline = 20'000) {
    const std::uint64_t ticks = axis.step_until_reached(deadline);
    EXPECT_NE(ticks, 0U) << "bit 10 did not come";
    return ticks;
  }

  AxisUnderTest axis;
};

// ---- the manual's tables -----------------------------------------------------------------------

void run_manual_example(AxisUnderTest& axis, std::int64_t target) {
  EXPECT_EQ(axis.command(0x0006), 0x0231);
  axis.write("op_mode_cmd", 1);
  axis.step();
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
  axis.write("position_user_target_value", target);
  axis.write("profile_velocity", 0x03E8);
  axis.write("profile_acc", 0x1770);
  axis.write("profile_dec", 0x1770);
  EXPECT_EQ(axis.command(0x000F), 0x0637);
  EXPECT_EQ(axis.command(0x003F), 0x1237);

  std::uint64_t ticks = 1;
  while (!axis.reached() && ticks < 20'000) {
    // Step 9: until the target is reached, 6064h has not arrived at 607Ah - 60F4h or the axis still
    // moves.
    const std::int64_t arrived = target - axis.read("load_position_error_value");
    ASSERT_EQ(axis.statusword(), 0x1237);
    ASSERT_TRUE(axis.actual() != arrived || axis.demand_velocity() != 0);
    ASSERT_TRUE(target > 0 ? axis.actual() <= arrived : axis.actual() >= arrived);
    axis.step();
    ++ticks;
  }
  // 10.16667 s: the demand arrives in tick 10167.
  EXPECT_EQ(ticks, 10'167U);
  EXPECT_EQ(axis.statusword(), 0x1637);
  EXPECT_EQ(axis.actual(), target - axis.read("load_position_error_value"));
  EXPECT_EQ(axis.demand(), target);
  axis.step(200);
  EXPECT_EQ(axis.actual(), target) << "settled to the unit";
  EXPECT_EQ(axis.statusword(), 0x1637) << "the acknowledge follows bit 4, not the motion";
  EXPECT_EQ(axis.command(0x0006), 0x0231);
}

TEST_F(ProfilePosition, RunsTheManualsForwardExample) {
  run_manual_example(axis, 10'000);
}

TEST_F(ProfilePosition, RunsTheManualsNegativeExample) {
  run_manual_example(axis, -10'000);
}

TEST_F(ProfilePosition, TheManualsCommandTableGivesTheManualsStatuswords) {
  axis.write("op_mode_cmd", 1);
  set_profile(10'000, 100'000, 100'000);
  EXPECT_EQ(axis.command(0x0005), 0x0250);
  EXPECT_EQ(axis.command(0x0006), 0x0231);
  EXPECT_EQ(axis.command(0x000F), 0x0637);
  axis.write("position_user_target_value", 10'000);
  EXPECT_EQ(axis.command(0x003F), 0x1237) << "absolute, on its way";
  run_to_target();
  EXPECT_EQ(axis.statusword(), 0x1637) << "absolute, arrived";
  axis.command(0x000F);
  EXPECT_EQ(axis.command(0x007F), 0x1237) << "relative, on its way";
  axis.step(500);
  EXPECT_EQ(axis.command(0x010F), 0x0237) << "halt, speed not 0";
  axis.step(500);
  EXPECT_EQ(axis.statusword(), 0x0637) << "halt, speed 0";
  EXPECT_EQ(axis.command(0x007F), 0x1237);
  run_to_target();
  EXPECT_EQ(axis.statusword(), 0x1637) << "relative, arrived";
  EXPECT_EQ(axis.command(0x0005), 0x0250);
}

TEST_F(ProfilePosition, TheManualsActionTableHolds) {
  axis.write("op_mode_cmd", 1);
  EXPECT_EQ(axis.step(), 0x0250);
  EXPECT_EQ(axis.command(0x0006), 0x0231) << "disabled -> ready to switch on";
  axis.command(0x0005);
  EXPECT_EQ(axis.command(0x000F), 0x0637) << "switch on disabled -> operation enabled";
  axis.command(0x0006);
  EXPECT_EQ(axis.command(0x000F), 0x0637) << "ready to switch on -> operation enabled";
  axis.write("position_user_target_value", 50'000);
  for (const std::uint16_t disable : {std::uint16_t{0x0006}, std::uint16_t{0x0005}}) {
    axis.command(0x000F);
    axis.command(0x003F);
    axis.step(100);
    EXPECT_EQ(axis.command(disable), disable == 0x0006 ? 0x0231 : 0x0250) << "while moving";
    axis.command(0x000F);
    axis.command(0x003F);
    axis.step(100);
    axis.command(0x010F);
    axis.step(300);
    EXPECT_EQ(axis.command(disable), disable == 0x0006 ? 0x0231 : 0x0250) << "while halted";
  }
}

// ---- handshake ---------------------------------------------------------------------------------

TEST_F(ProfilePosition, NothingMovesWithoutARisingEdgeOfBit4) {
  axis.enable();
  axis.write("position_user_target_value", 10'000);
  axis.step(100);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.statusword(), 0x0637) << "bit 10 compares with the latched target";
}

TEST_F(ProfilePosition, TheAcknowledgeRisesAndBit10FallsInOneTick) {
  axis.enable();
  axis.write("position_user_target_value", 10'000);
  EXPECT_EQ(axis.command(0x001F), 0x1237);
}

TEST_F(ProfilePosition, TheAcknowledgeDropsWithBit4InTheSameTick) {
  axis.enable();
  axis.write("position_user_target_value", 100'000);
  axis.command(0x001F);
  axis.step(5);
  EXPECT_EQ(axis.statusword(), 0x1237);
  EXPECT_EQ(axis.command(0x000F), 0x0237);
}

TEST_F(ProfilePosition, APulseOfBit4WithinOneTickIsASetPoint) {
  axis.enable();
  axis.write("position_user_target_value", 1'000);
  axis.controlword(0x001F);
  axis.controlword(0x000F);
  EXPECT_EQ(axis.step(), 0x0237);
  run_to_target();
  EXPECT_EQ(axis.demand(), 1'000);
}

TEST_F(ProfilePosition, ControlwordsOfOneTickActAsInThreeTicks) {
  axis.write("op_mode_cmd", 1);
  axis.write("position_user_target_value", 1'000);
  for (const unsigned word : {0x06U, 0x07U, 0x0FU}) {
    axis.controlword(static_cast<std::uint16_t>(word));
  }
  for (const unsigned word : {0x0FU, 0x3FU, 0x0FU}) {
    axis.controlword(static_cast<std::uint16_t>(word));
  }
  EXPECT_EQ(axis.step(), 0x0237);
  run_to_target();
  EXPECT_EQ(axis.demand(), 1'000);
}

TEST_F(ProfilePosition, ObjectsWrittenInTheTickOfTheControlwordTakeEffectBeforeIt) {
  axis.command(0x000F);
  axis.write("op_mode_cmd", 1);
  axis.write("position_user_target_value", 100'000);
  set_profile(2'000, 1'000'000, 1'000'000);
  axis.controlword(0x003F);
  EXPECT_EQ(axis.step(), 0x1237);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 2'000);
}

TEST_F(ProfilePosition, AnEdgeInTheEnablingControlwordIsIgnoredAndCounted) {
  axis.write("op_mode_cmd", 1);
  axis.write("position_user_target_value", 10'000);
  EXPECT_EQ(axis.command(0x001F), 0x0637);
  axis.step(100);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
}

TEST_F(ProfilePosition, AnEdgeOutsideOperationEnabledIsIgnored) {
  axis.write("op_mode_cmd", 1);
  axis.command(0x0006);
  axis.command(0x0016);
  EXPECT_EQ(axis.statusword(), 0x0231);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
}

TEST_F(ProfilePosition, TheSetPointHasTheObjectValuesAtTheEdge) {
  axis.enable();
  set_profile(5'000, 1'000'000, 1'000'000);
  axis.write("position_user_target_value", 10'000);
  axis.controlword(0x001F);
  axis.write("position_user_target_value", -777);
  axis.write("profile_velocity", 100);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 5'000);
  run_to_target();
  EXPECT_EQ(axis.demand(), 10'000);
}

TEST_F(ProfilePosition, AZeroLengthMoveIsAcknowledgedAndReachedAfterTheWindowTime) {
  axis.enable();
  EXPECT_EQ(axis.command(0x003F), 0x1237);
  // 6068h = 20 ms: the timer starts when the set-point is accepted.
  const std::uint64_t ticks = run_to_target();
  EXPECT_NEAR(static_cast<double>(ticks), 20.0, 1.0);
  EXPECT_EQ(axis.statusword(), 0x1637);
}

TEST_F(ProfilePosition, AProfileVelocityOf0IsAcknowledgedAndDoesNotMove) {
  axis.enable();
  axis.write("profile_velocity", 0);
  axis.write("position_user_target_value", 10'000);
  EXPECT_EQ(axis.command(0x003F), 0x1237);
  for (int i = 0; i < 200; ++i) ASSERT_EQ(axis.step(), 0x1237);
  EXPECT_EQ(axis.demand(), 0);
}

// ---- buffering ---------------------------------------------------------------------------------

TEST_F(ProfilePosition, ABufferedSetPointKeepsTheAcknowledgeAndStartsWhenTheFirstIsReached) {
  axis.enable();
  set_profile(10'000, 100'000, 100'000);
  start(10'000, 0x001F);
  EXPECT_EQ(axis.statusword(), 0x0237);
  axis.write("position_user_target_value", 15'000);
  EXPECT_EQ(axis.command(0x001F), 0x1237);
  EXPECT_EQ(axis.command(0x000F), 0x1237) << "the buffer is full";

  // 10000 units at 10000/s and 100000/s²: 1.1 s. Until then bit 12 stays set; bit 10 is 0
  // throughout.
  std::uint64_t dropped_at = 0;
  std::int32_t demand_then = 0;
  axis.step_until(
      [&] {
        if (!axis.acknowledged() && dropped_at == 0) {
          dropped_at = axis.ticks();
          demand_then = axis.demand();
        }
        return axis.reached();
      },
      10'000);
  EXPECT_NEAR(demand_then, 10'000, 1) << "bit 12 drops when the buffer becomes active";
  EXPECT_EQ(axis.demand(), 15'000);
  EXPECT_EQ(axis.statusword(), 0x0637);
}

TEST_F(ProfilePosition, Bit10StaysLowBetweenChainedSetPoints) {
  axis.enable();
  set_profile(10'000, 100'000, 100'000);
  start(5'000, 0x001F);
  start(8'000, 0x001F);
  int rises = 0;
  bool before = false;
  for (int i = 0; i < 3'000; ++i) {
    axis.step();
    rises += axis.reached() && !before ? 1 : 0;
    before = axis.reached();
  }
  EXPECT_EQ(rises, 1);
  EXPECT_EQ(axis.demand(), 8'000);
}

TEST_F(ProfilePosition, AThirdSetPointIsIgnoredWhileTheBufferIsFull) {
  axis.enable();
  set_profile(10'000, 100'000, 100'000);
  start(5'000, 0x001F);
  start(8'000, 0x001F);
  start(-50'000, 0x001F);
  EXPECT_TRUE(axis.acknowledged()) << "bit 12 simply remains 1";
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
  run_to_target();
  EXPECT_EQ(axis.demand(), 8'000);
}

TEST_F(ProfilePosition, AnImmediateSetPointDiscardsActiveAndBuffered) {
  axis.enable();
  set_profile(10'000, 100'000, 100'000);
  start(50'000, 0x001F);
  start(80'000, 0x001F);
  axis.step(100);
  start(2'000, 0x003F);
  EXPECT_FALSE(axis.acknowledged()) << "the buffer is free again";
  run_to_target();
  EXPECT_EQ(axis.demand(), 2'000);
  axis.step(500);
  EXPECT_EQ(axis.demand(), 2'000);
}

TEST_F(ProfilePosition, TheBufferKeepsTargetAndVelocityOfItsEdge) {
  axis.enable();
  set_profile(10'000, 1'000'000, 1'000'000);
  start(5'000, 0x001F);
  axis.write("profile_velocity", 3'000);
  start(9'000, 0x001F);
  axis.write("profile_velocity", 1);
  axis.write("position_user_target_value", -1);
  std::int32_t fastest_beyond = 0;
  axis.step_until(
      [&] {
        if (axis.demand() > 5'010) {
          fastest_beyond = std::max(fastest_beyond, axis.demand_velocity());
        }
        return axis.reached();
      },
      10'000);
  EXPECT_EQ(axis.demand(), 9'000);
  EXPECT_EQ(fastest_beyond, 3'000);
}

TEST_F(ProfilePosition, TheQueueIsDroppedOnLeavingOperationEnabled) {
  axis.enable();
  set_profile(10'000, 100'000, 100'000);
  start(50'000, 0x001F);
  start(80'000, 0x001F);
  axis.command(0x0006);
  EXPECT_EQ(axis.statusword(), 0x0231);
  axis.step(2'000);
  EXPECT_EQ(axis.command(0x000F), 0x0637);
  const std::int32_t rest = axis.demand();
  axis.step(1'000);
  EXPECT_EQ(axis.demand(), rest) << "an interrupted move never restarts";
  EXPECT_EQ(axis.statusword(), 0x0637);
}

// ---- change immediately ------------------------------------------------------------------------

TEST_F(ProfilePosition, ChangingImmediatelyLeavesNoStepInDemandAndVelocity) {
  axis.enable();
  set_profile(50'000, 500'000, 250'000);
  start(100'000);
  axis.step(300);
  std::int32_t position = axis.demand();
  std::int32_t velocity = axis.demand_velocity();
  axis.write("position_user_target_value", -20'000);
  axis.write("profile_velocity", 30'000);
  axis.controlword(0x003F);
  for (int i = 0; i < 3'000; ++i) {
    axis.step();
    // 1 ms at no more than 500000/s²: the velocity changes by at most 500 (+1 for rounding).
    ASSERT_LE(std::abs(axis.demand_velocity() - velocity), 501);
    ASSERT_NEAR(axis.demand() - position, 0.5e-3 * (axis.demand_velocity() + velocity), 2.0);
    position = axis.demand();
    velocity = axis.demand_velocity();
  }
  EXPECT_EQ(position, -20'000);
}

TEST_F(ProfilePosition, AReversalIsNotReachedAtItsTurningPoint) {
  axis.enable();
  set_profile(50'000, 100'000, 100'000);
  axis.write("position_target_reached_window", 0xFFFFFFFF);  // off: only the profile counts
  start(100'000);
  axis.step(600);
  start(axis.demand() + 10);  // well inside the stopping distance
  const std::uint64_t ticks = axis.step_until(
      [this] {
        return axis.reached() || axis.demand_velocity() < 0;
      },
      5'000);
  ASSERT_NE(ticks, 0U);
  EXPECT_FALSE(axis.reached());
  run_to_target();
}

TEST_F(ProfilePosition, ALowerVelocityIsReachedWithTheDeceleration) {
  axis.enable();
  set_profile(60'000, 600'000, 100'000);
  start(1'000'000);
  axis.step(500);
  ASSERT_EQ(axis.demand_velocity(), 60'000);
  axis.write("profile_velocity", 20'000);
  axis.command(0x003F);
  EXPECT_NEAR(axis.demand_velocity(), 59'900, 1);  // 100000/s² over 1 ms
  axis.step(399);
  EXPECT_EQ(axis.demand_velocity(), 20'000);  // 40000/100000 = 0.4 s
}

TEST_F(ProfilePosition, AHigherVelocityIsReachedWithTheAcceleration) {
  axis.enable();
  set_profile(20'000, 200'000, 100'000);
  start(1'000'000);
  axis.step(500);
  axis.write("profile_velocity", 60'000);
  axis.command(0x003F);
  EXPECT_NEAR(axis.demand_velocity(), 20'200, 1);
  axis.step(199);
  EXPECT_EQ(axis.demand_velocity(), 60'000);
}

TEST_F(ProfilePosition, Bit5MayAccompanyTheFirstSetPoint) {
  axis.enable();
  start(1'000, 0x003F);
  run_to_target();
  EXPECT_EQ(axis.demand(), 1'000);
}

// ---- relative moves ----------------------------------------------------------------------------

/// The manual's example: +10000, halted during the move, then +5000.
struct RelativeCase {
  std::int32_t demand_at_halt;
  std::int32_t actual_at_halt;
  std::int32_t end;
};

RelativeCase run_relative_example(AxisUnderTest& axis, std::int64_t option) {
  axis.write("positioning_option_code", option);
  axis.enable();
  axis.write("profile_velocity", 20'000);
  axis.write("position_user_target_value", 10'000);
  axis.command(0x007F);
  axis.step(200);
  axis.command(0x010F);
  axis.step(500);
  EXPECT_EQ(axis.statusword(), 0x0637);
  RelativeCase result{.demand_at_halt = axis.demand(), .actual_at_halt = axis.actual(), .end = 0};
  axis.write("position_user_target_value", 5'000);
  EXPECT_EQ(axis.command(0x007F), 0x1237);
  EXPECT_NE(axis.step_until_reached(20'000), 0U);
  result.end = axis.demand();
  return result;
}

TEST_F(ProfilePosition, RelativeOption0CountsFromThePrecedingTarget) {
  EXPECT_EQ(run_relative_example(axis, 0).end, 15'000);
}

TEST_F(ProfilePosition, RelativeOption1CountsFromTheDemand) {
  const RelativeCase result = run_relative_example(axis, 1);
  EXPECT_EQ(result.end, result.demand_at_halt + 5'000);
  EXPECT_LT(result.end, 15'000);
}

TEST_F(ProfilePosition, RelativeOption2CountsFromTheActualPosition) {
  const RelativeCase result = run_relative_example(axis, 2);
  EXPECT_EQ(result.end, result.actual_at_halt + 5'000);
}

TEST_F(ProfilePosition, RelativeOption2DiffersFromOption1ByTheFollowingErrorOfAMovingAxis) {
  for (const std::int64_t option : {1, 2}) {
    AxisConfiguration weak;
    weak.model.position_loop_bandwidth = 2.0;
    weak.model.velocity_loop_bandwidth = 10.0;
    AxisUnderTest moving(weak);
    moving.write("positioning_option_code", option);
    moving.enable();
    moving.write("position_user_target_value", 100'000);
    moving.command(0x003F);
    moving.step(100);  // accelerating, so the loops lag
    const std::int32_t base = option == 1 ? moving.demand() : moving.actual();
    ASSERT_NE(moving.demand(), moving.actual());
    moving.write("position_user_target_value", 50'000);
    moving.command(0x000F);
    // The base is taken when the word is written: the status of the last tick.
    const std::int32_t second_base = option == 1 ? moving.demand() : moving.actual();
    moving.command(0x007F);
    EXPECT_NE(moving.step_until_reached(20'000), 0U);
    EXPECT_EQ(moving.demand(), second_base + 50'000) << "option " << option << ", before " << base;
  }
}

TEST_F(ProfilePosition, AfterAnAbsoluteMoveARelativeOneCountsFromItsTarget) {
  for (const std::int64_t option : {0, 1, 2}) {
    AxisUnderTest fresh;
    fresh.write("positioning_option_code", option);
    fresh.enable();
    fresh.write("position_user_target_value", 10'000);
    fresh.command(0x003F);
    fresh.step(1'000);
    fresh.command(0x000F);
    fresh.write("position_user_target_value", 5'000);
    fresh.command(0x007F);
    fresh.step(1'000);
    EXPECT_EQ(fresh.demand(), 15'000) << "60F2h = " << option;
    EXPECT_EQ(fresh.statusword(), 0x1637);
  }
}

TEST_F(ProfilePosition, TheFirstRelativeMoveAfterEnablingCountsFromThePresentPosition) {
  AxisConfiguration configuration;
  configuration.initial_position = 777;
  for (const std::int64_t option : {0, 1, 2}) {
    AxisUnderTest fresh(configuration);
    fresh.write("positioning_option_code", option);
    fresh.enable();
    fresh.write("position_user_target_value", -1'000);
    fresh.command(0x007F);
    fresh.step(1'000);
    EXPECT_EQ(fresh.demand(), -223) << "60F2h = " << option;
  }
}

TEST_F(ProfilePosition, ABufferedRelativeMoveCountsFromTheMomentItBecomesActive) {
  for (const std::int64_t option : {0, 1, 2}) {
    AxisUnderTest fresh;
    fresh.write("positioning_option_code", option);
    fresh.enable();
    fresh.write("position_user_target_value", 10'000);
    fresh.command(0x001F);
    fresh.command(0x000F);
    fresh.write("position_user_target_value", 5'000);
    fresh.command(0x005F);
    fresh.command(0x000F);
    fresh.step_until_reached(10'000);
    // With option 2 the actual position may still settle by a unit or two.
    EXPECT_NEAR(fresh.demand(), 15'000, option == 2 ? 3 : 0) << "60F2h = " << option;
  }
}

TEST_F(ProfilePosition, ABufferedRelativeMoveKeepsThe60F2hOfItsEdge) {
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("position_target_reached_window", 0xFFFFFFFF);  // reached when the profile ends
  axis.write("positioning_option_code", 0);
  axis.enable();
  axis.write("test_blocked_load", 1);  // 6064h stays 0
  axis.write("position_user_target_value", 10'000);
  axis.command(0x001F);
  axis.command(0x000F);
  axis.write("position_user_target_value", 5'000);
  axis.command(0x005F);
  axis.write("positioning_option_code", 2);
  axis.command(0x000F);
  run_to_target();
  EXPECT_EQ(axis.actual(), 0);
  EXPECT_EQ(axis.demand(), 15'000) << "from the target before, not from 6064h";
}

TEST_F(ProfilePosition, ARelativeMoveOf0DoesNotRun) {
  axis.enable();
  axis.write("position_user_target_value", 0);
  EXPECT_EQ(axis.command(0x007F), 0x1237);
  run_to_target(50);
  EXPECT_EQ(axis.demand(), 0);
}

TEST_F(ProfilePosition, ARelativeMoveWrapsAtTheEndOfTheRegister) {
  for (const int sign : {1, -1}) {
    AxisConfiguration configuration;
    configuration.initial_position = sign * 2'147'480'000;
    AxisUnderTest fresh(configuration);
    fresh.enable();
    fresh.write("position_user_target_value", sign * 10'000);
    fresh.command(0x007F);
    fresh.step_until_reached(5'000);
    // ±2147490000 modulo 2^32.
    EXPECT_EQ(fresh.demand(), sign * (2'147'490'000 - 4'294'967'296));
    EXPECT_EQ(fresh.statusword(), 0x1637);
    EXPECT_LT(std::abs(fresh.read("load_position_error_value")), 100);
    fresh.step(500);
    EXPECT_EQ(fresh.actual(), fresh.demand());
  }
}

TEST_F(ProfilePosition, AnAbsoluteMoveNeverTakesTheShortWay) {
  AxisConfiguration configuration;
  configuration.initial_position = 2'147'483'000;
  AxisUnderTest fresh(configuration);
  fresh.enable();
  fresh.write("position_user_target_value", -2'147'483'000);
  fresh.command(0x003F);
  fresh.step(1'000);
  EXPECT_LT(fresh.demand(), 2'147'483'000);
  EXPECT_GT(fresh.demand(), 2'147'000'000) << "back through 0, not over the end";
  EXPECT_LT(fresh.demand_velocity(), 0);
}

TEST_F(ProfilePosition, AnAbsoluteTargetAtTheEndOfTheRegisterIsExact) {
  AxisConfiguration configuration;
  configuration.initial_position = 2'147'483'000;
  AxisUnderTest fresh(configuration);
  fresh.enable();
  fresh.write("position_user_target_value", 648);  // to 2^31, which is shown as -2^31
  fresh.command(0x007F);
  fresh.step(1'000);
  ASSERT_EQ(fresh.demand(), -2'147'483'647 - 1);
  fresh.command(0x000F);
  fresh.write("position_user_target_value", -2'147'483'647 - 1);
  fresh.command(0x003F);
  fresh.step(10);
  EXPECT_EQ(fresh.demand(), -2'147'483'647 - 1);
  EXPECT_EQ(fresh.demand_velocity(), 0) << "not once round the register";
}

TEST_F(ProfilePosition, AnAbsoluteTargetAfterAWrapIsTheRegisterValue) {
  AxisConfiguration configuration;
  configuration.initial_position = 2'147'480'000;
  AxisUnderTest fresh(configuration);
  fresh.enable();
  fresh.write("position_user_target_value", 10'000);
  fresh.command(0x007F);
  fresh.step(1'000);
  fresh.command(0x000F);
  const std::int32_t wrapped = fresh.demand();
  fresh.write("position_user_target_value", wrapped + 1'000);
  fresh.command(0x003F);
  EXPECT_NE(fresh.step_until_reached(2'000), 0U);
  EXPECT_EQ(fresh.demand(), wrapped + 1'000);
}

TEST_F(ProfilePosition, NewSetPointsWhileCrossingTheEndOfTheRegisterKeepThePositionLoopClosed) {
  // The demand has wrapped, the lagging encoder has not: whatever the offset, no set-point may see
  // the two a full register apart. Undisturbed, the axis lags by 45 units here.
  for (const Feedback feedback : {Feedback::single_encoder, Feedback::dual_encoder}) {
    for (std::int32_t offset = 0; offset < 100; offset += 10) {
      AxisConfiguration configuration;
      configuration.initial_position = 2'147'480'000 + offset;
      configuration.model.feedback = feedback;
      configuration.model.position_loop_bandwidth = 2.0;
      configuration.model.velocity_loop_bandwidth = 10.0;
      AxisUnderTest fresh(configuration);
      fresh.write("positioning_option_code", 0);
      fresh.enable();
      fresh.write("position_user_target_value", 100);
      for (int i = 0; i < 200; ++i) {
        fresh.command(0x007F);
        fresh.command(0x000F);
        ASSERT_LT(std::abs(fresh.read("load_position_error_value")), 60)
            << "after set-point " << i << ", offset " << offset;
      }
      fresh.step_until_reached(5'000);
      EXPECT_EQ(fresh.demand(), 2'147'480'000LL + offset + 20'000 - 4'294'967'296);
    }
  }
}

// ---- halt --------------------------------------------------------------------------------------

class Halt : public ProfilePosition {
 protected:
  /// Moving at 20000/s towards 100000, both ramps 100000/s².
  void SetUp() override {
    axis.enable();
    set_profile(20'000, 100'000, 100'000);
    axis.write("position_user_target_value", 100'000);
    axis.command(0x003F);
    axis.step(500);
  }
};

TEST_F(Halt, Bit10ShowsZeroSpeed) {
  axis.controlword(0x010F);
  for (int i = 0; i < 400; ++i) {
    axis.step();
    const bool stands = axis.demand_velocity() == 0 && std::abs(axis.velocity()) <= 10;  // 606Fh
    if (axis.reached()) {
      ASSERT_TRUE(stands) << "tick " << i;
    } else if (i > 201) {
      ASSERT_FALSE(stands && axis.velocity() == 0) << "tick " << i;
    }
  }
  EXPECT_TRUE(axis.reached());
}

TEST_F(Halt, KeepsTheAcknowledgeWhileBit4IsHeld) {
  EXPECT_EQ(axis.command(0x013F), 0x1237);
  axis.step(400);
  EXPECT_EQ(axis.statusword(), 0x1637);
}

TEST_F(Halt, ReleasedWithoutBit4ResumesTheLatchedMove) {
  axis.command(0x010F);
  axis.step(400);
  axis.write("position_user_target_value", -5);  // not latched
  EXPECT_EQ(axis.command(0x000F), 0x0237);
  run_to_target();
  EXPECT_EQ(axis.statusword(), 0x0637);
  EXPECT_EQ(axis.demand(), 100'000);
}

TEST_F(Halt, ReleasedWithAnEdgeStartsANewAbsoluteMove) {
  axis.command(0x010F);
  axis.step(400);
  EXPECT_EQ(axis.command(0x003F), 0x1237);
  run_to_target();
  EXPECT_EQ(axis.statusword(), 0x1637);
  EXPECT_EQ(axis.demand(), 100'000);
}

TEST_F(Halt, ReleasedWithARelativeEdgeAddsAnotherIncrement) {
  axis.command(0x010F);
  axis.step(400);
  const std::int32_t actual = axis.actual();
  axis.write("position_user_target_value", 5'000);
  EXPECT_EQ(axis.command(0x007F), 0x1237);
  run_to_target();
  EXPECT_EQ(axis.demand(), actual + 5'000);
}

TEST_F(Halt, ReleasedBeforeStandstillAcceleratesFromThePresentSpeed) {
  axis.command(0x010F);
  axis.step(99);
  EXPECT_NEAR(axis.demand_velocity(), 10'000, 1);
  axis.command(0x000F);
  EXPECT_NEAR(axis.demand_velocity(), 10'100, 1);
  run_to_target();
  EXPECT_EQ(axis.demand(), 100'000);
}

TEST_F(Halt, ReleasedTogetherWithAnEdgeStartsTheMove) {
  axis.command(0x012F);
  axis.step(400);
  axis.write("position_user_target_value", 40'000);
  EXPECT_EQ(axis.command(0x003F), 0x1237);
  run_to_target();
  EXPECT_EQ(axis.demand(), 40'000);
}

TEST_F(Halt, AnEdgeWhileHaltedIsAcknowledgedAndStartsOnRelease) {
  axis.command(0x010F);
  axis.step(400);
  const std::int32_t rest = axis.demand();
  axis.write("position_user_target_value", 30'000);
  EXPECT_EQ(axis.command(0x013F), 0x1637) << "bit 10 keeps its halt meaning";
  axis.step(100);
  EXPECT_EQ(axis.demand(), rest);
  axis.command(0x010F);
  EXPECT_EQ(axis.command(0x000F), 0x0237);
  run_to_target();
  EXPECT_EQ(axis.demand(), 30'000);
}

TEST(HaltSetting, MakesTheAxisIgnoreAnEdgeWhileHalted) {
  AxisConfiguration configuration;
  configuration.settings.acknowledge_while_halted = false;
  AxisUnderTest axis(configuration);
  axis.write("op_mode_cmd", 1);
  axis.enable();
  axis.write("position_user_target_value", 30'000);
  axis.command(0x010F);
  EXPECT_EQ(axis.command(0x013F), 0x0637) << "not acknowledged";
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
  EXPECT_EQ(axis.command(0x002F), 0x0637);
  EXPECT_EQ(axis.command(0x003F), 0x1237) << "the edge after the halt counts";
}

TEST_F(Halt, KeepsABufferedSetPoint) {
  axis.command(0x000F);
  start(120'000, 0x001F);
  axis.command(0x010F);
  axis.step(400);
  EXPECT_EQ(axis.statusword(), 0x1637) << "the buffer is full";
  axis.command(0x000F);
  run_to_target();
  EXPECT_EQ(axis.demand(), 120'000);
}

TEST_F(ProfilePosition, HaltWithoutAMoveShowsStandstill) {
  axis.enable();
  EXPECT_EQ(axis.command(0x010F), 0x0637);
  EXPECT_EQ(axis.step(100), 0x0637);
  EXPECT_EQ(axis.command(0x000F), 0x0637);
}

TEST_F(ProfilePosition, HaltAfterTheArrivalKeepsTheAcknowledgeOfAHeldBit4) {
  axis.enable();
  axis.write("position_user_target_value", 1'000);
  axis.command(0x003F);
  run_to_target();
  EXPECT_EQ(axis.command(0x013F), 0x1637);
  EXPECT_EQ(axis.command(0x003F), 0x1637) << "bit 4 did not rise";
}

// ---- target reached ----------------------------------------------------------------------------

TEST_F(ProfilePosition, Bit10RisesOnArrivalWhenTheWindowTimeHasPassedBefore) {
  // At 6000/s² the last 100 units take sqrt(2·100/6000) = 0.18 s, more than 6068h = 20 ms.
  axis.enable();
  set_profile(1'000, 6'000, 6'000);
  axis.write("position_user_target_value", 500);
  axis.command(0x003F);
  // 500 units: ramps 166.667 units and 1/3 s, cruise 0.33333 s: 0.66667 s, tick 667.
  EXPECT_EQ(run_to_target() + 1, 667U);
}

TEST_F(ProfilePosition, Bit10WaitsForTheWindowTime) {
  axis.write("position_target_reached_window_time", 500);
  axis.enable();
  set_profile(1'000, 6'000, 6'000);
  axis.write("position_user_target_value", 500);
  axis.command(0x003F);
  // The actual position enters the window of 100 units when 100 units remain.
  // sqrt(2·100/6000) > 1/6 s, so that is before the ramp, which takes the last 83.33 units:
  // 1/6 + 16.67/1000 = 0.18333 s before the end, within a following error of 2 units (2 ms).
  // 0.66667 - 0.18333 + 0.5 = 0.98333 s.
  EXPECT_NEAR(static_cast<double>(run_to_target() + 1), 984.0, 4.0);
}

TEST_F(ProfilePosition, TheWindowTimeIsMeasuredWithThePublishedPositions) {
  // An independent timer: cleared outside the window and when the set-point is accepted, running
  // from the first tick inside.
  AxisConfiguration soft;
  soft.model.position_loop_bandwidth = 4.0;
  for (const std::int64_t window : {0, 1, 10, 100, 5'000}) {
    for (const std::int64_t time : {0, 1, 20, 300}) {
      AxisUnderTest dut(soft);
      dut.write("position_target_reached_window", window);
      dut.write("position_target_reached_window_time", time);
      dut.enable();
      dut.write("position_user_target_value", 20'000);
      dut.command(0x003F);
      std::int64_t entered = -1;
      bool expected = false;
      for (std::int64_t tick = 0; tick < 2'000 && !expected; ++tick) {
        dut.step();
        const bool inside = std::abs(dut.actual() - 20'000) <= window;
        entered = !inside ? -1 : (entered < 0 ? tick : entered);
        const bool finished = dut.demand() == 20'000 && dut.demand_velocity() == 0;
        expected = finished && inside && tick - entered >= time;
        ASSERT_EQ(dut.reached(), expected)
            << "6067h = " << window << ", 6068h = " << time << ", tick " << tick;
      }
      ASSERT_TRUE(expected);
    }
  }
}

TEST_F(ProfilePosition, AWindowOfFFFFFFFFhIsOff) {
  AxisConfiguration soft;
  soft.model.position_loop_bandwidth = 2.0;
  AxisUnderTest dut(soft);
  dut.write("position_target_reached_window", 0xFFFFFFFF);
  dut.enable();
  dut.write("position_user_target_value", 10'000);
  dut.command(0x003F);
  // The profile takes 0.3125 s: tick 313, wherever the axis is.
  EXPECT_EQ(dut.step_until_reached(5'000) + 1, 313U);
}

TEST_F(ProfilePosition, Bit10FallsWhenTheAxisIsPushedOutOfTheWindowAndReturnsAfterTheTime) {
  axis.write("position_target_reached_window", 5);
  axis.enable();
  axis.step(100);
  ASSERT_EQ(axis.statusword(), 0x0637);
  axis.write("test_load_torque", 2'000);
  EXPECT_NE(axis.step_until(
                [this] {
                  return !axis.reached();
                },
                100),
            0U);
  EXPECT_GT(axis.actual(), 5);
  run_to_target(2'000);
  EXPECT_LE(std::abs(axis.actual()), 5);
}

TEST_F(ProfilePosition, Bit10IsSetAtOnceOnEnablingAtAnyPosition) {
  AxisConfiguration configuration;
  configuration.initial_position = -1'234'567;
  AxisUnderTest dut(configuration);
  dut.write("op_mode_cmd", 1);
  dut.write("position_user_target_value", 99);
  EXPECT_EQ(dut.command(0x000F), 0x0637);
  EXPECT_EQ(dut.demand(), -1'234'567);
}

// ---- software limits ---------------------------------------------------------------------------

class SoftwareLimits : public ProfilePosition {
 protected:
  void SetUp() override {
    axis.write("user_position_lower_limit", -5'000);
    axis.write("user_position_upper_limit", 5'000);
    axis.write("app_position_limit_switch", 1);
    axis.enable();
  }
};

TEST_F(SoftwareLimits, HaveNoEffectWhile3535hIsOff) {
  axis.write("app_position_limit_switch", 0);
  start(10'000);
  run_to_target();
  EXPECT_EQ(axis.demand(), 10'000);
  EXPECT_EQ(axis.statusword(), 0x0637);
}

TEST_F(SoftwareLimits, ClampTheLatchedTargetAndTheMoveReachesIt) {
  for (const std::int64_t sign : {1, -1}) {
    start(sign * 10'000);
    run_to_target();
    EXPECT_EQ(axis.demand(), sign * 5'000);
    EXPECT_EQ(axis.read("position_user_target_value"), sign * 10'000) << "reads back as written";
    axis.step(200);
    EXPECT_EQ(axis.statusword(), 0x0E37) << "bit 11 at the limit, no warning";
  }
}

TEST_F(SoftwareLimits, SetBit11OnlyAtTheLimit) {
  EXPECT_FALSE(axis.limit_active());
  axis.write("position_user_target_value", 10'000);
  axis.controlword(0x003F);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    const bool at_limit = std::max(axis.demand(), axis.actual()) >= 5'000;
    ASSERT_EQ(axis.limit_active(), at_limit) << "tick " << i;
    const bool beyond = axis.actual() > 5'000;
    ASSERT_EQ((axis.statusword() & Statusword::kWarning) != 0, beyond) << "tick " << i;
  }
}

TEST_F(SoftwareLimits, ClampRelativeTargets) {
  start(4'000);
  run_to_target();
  start(3'000, 0x007F);
  run_to_target();
  EXPECT_EQ(axis.demand(), 5'000);
}

TEST_F(SoftwareLimits, WarnOutsideTheRangeAndAllowOnlyInwardMoves) {
  axis.write("app_position_limit_switch", 0);
  start(8'000);
  run_to_target();
  axis.step(200);
  axis.write("app_position_limit_switch", 1);
  axis.step();
  EXPECT_EQ(axis.statusword(), 0x0EB7) << "bit 11 and, beyond the limit, bit 7";
  start(9'000);
  run_to_target();
  EXPECT_EQ(axis.demand(), 5'000);
  start(0);
  run_to_target();
  EXPECT_EQ(axis.statusword(), 0x0637);
}

TEST_F(SoftwareLimits, AreOffWhenTheLowerIsNotBelowTheUpper) {
  for (const std::int64_t lower : {5'000, 6'000}) {
    axis.write("user_position_lower_limit", lower);
    start(20'000);
    run_to_target();
    EXPECT_EQ(axis.demand(), 20'000);
    EXPECT_FALSE(axis.limit_active());
    start(0);
    run_to_target();
  }
}

TEST_F(SoftwareLimits, DoNotLimitByDefault) {
  AxisConfiguration configuration;
  configuration.initial_position = std::numeric_limits<std::int32_t>::max();
  AxisUnderTest dut(configuration);
  dut.write("app_position_limit_switch", 1);
  dut.enable();
  EXPECT_EQ(dut.statusword(), 0x0637);
}

// ---- mode --------------------------------------------------------------------------------------

TEST_F(ProfilePosition, TheModeChangesWithinOneTickInEveryStateAtRest) {
  for (const unsigned word : {0x00U, 0x06U, 0x07U, 0x0FU}) {
    axis.command(static_cast<std::uint16_t>(word));
    axis.step(2);
    for (const std::int64_t mode : {1, 0, 1}) {
      axis.write("op_mode_cmd", mode);
      axis.step();
      EXPECT_EQ(axis.read("op_mode_actual"), mode) << "after controlword " << word;
    }
  }
}

TEST_F(ProfilePosition, TheModeChangesAtRestWithHaltSet) {
  axis.enable();
  axis.command(0x010F);
  axis.write("op_mode_cmd", 0);
  axis.step();
  EXPECT_EQ(axis.read("op_mode_actual"), 0);
}

TEST_F(ProfilePosition, WithoutAModeTheAxisIsEnabledButShowsNoModeBitsAndIgnoresEdges) {
  EXPECT_EQ(axis.command(0x000F), 0x0237);
  axis.write("position_user_target_value", 10'000);
  EXPECT_EQ(axis.command(0x003F), 0x0237);
  axis.step(100);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
}

TEST_F(ProfilePosition, AModeChangeInMotionBrakesFirstAndDropsTheQueue) {
  axis.enable();
  set_profile(20'000, 100'000, 100'000);
  start(100'000, 0x001F);
  start(120'000, 0x001F);
  axis.step(500);
  axis.write("op_mode_cmd", 0);
  axis.step();
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
  EXPECT_NEAR(axis.demand_velocity(), 19'900, 1) << "brakes with 6084h";
  axis.step(198);
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
  EXPECT_NE(axis.step_until(
                [this] {
                  return axis.read("op_mode_actual") == 0;
                },
                50),
            0U);
  EXPECT_EQ(axis.demand_velocity(), 0);
  axis.write("op_mode_cmd", 1);
  axis.step(2'000);
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
  EXPECT_EQ(axis.statusword(), 0x0637) << "at rest where it stopped, nothing restarts";
}

TEST_F(ProfilePosition, AModeChangeDoesNotMoveTheDemand) {
  axis.enable();
  start(10'000);
  run_to_target();
  axis.write("op_mode_cmd", 0);
  axis.step();
  axis.write("op_mode_cmd", 1);
  EXPECT_EQ(axis.step(), 0x0637);
  EXPECT_EQ(axis.demand(), 10'000);
  axis.step(100);
  EXPECT_EQ(axis.demand(), 10'000);
}

TEST_F(ProfilePosition, Bit12IsLowOnEnteringTheModeAndOnEveryEnable) {
  axis.enable();
  axis.write("position_user_target_value", 1'000);
  axis.command(0x001F);
  axis.step(500);
  EXPECT_TRUE(axis.acknowledged());
  axis.command(0x0016);
  EXPECT_FALSE(axis.acknowledged());
  axis.command(0x001F);
  EXPECT_FALSE(axis.acknowledged()) << "bit 4 was high before: no edge";
}

// ---- speed and ramp limits ---------------------------------------------------------------------

TEST_F(ProfilePosition, TheSpeedLimitCapsTheMotionButNot6081h) {
  axis.write("profile_velocity", 200'000);
  axis.write("profile_acc", 10'000'000);
  axis.enable();
  start(1'000'000);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 136'533) << "607Fh";
  EXPECT_EQ(axis.read("profile_velocity"), 200'000);
}

TEST_F(ProfilePosition, TheMotorSpeedBoundsTheSpeedLimit) {
  axis.write("app_speed_limit", 4'000'000'000);
  axis.write("motor_max_speed_rpm", 1'000);
  axis.write("profile_velocity", 200'000);
  axis.write("profile_acc", 10'000'000);
  axis.enable();
  start(1'000'000);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 68'267);  // 1000·4096/60 = 68266.67
}

/// An axis with a ten-to-one reduction gear and a motor that may turn at 60 rpm.
AxisConfiguration slow_motor_behind_a_gear(Feedback feedback) {
  AxisConfiguration configuration;
  configuration.model.feedback = feedback;
  configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_numerator"), 1},
                              {AxisUnderTest::address_of("gear_ratio_denominator"), 10},
                              {AxisUnderTest::address_of("motor_max_speed_rpm"), 60},
                              {AxisUnderTest::address_of("profile_acc"), 10'000'000}};
  return configuration;
}

/// Starts a move that outlasts each of these tests.
void start_long_move(AxisUnderTest& axis) {
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x003F);
}

// Two encoders: 6064h counts at the load, which turns at a tenth of 60 rpm: 6 x 4096 / 60 = 409.6
// UU/s. One encoder: 6064h counts at the motor: 60 x 4096 / 60 = 4096 UU/s.
TEST(MotorSpeed, BoundsTheMotorNotTheLoad) {
  const std::vector<std::pair<Feedback, std::int32_t>> rows{{Feedback::dual_encoder, 410},
                                                            {Feedback::single_encoder, 4'096}};
  for (const auto& [feedback, speed] : rows) {
    SCOPED_TRACE(to_string(feedback));
    AxisUnderTest axis(slow_motor_behind_a_gear(feedback));
    axis.enable();
    start_long_move(axis);
    axis.step(2'000);
    EXPECT_EQ(axis.demand_velocity(), speed);
    // 3574h counts 4096 UU per revolution of the motor: 60 rpm.
    EXPECT_NEAR(static_cast<double>(axis.read("motor_velocity_actual_value")), 4'096.0, 60.0);
  }
}

// The gear takes effect immediately, 6080h at enabling. 1:5 of 4096 UU/s at the motor: 819.2 UU/s.
TEST(MotorSpeed, HoldsWhenTheGearChangesInMotion) {
  AxisUnderTest axis(slow_motor_behind_a_gear(Feedback::dual_encoder));
  axis.enable();
  axis.write("motor_max_speed_rpm", 2'000);
  start_long_move(axis);
  axis.step(2'000);
  EXPECT_EQ(axis.demand_velocity(), 410);
  axis.write("gear_ratio_denominator", 5);
  axis.step(1'000);
  EXPECT_EQ(axis.demand_velocity(), 819);
}

// 5E11h follows 6080h and the gear immediately; the next enabling will use the same values.
TEST(MotorSpeed, IsReadInTheUnitsOfThePosition) {
  AxisUnderTest plain;
  EXPECT_EQ(plain.read("motor_speed_limit"), 136'533);  // 2000 x 4096 / 60 = 136533.33
  plain.write("motor_max_speed_rpm", 4'294'967'295);
  EXPECT_EQ(plain.read("motor_speed_limit"), 4'294'967'295) << "as much as the object can show";
  AxisUnderTest axis(slow_motor_behind_a_gear(Feedback::dual_encoder));
  EXPECT_EQ(axis.read("motor_speed_limit"), 409);
  axis.write("gear_ratio_denominator", 20);
  EXPECT_EQ(axis.read("motor_speed_limit"), 204);  // 204.8
  AxisUnderTest single(slow_motor_behind_a_gear(Feedback::single_encoder));
  EXPECT_EQ(single.read("motor_speed_limit"), 4'096);
}

TEST_F(ProfilePosition, TheAccelerationLimitsCapTheRampsAndKeepTheRegisterValues) {
  axis.write("app_acc_limit", 50'000);
  axis.write("app_dec_limit", 20'000);
  axis.enable();
  set_profile(20'000, 100'000, 100'000);
  start(1'000'000);
  EXPECT_EQ(axis.read("profile_acc"), 100'000);
  axis.step(98);  // tick 100
  EXPECT_NEAR(axis.demand_velocity(), 5'000, 1);
  axis.step(400);
  ASSERT_EQ(axis.demand_velocity(), 20'000);
  axis.command(0x010F);
  axis.step(99);
  EXPECT_NEAR(axis.demand_velocity(), 18'000, 1);
}

TEST_F(ProfilePosition, RampsAndLimitsOf0CountAs1) {
  for (const auto& [object, value] : {std::tuple{"profile_acc", 0}, std::tuple{"app_acc_limit", 0},
                                      std::tuple{"profile_acc", 1}}) {
    AxisUnderTest dut;
    dut.write(object, value);
    dut.enable();
    dut.write("position_user_target_value", 1'000);
    dut.command(0x003F);
    dut.step(9'999);  // 10 s at 1/s²
    EXPECT_EQ(dut.demand_velocity(), 10) << object << " = " << value;
    EXPECT_EQ(dut.demand(), 50) << object << " = " << value;
  }
}

TEST_F(ProfilePosition, TheDecelerationTakesEffectDuringMotion) {
  axis.enable();
  set_profile(20'000, 1'000'000, 1'000'000);
  start(50'000);
  axis.step(500);
  // From 20000/s at 20000/s² the stop takes 1 s and 10000 units: it begins at 40000.
  axis.write("profile_dec", 20'000);
  axis.step_until(
      [this] {
        return axis.demand_velocity() < 20'000;
      },
      5'000);
  EXPECT_NEAR(axis.demand(), 40'000, 25);
  run_to_target();
  EXPECT_EQ(axis.demand(), 50'000);
}

TEST_F(ProfilePosition, ATooSmallDecelerationOvershootsAndReturns) {
  axis.enable();
  set_profile(20'000, 1'000'000, 100'000);
  start(50'000);
  axis.step_until(
      [this] {
        return axis.demand() > 49'000;
      },
      5'000);
  axis.write("profile_dec", 10'000);
  std::int32_t farthest = 0;
  axis.step_until(
      [&] {
        farthest = std::max(farthest, axis.demand());
        return axis.reached();
      },
      10'000);
  EXPECT_GT(farthest, 50'500);
  EXPECT_EQ(axis.demand(), 50'000);
}

TEST_F(ProfilePosition, WithoutPowerTheDemandFollowsTheActualPosition) {
  axis.enable();
  start(100'000);
  axis.step(300);
  axis.command(0x0000);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    ASSERT_EQ(axis.demand(), axis.actual());
    ASSERT_EQ(axis.demand_velocity(), 0);
  }
}

}  // namespace
}  // namespace vdrive
