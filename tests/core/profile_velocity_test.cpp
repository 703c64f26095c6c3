// SPDX-License-Identifier: Apache-2.0
// Profile velocity mode (6060h = 3): ramps, caps, status bits, stops.
#include "core/support/axis_under_test.hpp"
#include "support/random_cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using test::Random;
using enum PowerState;

constexpr std::uint16_t kBits = 0x1400;  // 12 speed zero, 10 target reached

/// Profile velocity, Operation enabled, at rest.
void enable_profile_velocity(AxisUnderTest& axis) {
  axis.write("op_mode_cmd", 3);
  axis.command(0x000F);
}

/// Ramps that cannot be confused: 1000, 50, 100 and 200 UU/s per tick.
void set_ramps(AxisUnderTest& axis) {
  axis.write("profile_acc", 1'000'000);
  axis.write("profile_dec", 50'000);
  axis.write("quick_stop_deceleration", 100'000);
  axis.write("app_dec_limit", 200'000);
}

std::int32_t ramp_of_quick_stop(std::int64_t option) {
  constexpr std::array<std::int32_t, 5> kRamps{0, 50'000, 100'000, 200'000, 200'000};
  return kRamps.at(static_cast<std::size_t>(option));
}

void run_at(AxisUnderTest& axis, std::int32_t speed) {
  set_ramps(axis);
  enable_profile_velocity(axis);
  axis.write("target_velocity", speed);
  axis.step(400);
  ASSERT_EQ(axis.demand_velocity(), speed);
  ASSERT_NEAR(axis.velocity(), speed, 100);
}

/// Checks that 606Bh falls by `ramp`/1000 in each of the next ticks.
void expect_ramp(AxisUnderTest& axis, std::int32_t from, std::int32_t ramp, int ticks) {
  const int sign = from < 0 ? -1 : 1;
  for (int tick = 1; tick <= ticks; ++tick) {
    axis.step();
    const std::int32_t left = std::max(std::abs(from) - tick * ramp / 1'000, 0);
    ASSERT_NEAR(axis.demand_velocity(), sign * left, 1) << "tick " << tick;
  }
}

// ---- ramps -------------------------------------------------------------------------------------

TEST(ProfileVelocity, ATargetActsAtOnceWithoutAnEdge) {
  AxisUnderTest axis;
  enable_profile_velocity(axis);
  axis.write("target_velocity", 20'000);
  axis.step();
  EXPECT_EQ(axis.demand_velocity(), 410) << "409600 UU/s² for 1 ms";
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 20'000);
  EXPECT_EQ(axis.status().ignored_set_points, 0U);
}

TEST(ProfileVelocity, SpeedsUpWith6083hAndSlowsDownWith6084h) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("profile_acc", 200'000);
    axis.write("profile_dec", 100'000);
    enable_profile_velocity(axis);
    axis.write("target_velocity", sign * 20'000);
    for (int tick = 1; tick <= 100; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand_velocity(), sign * 200 * tick);
    }
    axis.step(50);
    axis.write("target_velocity", sign * 5'000);
    for (int tick = 1; tick <= 150; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand_velocity(), sign * (20'000 - 100 * tick));
    }
    axis.step();
    EXPECT_EQ(axis.demand_velocity(), sign * 5'000);
  }
}

TEST(ProfileVelocity, AReversalBrakesWith6084hAndSpeedsUpWith6083h) {
  AxisUnderTest axis;
  axis.write("profile_acc", 200'000);
  axis.write("profile_dec", 100'000);
  enable_profile_velocity(axis);
  axis.write("target_velocity", 10'000);
  axis.step(100);
  axis.write("target_velocity", -10'000);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 0);
  axis.step(50);
  EXPECT_EQ(axis.demand_velocity(), -10'000);
}

TEST(ProfileVelocity, RampsAreCappedBy60C5hAnd60C6hAndKeepTheirRegisterValues) {
  AxisUnderTest axis;
  axis.write("profile_acc", 500'000);
  axis.write("profile_dec", 500'000);
  axis.write("app_acc_limit", 100'000);
  axis.write("app_dec_limit", 50'000);
  enable_profile_velocity(axis);
  axis.write("target_velocity", 10'000);
  axis.step(50);
  EXPECT_EQ(axis.demand_velocity(), 5'000);
  axis.step(100);
  axis.write("target_velocity", 0);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 5'000);
  EXPECT_EQ(axis.read("profile_acc"), 500'000);
}

TEST(ProfileVelocity, RampsTakeEffectDuringMotionAnd0CountsAs1) {
  AxisUnderTest axis;
  enable_profile_velocity(axis);
  axis.write("profile_acc", 100'000);
  axis.write("target_velocity", 50'000);
  axis.step(100);
  ASSERT_EQ(axis.demand_velocity(), 10'000);
  axis.write("profile_acc", 200'000);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 30'000);
  axis.write("profile_acc", 0);
  axis.step(1'000);
  EXPECT_EQ(axis.demand_velocity(), 30'001) << "1 UU/s²";
}

TEST(ProfileVelocity, TheSpeedIsCappedBy607FhAfterEnabling) {
  AxisUnderTest axis;
  enable_profile_velocity(axis);
  axis.write("app_speed_limit", 5'000);
  axis.write("target_velocity", 200'000);
  axis.step(1'000);
  EXPECT_EQ(axis.demand_velocity(), 136'533) << "607Fh of the last enable";
  axis.write("target_velocity", 0);
  axis.step(1'000);
  axis.command(0x0007);
  axis.step(5);
  axis.command(0x000F);
  axis.write("target_velocity", -200'000);
  axis.step(1'000);
  EXPECT_EQ(axis.demand_velocity(), -5'000);
  EXPECT_EQ(axis.read("target_velocity"), -200'000) << "the value is not altered";
  EXPECT_FALSE(axis.reached()) << "606Ch is not 60FFh";
}

TEST(ProfileVelocity, EnablingWithATargetRampsUpFromRest) {
  AxisUnderTest axis;
  axis.write("target_velocity", 20'000);
  axis.step(10);
  EXPECT_EQ(axis.velocity(), 0) << "without power";
  axis.write("op_mode_cmd", 3);
  axis.command(0x000F);
  EXPECT_EQ(axis.demand_velocity(), 410);
  EXPECT_EQ(axis.statusword() & 0x0400, 0);
  axis.step(200);
  EXPECT_EQ(axis.demand_velocity(), 20'000);
}

TEST(ProfileVelocity, TheActualSpeedFollowsTheDemandUnderLoad) {
  for (const std::int64_t load : {0, 1'500, -1'500}) {  // half of the rated torque
    AxisUnderTest axis;
    axis.write("test_load_torque", load);
    enable_profile_velocity(axis);
    axis.write("target_velocity", 30'000);
    axis.step(1'000);
    EXPECT_NEAR(axis.velocity(), 30'000, 5) << load;
    axis.write("target_velocity", 0);
    axis.step(1'000);
    EXPECT_NEAR(axis.velocity(), 0, 5) << load;
  }
}

TEST(ProfileVelocity, HasNoFollowingErrorAndABlockedAxisShowsItsTorque) {
  AxisUnderTest axis;
  enable_profile_velocity(axis);
  axis.write("test_blocked_load", 1);
  axis.write("target_velocity", 100'000);
  axis.step(3'000);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.read("error_code"), 0);
  EXPECT_EQ(axis.status().torque_actual_value, 3'000) << "6072h: 300 % of the rated torque";
  EXPECT_EQ(axis.status().load_position_error_value, 0);
  axis.write("test_blocked_load", 0);
  axis.step(1'000);
  EXPECT_NEAR(axis.velocity(), 100'000, 10);
}

TEST(ProfileVelocity, TheDemand6062hFollows6064h) {
  AxisUnderTest axis;
  enable_profile_velocity(axis);
  axis.write("target_velocity", -12'345);
  for (int i = 0; i < 500; ++i) {
    axis.step();
    ASSERT_EQ(axis.demand(), axis.actual());
  }
}

TEST(ProfileVelocity, PositionsWrapAtTheEndsOfTheRegister) {
  for (const int sign : {1, -1}) {
    AxisConfiguration configuration;
    configuration.initial_position = sign * 2'147'480'000;
    AxisUnderTest axis(configuration);
    enable_profile_velocity(axis);
    axis.write("target_velocity", sign * 100'000);
    std::uint32_t last = static_cast<std::uint32_t>(axis.actual());
    for (int i = 0; i < 1'000; ++i) {
      axis.step();
      const auto now = static_cast<std::uint32_t>(axis.actual());
      const auto change = static_cast<std::int32_t>(now - last);
      ASSERT_GE(sign * change, 0);
      ASSERT_LE(sign * change, 102);
      last = now;
    }
    EXPECT_LT(sign * static_cast<std::int64_t>(axis.actual()), 0);
    // From here profile position reaches its targets.
    axis.write("op_mode_cmd", 1);
    ASSERT_NE(axis.step_until(
                  [&axis] {
                    return axis.read("op_mode_actual") == 1;
                  },
                  2'000),
              0U);
    const std::int32_t target = axis.actual() + sign * 1'000;
    axis.write("position_user_target_value", target);
    axis.command(0x001F);
    axis.step(500);
    EXPECT_EQ(axis.actual(), target);
  }
}

TEST(ProfileVelocity, RunsManyTimesAcrossTheRangeOfTheRegister) {
  AxisConfiguration configuration;
  configuration.parameters = {{AxisUnderTest::address_of("motor_max_speed_rpm"), 30'000'000},
                              {AxisUnderTest::address_of("app_speed_limit"), 2'000'000'000},
                              {AxisUnderTest::address_of("profile_acc"), 2'000'000'000},
                              {AxisUnderTest::address_of("max_torque"), 65'535}};
  configuration.model.viscous_friction = 0.0;
  AxisUnderTest axis(configuration, std::chrono::microseconds{10'000});
  enable_profile_velocity(axis);
  axis.write("target_velocity", 65'000'000);  // 952,148 rpm: below the bound of the model
  axis.step(20'000);                          // 200 s: 13e9 UU, three times 2^32
  EXPECT_NEAR(axis.velocity(), 65'000'000, 65'000);
  axis.write("profile_dec", 100'000'000);
  axis.write("target_velocity", 0);
  axis.step(1'200);
  EXPECT_NEAR(axis.velocity(), 0, 10);
  EXPECT_EQ(axis.demand(), axis.actual());
}

// ---- status bits -------------------------------------------------------------------------------

TEST(ProfileVelocity, Bit10ShowsTheSpeedInTheWindow606DhForTheTime606Eh) {
  AxisUnderTest axis;
  axis.write("velocity_window", 500);
  axis.write("velocity_window_time", 30);
  enable_profile_velocity(axis);
  EXPECT_EQ(axis.statusword() & kBits, kBits) << "enabled at rest with 60FFh = 0";
  axis.write("target_velocity", 30'000);
  std::uint64_t inside = 0;
  bool rose = false;
  for (int i = 0; i < 400; ++i) {
    axis.step();
    inside = std::abs(axis.velocity() - 30'000) <= 500 ? inside + 1 : 0;
    // In the 31st tick the speed has been inside for longer than 30 ms.
    ASSERT_EQ(axis.reached(), inside > 30) << i;
    rose = rose || axis.reached();
  }
  EXPECT_TRUE(rose);
  axis.write("target_velocity", 31'000);
  axis.step();
  EXPECT_FALSE(axis.reached());
}

TEST(ProfileVelocity, Bit12ShowsASpeedOfAtMost606FhForTheTime6070h) {
  AxisUnderTest axis;
  axis.write("velocity_threshold", 1'000);
  axis.write("velocity_threshold_time", 25);
  enable_profile_velocity(axis);
  axis.write("target_velocity", 20'000);
  axis.step(300);
  EXPECT_EQ(axis.statusword() & 0x1000, 0);
  axis.write("target_velocity", 0);
  std::uint64_t inside = 0;
  for (int i = 0; i < 300; ++i) {
    axis.step();
    inside = std::abs(axis.velocity()) <= 1'000 ? inside + 1 : 0;
    ASSERT_EQ((axis.statusword() & 0x1000) != 0, inside > 25) << i;
  }
  EXPECT_NE(axis.statusword() & 0x1000, 0);
}

TEST(ProfileVelocity, Bits10And12AreSetInOperationEnabledOnly) {
  AxisUnderTest axis;
  enable_profile_velocity(axis);
  EXPECT_EQ(axis.statusword(), 0x1637);
  EXPECT_EQ(axis.command(0x0006), 0x0231);
  EXPECT_EQ(axis.command(0x0000), 0x0250);
}

// ---- halt and stops ----------------------------------------------------------------------------

class VelocityStop : public testing::TestWithParam<std::int64_t> {};

TEST_P(VelocityStop, HaltBrakesWithTheRampOf605DhAndTheTargetReturns) {
  for (const std::int32_t speed : {40'000, -40'000}) {
    AxisUnderTest axis;
    axis.write("halt_option_code", GetParam());
    ASSERT_NO_FATAL_FAILURE(run_at(axis, speed));
    axis.controlword(0x010F);
    const int ticks = 40'000 / (ramp_of_quick_stop(GetParam()) / 1'000);
    ASSERT_NO_FATAL_FAILURE(expect_ramp(axis, speed, ramp_of_quick_stop(GetParam()), ticks - 1));
    EXPECT_FALSE(axis.reached()) << "still braking";
    axis.step(100);
    EXPECT_EQ(axis.statusword(), 0x1637) << "at rest bit 10 = 1";
    axis.command(0x000F);
    EXPECT_EQ(axis.statusword() & 0x0400, 0);
    axis.step(300);
    EXPECT_EQ(axis.demand_velocity(), speed);
  }
}

INSTANTIATE_TEST_SUITE_P(Options, VelocityStop, testing::Values(1, 2, 3, 4),
                         testing::PrintToStringParamName());

// ---- limit switches ----------------------------------------------------------------------------

TEST(ProfileVelocity, ALimitSwitchStopsWith6085hAndOnlyANewTargetStartsAgain) {
  for (const int sign : {1, -1}) {
    SCOPED_TRACE(sign);
    const char* const input = sign > 0 ? "test_positive_limit_input" : "test_negative_limit_input";
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(run_at(axis, sign * 40'000));
    axis.write(input, 1);
    ASSERT_NO_FATAL_FAILURE(expect_ramp(axis, sign * 40'000, 100'000, 200));
    EXPECT_TRUE(axis.limit_active());
    axis.step(400);
    EXPECT_EQ(axis.demand_velocity(), 0);
    EXPECT_FALSE(axis.reached()) << "60FFh is not the speed";
    axis.write("target_velocity", sign * 30'000);
    axis.step(100);
    EXPECT_EQ(axis.demand_velocity(), 0) << "not into the switch";
    axis.write(input, 0);
    axis.step(100);
    EXPECT_EQ(axis.demand_velocity(), 0) << "nothing resumes when the switch opens";
    axis.write("target_velocity", sign * 30'000);
    axis.step(100);
    EXPECT_EQ(axis.demand_velocity(), sign * 30'000);
  }
}

TEST(ProfileVelocity, ALimitSwitchAllowsMotionAwayFromIt) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run_at(axis, 40'000));
  axis.write("test_positive_limit_input", 1);
  axis.write("target_velocity", -10'000);
  axis.step(100);
  EXPECT_NEAR(axis.demand_velocity(), 30'000, 1) << "6085h, not 6084h";
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), -10'000);
}

TEST(ProfileVelocity, ALimitSwitchOfTheOtherSideHasNoEffect) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run_at(axis, 40'000));
  axis.write("test_negative_limit_input", 1);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 40'000);
}

TEST(ProfileVelocity, ATargetVelocityHasNoEffectInAnotherMode) {
  AxisUnderTest axis;
  set_ramps(axis);
  axis.enable();
  axis.write("position_user_target_value", 1'000'000);
  axis.write("profile_velocity", 40'000);
  axis.command(0x001F);
  axis.step(200);
  axis.write("test_positive_limit_input", 1);
  axis.step(100);
  axis.write("test_positive_limit_input", 0);
  axis.write("target_velocity", 10'000);
  axis.write("target_torque", 100);
  axis.step(100);
  EXPECT_NEAR(axis.demand_velocity(), 20'000, 1) << "the stop continues with 6085h";
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), 0);
}

// ---- mode change -------------------------------------------------------------------------------

TEST(ProfileVelocity, ALimitSwitchOverridesAModeChange) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(run_at(axis, 20'000));
  axis.write("op_mode_cmd", 1);
  axis.write("test_positive_limit_input", 1);
  ASSERT_NO_FATAL_FAILURE(expect_ramp(axis, 20'000, 100'000, 199));
}

TEST(ProfileVelocity, AChangeToProfilePositionAndBackMakesNoJump) {
  AxisUnderTest axis;
  axis.write("position_user_target_value", 123'456);
  ASSERT_NO_FATAL_FAILURE(run_at(axis, 20'000));
  std::int32_t last = axis.actual();
  const auto step = [&axis, &last](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      axis.step();
      ASSERT_LE(std::abs(axis.actual() - last), 22);
      ASSERT_LE(std::abs(axis.demand() - axis.actual()), 200);
      last = axis.actual();
    }
  };
  axis.write("op_mode_cmd", 1);
  ASSERT_NO_FATAL_FAILURE(step(700));
  ASSERT_EQ(axis.read("op_mode_actual"), 1);
  EXPECT_EQ(axis.statusword(), 0x0637) << "the target is where the axis stands";
  EXPECT_EQ(axis.demand(), axis.actual());
  axis.write("target_velocity", 0);
  axis.write("op_mode_cmd", 3);
  ASSERT_NO_FATAL_FAILURE(step(100));
  EXPECT_EQ(axis.statusword(), 0x1637);
}

// ---- properties --------------------------------------------------------------------------------

/// Any target, ramp, halt or limit at any time: the demand never changes by more than the steepest
/// ramp of the tick allows.
TEST(ProfileVelocity, TheDemandNeverStepsInRandomSequences) {
  const std::uint64_t rounds = test::case_count(60, 3'000);
  for (std::uint64_t seed = 0; seed < rounds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    AxisConfiguration configuration;
    configuration.model.coupling = seed % 2 == 0 ? Coupling::rigid : Coupling::two_inertia;
    AxisUnderTest axis(configuration);
    constexpr std::array<std::int64_t, 4> kRamps{50'000, 100'000, 200'000, 400'000};
    set_ramps(axis);
    axis.write("profile_acc", 400'000);
    enable_profile_velocity(axis);
    std::int32_t last = 0;
    for (int i = 0; i < 3'000; ++i) {
      if (random.one_in(40)) {
        switch (random.below(7)) {
          case 0:
            axis.controlword(random.one_in(2) ? 0x010F : 0x000F);
            break;
          case 1:
            axis.write("profile_acc", kRamps.at(random.below(4)));
            break;
          case 2:
            axis.write("profile_dec", kRamps.at(random.below(4)));
            break;
          case 3:
            axis.write("halt_option_code", static_cast<std::int64_t>(1 + random.below(4)));
            break;
          case 4:
            axis.write("test_positive_limit_input", static_cast<std::int64_t>(random.below(2)));
            break;
          case 5:
            axis.write("test_negative_limit_input", static_cast<std::int64_t>(random.below(2)));
            break;
          default:
            axis.write("target_velocity", static_cast<std::int32_t>(random.word()));
            break;
        }
      }
      axis.step();
      ASSERT_LE(std::abs(axis.demand_velocity() - last), 401) << "tick " << i;
      ASSERT_LE(std::abs(axis.demand_velocity()), 136'533);
      ASSERT_LE(std::abs(axis.velocity()), 145'000);
      last = axis.demand_velocity();
    }
  }
}

}  // namespace
}  // namespace vdrive
