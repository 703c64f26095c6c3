// SPDX-License-Identifier: Apache-2.0
// The effects of a real axis: weight, holding brake, cogging, torque ripple, encoder noise, end
// stops, heat of the motor. Figures are derived by hand from the SI parameters; 4096 user units are
// one revolution, the rated torque 6076h is 3 N.m, the rated current 6075h is 5 A.
#include "plant/effects.hpp"

#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/plant/model_parameters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using test::kUnitsPerRadian;

/// Motor and load of 3e-4 kg.m2 each, no friction.
AxisConfiguration smooth_axis(Coupling coupling = Coupling::rigid) {
  AxisConfiguration configuration;
  configuration.model.coupling = coupling;
  configuration.model.viscous_friction = 0.0;
  configuration.model.coulomb_friction = 0.0;
  return configuration;
}

/// Enabled in profile position mode, at rest at `position`.
void stand_at(AxisUnderTest& axis, std::int32_t position) {
  axis.enable();
  axis.write("position_user_target_value", position);
  axis.command(0x003F);
  axis.step(4'000);
  ASSERT_EQ(axis.actual(), position);
}

// ---- gravity -----------------------------------------------------------------------------------

TEST(Gravity, LetsAnAxisWithoutPowerFallWithTorqueOverInertia) {
  AxisConfiguration configuration = smooth_axis();
  configuration.model.gravity_torque = -0.3;  // on 6e-4 kg.m2: -500 rad/s²
  AxisUnderTest axis(configuration);
  const double acceleration = -500.0 * kUnitsPerRadian;
  axis.step(200);
  EXPECT_NEAR(axis.actual(), 0.5 * acceleration * 0.04, 1.0);
  // 606Ch is the mean of the last millisecond.
  EXPECT_NEAR(axis.velocity(), acceleration * 0.1995, 2.0);
}

TEST(Gravity, IsHeldAtStandstillWithTheTorqueThatItNeeds) {
  for (const Coupling coupling : {Coupling::rigid, Coupling::two_inertia}) {
    AxisConfiguration configuration = smooth_axis(coupling);
    configuration.model.gravity_torque = -0.6;  // of 3 N.m: 20 %, and 1 A of 5 A
    AxisUnderTest axis(configuration);
    axis.enable();
    axis.step(3'000);
    EXPECT_NEAR(axis.status().torque_actual_value, 200, 1);
    EXPECT_NEAR(axis.status().current_actual_value, 200, 1);
    EXPECT_NEAR(axis.actual(), 0, 1);
  }
}

TEST(Gravity, ActsAtTheLoadBehindTheGear) {
  AxisConfiguration configuration = smooth_axis();
  configuration.model.gravity_torque = -0.6;
  configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_denominator"), 2}};
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.step(3'000);
  EXPECT_NEAR(axis.status().torque_actual_value, 100, 1) << "half of it at the motor";
}

TEST(Gravity, AddsToTheTestLoadTorque) {
  AxisConfiguration configuration = smooth_axis();
  configuration.model.gravity_torque = -0.6;
  AxisUnderTest axis(configuration);
  axis.write("test_load_torque", 600);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), 0);
}

// ---- holding brake -----------------------------------------------------------------------------

/// A vertical axis that falls with -1000 rad/s², with a brake.
AxisConfiguration braked_axis(double brake_torque, Coupling coupling = Coupling::rigid) {
  AxisConfiguration configuration = smooth_axis(coupling);
  configuration.model.gravity_torque = -0.6;
  configuration.model.brake_torque = brake_torque;
  return configuration;
}

TEST(HoldingBrake, HoldsAVerticalAxisWithoutPower) {
  AxisUnderTest axis(braked_axis(1.0));
  for (int tick = 0; tick < 2'000; ++tick) {
    axis.step();
    ASSERT_EQ(axis.actual(), 0);
    ASSERT_EQ(axis.velocity(), 0);
  }
}

TEST(HoldingBrake, HoldsTheMotorOfAnElasticAxis) {
  // At first the weight drops onto the shaft, which doubles its 0.6 N.m.
  AxisUnderTest axis(braked_axis(2.0, Coupling::two_inertia));
  axis.step(2'000);
  EXPECT_EQ(axis.status().motor_position_actual_value, 0);
  // The weight twists the shaft of 2000 N.m/rad by 3e-4 rad = 0.2 UU.
  EXPECT_NEAR(axis.actual(), 0, 1);
}

TEST(HoldingBrake, LetsTheLoadOfAnElasticAxisHangOnItsShaft) {
  // However strong the brake is, the shaft of 20 N.m/rad carries the 0.6 N.m: 0.03 rad = 19.6 UU.
  for (const double brake_torque : {2.0, 20.0, 200.0}) {
    AxisConfiguration configuration = braked_axis(brake_torque, Coupling::two_inertia);
    configuration.model.coupling_stiffness = 20.0;
    AxisUnderTest axis(configuration);
    axis.step(2'000);
    EXPECT_EQ(axis.status().motor_position_actual_value, 0) << brake_torque;
    EXPECT_NEAR(axis.actual(), -0.03 * kUnitsPerRadian, 1.0) << brake_torque;
  }
}

TEST(HoldingBrake, SlipsUnderMoreThanItsTorque) {
  AxisUnderTest axis(braked_axis(0.5));
  axis.step(200);
  // 0.1 N.m remain for 6e-4 kg.m2: 166.7 rad/s².
  EXPECT_NEAR(axis.actual(), -0.5 * (1.0 / 6.0e-3) * kUnitsPerRadian * 0.04, 1.5);
}

TEST(HoldingBrake, MeetsTheLoadOfAGearThatIsSetWhileItIsClosed) {
  AxisConfiguration configuration = smooth_axis();
  configuration.model.gravity_torque = -0.3;
  configuration.model.brake_torque = 0.4;
  AxisUnderTest axis(configuration);
  axis.step(1'000);
  ASSERT_EQ(axis.status().motor_position_actual_value, 0);
  axis.write("gear_ratio_numerator", 2);
  axis.step(200);
  // At the motor the weight is now 0.6 N.m, and the inertia of the load four times its 3e-4 kg.m2:
  // 0.2 N.m remain for 15e-4 kg.m2.
  EXPECT_NEAR(axis.status().motor_position_actual_value,
              -0.5 * (0.2 / 15.0e-4) * kUnitsPerRadian * 0.04, 1.5);
}

TEST(HoldingBrake, OpensItsReleaseTimeAfterThePowerStageIsOn) {
  AxisConfiguration configuration = braked_axis(2.0);
  configuration.model.brake_release_time = 0.05;
  AxisUnderTest axis(configuration);
  axis.step(100);
  axis.enable();  // the first of 50 ticks
  for (int tick = 2; tick <= 50; ++tick) {
    ASSERT_EQ(axis.actual(), 0) << tick;
    ASSERT_EQ(axis.status().torque_actual_value, 0) << "the brake holds the weight, " << tick;
    axis.step();
  }
  EXPECT_EQ(axis.status().torque_actual_value, 0);
  axis.step(10);
  EXPECT_GT(axis.status().torque_actual_value, 20) << "the motor takes the weight over";
  axis.step(3'000);
  EXPECT_NEAR(axis.status().torque_actual_value, 200, 1);
  EXPECT_NEAR(axis.actual(), 0, 1);
}

TEST(HoldingBrake, CatchesAFallingAxisItsEngageTimeAfterThePowerStageIsOff) {
  AxisConfiguration configuration = braked_axis(2.0);
  configuration.model.brake_engage_time = 0.03;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.step(3'000);
  axis.command(0x0000);
  axis.step(500);
  // 30 ms of free fall at 1000 rad/s²: 30 rad/s and 0.45 rad. Then 2 - 0.6 N.m brake at 2333
  // rad/s²: another 30²/(2·2333) = 0.1929 rad.
  EXPECT_NEAR(axis.actual(), -(0.45 + 0.1929) * kUnitsPerRadian, 4.0);
  const std::int32_t rest = axis.actual();
  axis.step(2'000);
  EXPECT_EQ(axis.actual(), rest);
  EXPECT_EQ(axis.velocity(), 0);
}

TEST(HoldingBrake, StaysClosedWhenThePowerGoesBeforeItHasOpened) {
  AxisConfiguration configuration = braked_axis(2.0);
  configuration.model.brake_release_time = 0.05;
  configuration.model.brake_engage_time = 0.03;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.step(9);
  axis.command(0x0000);  // after 10 of 50 ticks
  for (int tick = 1; tick <= 200; ++tick) {
    ASSERT_EQ(axis.actual(), 0) << tick;
    ASSERT_EQ(axis.velocity(), 0) << tick;
    axis.step();
  }
  axis.enable();
  axis.step(49);
  EXPECT_EQ(axis.status().torque_actual_value, 0) << "its time begins anew with the next power on";
  axis.step(11);
  EXPECT_GT(axis.status().torque_actual_value, 20) << "the motor takes the weight over";
}

TEST(HoldingBrake, StaysOpenWhenThePowerComesBeforeItHasClosed) {
  AxisConfiguration configuration = smooth_axis();
  configuration.model.brake_torque = 2.0;
  configuration.model.brake_release_time = 0.05;
  configuration.model.brake_engage_time = 0.03;
  AxisUnderTest axis(configuration);
  axis.write("profile_acc", 100'000);
  axis.write("position_user_target_value", 50'000);
  axis.enable();
  axis.step(100);
  axis.command(0x0000);
  axis.step(9);
  axis.command(0x000F);  // after 10 of 30 ticks
  axis.controlword(0x003F);
  std::int32_t most = 0;  // [‰]
  for (int tick = 1; tick <= 40; ++tick) {
    axis.step();
    most = std::max<std::int32_t>(most, axis.status().torque_actual_value);
  }
  // 100,000 UU/s² are 153 rad/s², which take 0.092 N.m or 31 ‰ of 3 N.m. The closed brake would
  // take 667 ‰ and open in the 50th tick.
  EXPECT_NEAR(most, 31, 15);
  // The demand has moved 0.5 · 100,000 · 0.04² = 80 UU.
  EXPECT_NEAR(axis.actual(), 80, 10);
}

TEST(HoldingBrake, IsClosedInTheFirstTickWithPower) {
  AxisConfiguration configuration = braked_axis(2.0);
  configuration.model.brake_release_time = 0.05;
  AxisUnderTest axis(configuration);
  axis.enable();  // no tick without power has come before
  axis.step(48);
  EXPECT_EQ(axis.actual(), 0);
  EXPECT_EQ(axis.status().torque_actual_value, 0);
}

TEST(HoldingBrake, IsClosedFromPowerUpOnAndThroughAPowerCycle) {
  AxisConfiguration configuration = braked_axis(2.0);
  configuration.model.brake_engage_time = 5.0;
  AxisUnderTest axis(configuration);
  axis.step(100);
  EXPECT_EQ(axis.actual(), 0);
  axis.axis().power_cycle();
  axis.step(100);
  EXPECT_EQ(axis.actual(), 0);
}

TEST(HoldingBrake, DropsWhenAFaultTakesThePower) {
  AxisUnderTest axis(braked_axis(2.0));
  axis.enable();
  axis.step(3'000);
  axis.write("test_encoder_failure", 1);  // the axis cannot brake: the power is removed
  axis.step(1'000);
  EXPECT_NEAR(axis.actual(), 0, 3);
  EXPECT_EQ(axis.velocity(), 0);
}

// ---- cogging and torque ripple -----------------------------------------------------------------

// sine_of_turns() uses two parabolas, because the last bits of a sine differ between machines.
TEST(SineOfTurns, IsExactAtQuartersAndNearBetween) {
  EXPECT_EQ(sine_of_turns(0.0), 0.0);
  EXPECT_EQ(sine_of_turns(0.25), 1.0);
  EXPECT_EQ(sine_of_turns(0.5), 0.0);
  EXPECT_EQ(sine_of_turns(0.75), -1.0);
  EXPECT_EQ(sine_of_turns(-1000.25), -1.0);
  double worst = 0.0;
  for (int i = -20'000; i <= 20'000; ++i) {
    const double turns = i * 1.0e-4;
    worst =
        std::max(worst, std::abs(sine_of_turns(turns) - std::sin(2.0 * std::numbers::pi * turns)));
  }
  EXPECT_LE(worst, 0.0011);
  EXPECT_GE(worst, 0.0009) << "the figure in the documents";
}

AxisConfiguration cogging_axis(Coupling coupling = Coupling::rigid) {
  AxisConfiguration configuration = smooth_axis(coupling);
  configuration.model.cogging_torque = 0.3;
  configuration.model.cogging_periods = 1.0;
  return configuration;
}

TEST(Cogging, PullsTheMotorToTheBeginningOfAPeriod) {
  for (const Coupling coupling : {Coupling::rigid, Coupling::two_inertia}) {
    // At a quarter of a turn the full 0.3 N.m pull back, which is 10 % of 3 N.m; at an eighth,
    // sin(45°) of it, 70.7 ‰.
    struct Row {
      std::int32_t position;
      std::int32_t torque;  // [‰]
    };

    for (const Row& row : {Row{1'024, 100}, Row{-1'024, -100}, Row{512, 71}, Row{2'048, 0}}) {
      AxisUnderTest axis(cogging_axis(coupling));
      ASSERT_NO_FATAL_FAILURE(stand_at(axis, row.position));
      EXPECT_NEAR(axis.status().torque_actual_value, row.torque, 2) << row.position;
    }
  }
}

TEST(Cogging, StaysWithTheMotorWhenHomingMovesTheFrame) {
  AxisUnderTest axis(cogging_axis());
  ASSERT_NO_FATAL_FAILURE(stand_at(axis, 1'024));
  axis.write("homing_method", 35);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.command(0x001F);
  axis.step(500);
  ASSERT_EQ(axis.actual(), 0);
  EXPECT_NEAR(axis.status().torque_actual_value, 100, 2);
}

TEST(Cogging, HoldsAnAxisWithoutPowerAgainstLessThanItsTorque) {
  AxisConfiguration configuration = cogging_axis();
  configuration.model.viscous_friction = 0.05;
  AxisUnderTest axis(configuration);
  axis.write("test_load_torque", 150);
  axis.step(5'000);
  // Half of 0.3 N.m: sin(30°), a twelfth of a turn.
  EXPECT_NEAR(axis.actual(), 4'096.0 / 12.0, 2.0);
  axis.write("test_load_torque", 400);
  axis.step(5'000);
  EXPECT_GT(axis.actual(), 4'096) << "no place holds it any more";
}

TEST(TorqueRipple, IsAPartOfTheTorqueOfTheMotor) {
  AxisConfiguration configuration = smooth_axis();
  configuration.model.torque_ripple = 50.0;
  configuration.model.torque_ripple_periods = 1.0;
  // Against a load of 0.9 N.m, a quarter of a turn to each side of 0: -0.9 = T (1 ± 0.5).
  for (const int side : {1, -1}) {
    AxisUnderTest axis(configuration);
    ASSERT_NO_FATAL_FAILURE(stand_at(axis, side * 1'024));
    axis.write("test_load_torque", 900);
    axis.step(3'000);
    EXPECT_NEAR(axis.status().torque_actual_value, side > 0 ? -200 : -600, 3);
  }
}

// ---- encoder noise -----------------------------------------------------------------------------

/// These axes have no power; friction holds them.
std::vector<AxisConfiguration> noisy_axes(std::size_t count, double seed) {
  std::vector<AxisConfiguration> axes(count);
  for (std::size_t i = 0; i < count; ++i) {
    AxisModel& model = axes[i].model;
    model.coupling = i % 3 == 1 ? Coupling::two_inertia : Coupling::rigid;
    model.encoder_noise = 20.0;
    model.load_encoder_noise = 20.0;
    model.encoder_noise_seed = seed;
  }
  return axes;
}

std::uint64_t noise_hash(const std::vector<AxisConfiguration>& axes) {
  AxisBank bank(axes, microseconds{1000});
  for (int tick = 0; tick < 50; ++tick) bank.step();
  return bank.status_hash();
}

TEST(EncoderNoise, HasItsRootMeanSquareAndNoMean) {
  AxisConfiguration configuration;
  configuration.model.encoder_noise = 20.0;
  AxisUnderTest axis(configuration);
  constexpr int kTicks = 20'000;
  double sum = 0.0;
  double squares = 0.0;
  for (int tick = 0; tick < kTicks; ++tick) {
    axis.step();
    const double reading = axis.status().motor_position_actual_value;
    sum += reading;
    squares += reading * reading;
    ASSERT_EQ(axis.actual(), 0) << "encoder 2 has none";
  }
  // For 20,000 readings the mean is within 6 standard deviations of 20/√20000 = 0.14, the root mean
  // square within 6 of 20/√40000 = 0.1.
  EXPECT_NEAR(sum / kTicks, 0.0, 0.85);
  EXPECT_NEAR(std::sqrt(squares / kTicks), 20.0, 0.6);
}

TEST(EncoderNoise, IsThatOfTheMotorWhereThereIsOneEncoder) {
  AxisConfiguration configuration;
  configuration.model.feedback = Feedback::single_encoder;
  configuration.model.encoder_noise = 20.0;
  configuration.model.load_encoder_noise = 500.0;
  AxisUnderTest axis(configuration);
  int noisy = 0;
  for (int tick = 0; tick < 100; ++tick) {
    axis.step();
    ASSERT_EQ(axis.actual(), axis.status().motor_position_actual_value);
    ASSERT_EQ(axis.velocity(), axis.status().motor_velocity_actual_value);
    // The sum of four uniform parts: at most √12 = 3.5 times the root mean square.
    ASSERT_LE(std::abs(axis.actual()), 70) << "the noise of encoder 2 does not count";
    noisy += axis.actual() != 0 ? 1 : 0;
  }
  EXPECT_GE(noisy, 80);
}

TEST(EncoderNoise, IsTheSameForTheSameSeedAndAnotherForAnotherSeedAndAxis) {
  EXPECT_EQ(noise_hash(noisy_axes(13, 1.0)), noise_hash(noisy_axes(13, 1.0)));
  EXPECT_NE(noise_hash(noisy_axes(13, 1.0)), noise_hash(noisy_axes(13, 2.0)));
  AxisBank bank(noisy_axes(3, 1.0), microseconds{1000});
  int as_other_axis = 0;
  int as_other_encoder = 0;
  for (int tick = 0; tick < 50; ++tick) {
    bank.step();
    const std::int32_t reading = bank.status(0).motor_position_actual_value;
    as_other_axis += reading == bank.status(2).motor_position_actual_value ? 1 : 0;
    as_other_encoder += reading == bank.status(0).load_position_actual_value ? 1 : 0;
  }
  // For whole numbers with a deviation of 20, one pair in 70 is equal.
  EXPECT_LT(as_other_axis, 10);
  EXPECT_LT(as_other_encoder, 10);
}

// Random numbers are drawn for a whole block, and the profile segments of one axis divide the tick
// of all axes of its block.
TEST(EncoderNoise, OfAnAxisIsTheSameWhateverItsNeighboursDo) {
  std::vector<AxisConfiguration> axes = noisy_axes(1, 1.0);
  axes.front().model.encoder_noise = 0.05;
  axes.front().model.load_encoder_noise = 0.05;
  AxisBank alone(axes, microseconds{1000});
  axes.resize(8);
  axes[3].model.encoder_noise = 20.0;
  axes[4].model.brake_torque = 2.0;
  AxisBank among_others(axes, microseconds{1000});
  const auto write = [](AxisBank& bank, std::size_t axis, std::string_view object,
                        std::int64_t value) {
    ASSERT_EQ(bank.write(axis, AxisUnderTest::address_of(object), value), AbortCode::none);
  };
  const auto move = [&write](AxisBank& bank, std::size_t axis, std::int32_t target) {
    write(bank, axis, "op_mode_cmd", 1);
    write(bank, axis, "position_user_target_value", target);
    write(bank, axis, "ds402_controlword", 0x000F);
    write(bank, axis, "ds402_controlword", 0x003F);
  };
  for (int tick = 0; tick < 1'000; ++tick) {
    if (tick == 100) {
      move(alone, 0, 5'000);
      move(among_others, 0, 5'000);
    }
    if (tick % 37 == 0) move(among_others, 1 + static_cast<std::size_t>(tick) % 7, tick * 11);
    alone.step();
    among_others.step();
    for (const StatusMember& member : status_members()) {
      ASSERT_EQ(member.value(alone.status(0)), member.value(among_others.status(0)))
          << member.name << " in tick " << tick;
    }
  }
}

TEST(EncoderNoise, LetsAnEnabledAxisHoldItsPosition) {
  AxisConfiguration configuration;
  configuration.model.encoder_noise = 0.05;
  configuration.model.load_encoder_noise = 0.05;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.step(2'000);
  EXPECT_EQ(axis.state(), PowerState::operation_enabled);
  EXPECT_NEAR(axis.actual(), 0, 2);
}

// ---- end stops ---------------------------------------------------------------------------------

AxisConfiguration stopped_axis(Coupling coupling = Coupling::rigid) {
  AxisConfiguration configuration = smooth_axis(coupling);
  configuration.model.lower_end_stop = -500.0;
  configuration.model.upper_end_stop = 1'000.0;
  return configuration;
}

TEST(EndStop, CatchesTheLoadWithoutARebound) {
  AxisUnderTest axis(stopped_axis());
  axis.write("test_load_torque", 300);
  ASSERT_NE(axis.step_until(
                [&] {
                  return axis.actual() == 1'000;
                },
                1'000),
            0U);
  axis.step(2);
  for (int tick = 0; tick < 500; ++tick) {
    ASSERT_EQ(axis.actual(), 1'000) << tick;
    ASSERT_EQ(axis.velocity(), 0);
    axis.step();
  }
  axis.write("test_load_torque", -300);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), -500);
  EXPECT_EQ(axis.velocity(), 0);
}

// The motor swings on its shaft and may pull the load back from the stop for a while.
TEST(EndStop, IsNeverPassedByTheLoadOfAnElasticAxis) {
  AxisUnderTest axis(stopped_axis(Coupling::two_inertia));
  axis.write("test_load_torque", 300);
  for (int tick = 0; tick < 4'000; ++tick) {
    axis.step();
    ASSERT_LE(axis.actual(), 1'000) << tick;
  }
  EXPECT_NEAR(axis.actual(), 1'000, 1);
  EXPECT_NEAR(axis.status().motor_position_actual_value, 1'000, 1);
}

TEST(EndStop, IsWhereTheLoadIsBehindAGear) {
  for (const Feedback feedback : {Feedback::single_encoder, Feedback::dual_encoder}) {
    AxisConfiguration configuration = stopped_axis();
    configuration.model.feedback = feedback;
    configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_denominator"), 7}};
    AxisUnderTest axis(configuration);
    axis.write("test_load_torque", 3'000);
    axis.step(2'000);
    EXPECT_EQ(axis.status().motor_position_actual_value, 7'000);
    EXPECT_EQ(axis.actual(), feedback == Feedback::dual_encoder ? 1'000 : 7'000);
    EXPECT_EQ(axis.velocity(), 0);
  }
}

TEST(EndStop, LeavesTheMotorItsTorque) {
  AxisUnderTest axis(stopped_axis());
  axis.write("op_mode_cmd", 4);
  axis.write("target_torque", 200);
  axis.command(0x000F);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), 1'000);
  EXPECT_EQ(axis.velocity(), 0);
  EXPECT_EQ(axis.status().torque_actual_value, 200);
  axis.write("target_torque", -200);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), -500);
  EXPECT_EQ(axis.status().torque_actual_value, -200);
}

TEST(EndStop, StaysInItsPlaceWhenHomingMovesTheFrame) {
  AxisUnderTest axis(stopped_axis());
  ASSERT_NO_FATAL_FAILURE(stand_at(axis, 400));
  axis.write("homing_method", 35);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.command(0x001F);
  axis.step(500);
  ASSERT_EQ(axis.actual(), 0);
  axis.command(0x0000);
  axis.write("test_load_torque", 300);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), 600);
  axis.write("test_load_torque", -300);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), -900);
}

TEST(EndStop, LetsAnAxisThatBeginsBeyondItOnlyComeBack) {
  AxisConfiguration configuration = stopped_axis();
  configuration.initial_position = 2'000;
  AxisUnderTest axis(configuration);
  axis.write("test_load_torque", 300);
  axis.step(500);
  EXPECT_EQ(axis.actual(), 2'000);
  axis.write("test_load_torque", -300);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), -500);
}

TEST(EndStop, MayBeOneOfTheTwo) {
  AxisConfiguration configuration = stopped_axis();
  configuration.model.upper_end_stop = kNoUpperEndStop;
  AxisUnderTest axis(configuration);
  axis.write("test_load_torque", 300);
  axis.step(500);
  EXPECT_GT(axis.actual(), 1'000);
  axis.write("test_load_torque", -300);
  axis.step(3'000);
  EXPECT_EQ(axis.actual(), -500);
}

// ---- heat of the motor -------------------------------------------------------------------------

/// A blocked axis whose motor produces `torque` [‰ of rated] from the first ticks on.
class HeatedAxis {
 public:
  HeatedAxis(double time_constant, std::int64_t torque) : axis(configuration(time_constant)) {
    axis.write("test_blocked_load", 1);
    axis.write("torque_slope", 0xFFFF'FFFF);
    axis.write("target_torque", torque);
    axis.write("op_mode_cmd", 4);
    axis.command(0x000F);
  }

  static AxisConfiguration configuration(double time_constant) {
    AxisConfiguration heated;
    heated.model.motor_thermal_time_constant = time_constant;
    return heated;
  }

  [[nodiscard]] bool warns() const { return (axis.statusword() & Statusword::kWarning) != 0; }

  void step_to_fault() { ASSERT_NE(axis.step_until_state(PowerState::fault, 5'000), 0U); }

  AxisUnderTest axis;
};

// With the current i in units of the rated current, the heat is i² (1 - exp(-t/τ)): it is 1 after τ
// ln(i²/(i² - 1)) and 1.1 after τ ln(i²/(i² - 1.1)).
TEST(MotorHeat, WarnsAndTripsAfterTheTimesOfTheFormula) {
  struct Row {
    std::int64_t torque;  // [‰]
    double warning;       // [s]
    double fault;         // [s]
  };

  // τ = 1 s: ln(4/3) and ln(4/2.9), ln(9/8) and ln(9/7.9), ln(2.25/1.25) and ln(2.25/1.15).
  for (const Row& row :
       {Row{2'000, 0.28768, 0.32158}, Row{3'000, 0.11778, 0.13037}, Row{1'500, 0.58779, 0.67117}}) {
    HeatedAxis heated(1.0, row.torque);
    const auto ticks_to_warning = heated.axis.step_until(
        [&] {
          return heated.warns();
        },
        2'000);
    // The current rises within the first tick, which `command` has run.
    EXPECT_NEAR(static_cast<double>(ticks_to_warning + 1U), row.warning * 1.0e3, 3.0);
    EXPECT_EQ(heated.axis.state(), PowerState::operation_enabled) << "a warning changes no state";
    const auto ticks_to_fault = heated.axis.step_until(
        [&] {
          return heated.axis.status().error_code != 0;
        },
        2'000);
    EXPECT_NEAR(static_cast<double>(ticks_to_warning + ticks_to_fault + 1U), row.fault * 1.0e3,
                4.0);
    EXPECT_EQ(heated.axis.status().error_code, 0x2350) << "CiA 402: load level fault (I2t)";
    EXPECT_EQ(heated.axis.status().error_register, 0b0000'0011) << "generic, current";
    ASSERT_NO_FATAL_FAILURE(heated.step_to_fault());
    EXPECT_TRUE(heated.warns());
    EXPECT_EQ(heated.axis.status().fault_count, 1U);
  }
}

TEST(MotorHeat, RefusesTheFaultResetUntilTheMotorHasCooledToItsRatedHeat) {
  HeatedAxis heated(1.0, 2'000);
  AxisUnderTest& axis = heated.axis;
  ASSERT_NO_FATAL_FAILURE(heated.step_to_fault());
  axis.command(0x0080);
  EXPECT_EQ(axis.state(), PowerState::fault);
  axis.command(0x0000);
  // From 1.1 down to 1: τ ln(1.1) = 95.3 ms; the fault reaction keeps heating for a few ticks.
  axis.step(80);
  EXPECT_TRUE(heated.warns());
  axis.command(0x0080);
  EXPECT_EQ(axis.state(), PowerState::fault);
  axis.command(0x0000);
  axis.step(60);
  EXPECT_FALSE(heated.warns());
  axis.command(0x0080);
  EXPECT_EQ(axis.state(), PowerState::switch_on_disabled);
  EXPECT_EQ(axis.status().error_code, 0);
}

TEST(MotorHeat, TripsAnAxisThatStandsOnItsTarget) {
  AxisUnderTest axis(HeatedAxis::configuration(2.0));
  axis.enable();
  axis.step(500);
  axis.write("test_load_torque", 4'200);  // 1.4 times the rated torque and current
  // τ ln(1.96/0.96) = 1.4275 s and τ ln(1.96/0.86) = 1.6475 s; the torque swings until the
  // integrator carries the load.
  const auto warning = axis.step_until_status(Statusword::kWarning, Statusword::kWarning, 3'000);
  EXPECT_NEAR(static_cast<double>(warning), 1'427.5, 50.0);
  EXPECT_TRUE(axis.reached());
  const auto fault = axis.step_until_status(Statusword::kFault, Statusword::kFault, 3'000);
  EXPECT_NEAR(static_cast<double>(warning + fault), 1'647.5, 60.0);
  EXPECT_EQ(axis.read("error_code"), 0x2350);
}

TEST(MotorHeat, BearsTheRatedCurrentForEver) {
  HeatedAxis heated(0.2, 999);
  for (int tick = 0; tick < 4'000; ++tick) {  // 20 time constants
    heated.axis.step();
    ASSERT_FALSE(heated.warns()) << tick;
  }
  EXPECT_EQ(heated.axis.state(), PowerState::operation_enabled);
}

TEST(MotorHeat, ClearsTheWarningIfTheLoadEndsBeforeTheFault) {
  HeatedAxis heated(1.0, 2'000);
  ASSERT_NE(heated.axis.step_until(
                [&] {
                  return heated.warns();
                },
                1'000),
            0U);
  heated.axis.write("target_torque", 500);
  heated.axis.step(200);
  EXPECT_FALSE(heated.warns());
  EXPECT_EQ(heated.axis.state(), PowerState::operation_enabled);
}

TEST(MotorHeat, OutlastsAPowerCycle) {
  HeatedAxis heated(10.0, 3'000);
  ASSERT_NO_FATAL_FAILURE(heated.step_to_fault());
  heated.axis.axis().power_cycle();
  heated.axis.step(6);
  EXPECT_EQ(heated.axis.state(), PowerState::fault);
  EXPECT_EQ(heated.axis.status().error_code, 0x2350);
}

TEST(MotorHeat, FollowsTheRatedCurrentOf6075h) {
  HeatedAxis heated(1.0, 1'000);
  heated.axis.write("motor_rated_current", 2'500);  // the 5 A for 3 N.m are twice that
  const auto ticks = heated.axis.step_until(
      [&] {
        return heated.warns();
      },
      2'000);
  EXPECT_NEAR(static_cast<double>(ticks), 287.7, 4.0);
}

TEST(MotorHeat, IsOffWithoutATimeConstant) {
  HeatedAxis heated(0.0, 3'000);
  heated.axis.step(5'000);
  EXPECT_FALSE(heated.warns());
  EXPECT_EQ(heated.axis.state(), PowerState::operation_enabled);
}

// ---- side by side ------------------------------------------------------------------------------

/// All effects at the same time.
void add_all_effects(AxisModel& model) {
  model.gravity_torque = -0.2;
  model.brake_torque = 1.0;
  model.brake_release_time = 0.02;
  model.brake_engage_time = 0.01;
  model.cogging_torque = 0.05;
  model.torque_ripple = 3.0;
  model.encoder_noise = 0.05;
  model.load_encoder_noise = 0.05;
  model.lower_end_stop = -200'000.0;
  model.upper_end_stop = 150'000.0;
  model.motor_thermal_time_constant = 2.0;
}

/// Every second axis has effects; both couplings occur.
std::vector<AxisConfiguration> half_with_effects(std::size_t count) {
  std::vector<AxisConfiguration> axes(count);
  for (std::size_t i = 0; i < count; ++i) {
    axes[i].model.coupling = i % 3 == 1 ? Coupling::two_inertia : Coupling::rigid;
    axes[i].model.backlash = i % 6 == 4 ? 1.0e-3 : 0.0;
    if (i % 2 == 0) add_all_effects(axes[i].model);
    if (i % 5 == 2) {
      axes[i].parameters = {{AxisUnderTest::address_of("gear_ratio_denominator"), 3}};
    }
  }
  return axes;
}

/// A write in the script of a run, which repeats every 900 ticks.
struct ScriptRow {
  int phase;
  std::uint16_t index;
  std::int64_t value;
};

/// Reset, enable, move, block, remove the power; each axis a little later than the previous one.
void write_script(AxisBank& bank, int tick) {
  const std::int64_t target = (tick % 7 - 3) * 40'000;
  for (const ScriptRow& row :
       {ScriptRow{10, 0x6060, 1}, ScriptRow{11, 0x6040, 0x80}, ScriptRow{12, 0x6040, 0x0F},
        ScriptRow{40, 0x607A, target}, ScriptRow{41, 0x6040, 0x3F}, ScriptRow{500, 0x5E01, 1},
        ScriptRow{550, 0x5E01, 0}, ScriptRow{700, 0x6040, 0x00}}) {
    for (std::size_t axis = 0; axis < bank.size(); ++axis) {
      if ((tick + 37 * static_cast<int>(axis)) % 900 != row.phase) continue;
      bank.write(axis, {row.index, 0}, row.value);
    }
  }
}

void run_script(AxisBank& bank, int first, int last) {
  for (int tick = first; tick < last; ++tick) {
    write_script(bank, tick);
    bank.step();
  }
}

TEST(PlantEffects, OfOneAxisChangeNoBitOfAnother) {
  std::vector<AxisConfiguration> axes = half_with_effects(17);
  AxisBank beside(axes, microseconds{1000});
  for (AxisConfiguration& axis : axes) {  // the same axes, but those with effects lose them
    if (has_effects(axis.model)) axis.model = AxisModel{.coupling = axis.model.coupling};
  }
  AxisBank plain(axes, microseconds{1000});
  for (int tick = 0; tick < 2'000; ++tick) {
    write_script(beside, tick);
    write_script(plain, tick);
    beside.step();
    plain.step();
    for (std::size_t axis = 1; axis < axes.size(); axis += 2) {
      for (const StatusMember& member : status_members()) {
        ASSERT_EQ(member.value(beside.status(axis)), member.value(plain.status(axis)))
            << "axis " << axis << ", " << member.name << ", tick " << tick;
      }
    }
  }
}

TEST(PlantEffects, GiveTheSameBitsForEveryOrderOfTheGroups) {
  AxisBank bank(half_with_effects(61), microseconds{1000});
  AxisBank other(half_with_effects(61), microseconds{1000});
  for (int tick = 0; tick < 600; ++tick) {
    write_script(bank, tick);
    write_script(other, tick);
    bank.step();
    for (std::size_t group = other.group_count(); group > 0; --group) {
      other.step_groups(group - 1, group);
    }
    ASSERT_EQ(other.status_hash(), bank.status_hash()) << "tick " << tick;
  }
}

TEST(PlantEffects, ContinueFromASnapshotAndItsBytes) {
  AxisBank bank(half_with_effects(13), microseconds{1000});
  run_script(bank, 0, 700);
  const AxisBank::Snapshot middle = bank.snapshot();
  const auto bytes = middle.bytes();
  run_script(bank, 700, 1'400);
  AxisBank from_bytes(half_with_effects(13), microseconds{1000});
  from_bytes.restore(from_bytes.snapshot_from(bytes));
  run_script(from_bytes, 700, 1'400);
  EXPECT_EQ(from_bytes.status_hash(), bank.status_hash());
  EXPECT_EQ(from_bytes.snapshot().bytes(), bank.snapshot().bytes());
  const std::uint64_t hash = bank.status_hash();
  bank.restore(middle);
  run_script(bank, 700, 1'400);
  EXPECT_EQ(bank.status_hash(), hash);
}

TEST(PlantEffects, LetABrakedAxisSettle) {
  // A block whose axes have settled is left out of the tick until something is written to it.
  AxisBank bank(std::vector<AxisConfiguration>(8, braked_axis(2.0)), microseconds{1000});
  for (int tick = 0; tick < 2'000; ++tick) bank.step();
  bank.write(3, {0x5E00, 0}, 5'000);  // 5 N.m against the 2.6 N.m of brake and weight
  for (int tick = 0; tick < 100; ++tick) bank.step();
  EXPECT_GT(bank.status(3).load_position_actual_value, 100);
  EXPECT_EQ(bank.status(4).load_position_actual_value, 0);
}

// ---- the model ---------------------------------------------------------------------------------

TEST(AxisModel, HasNoEffectByDefaultAndOneWithEachOfItsParameters) {
  EXPECT_FALSE(has_effects(AxisModel{}));
  for (double AxisModel::*const parameter :
       {&AxisModel::brake_torque, &AxisModel::cogging_torque, &AxisModel::torque_ripple,
        &AxisModel::encoder_noise, &AxisModel::load_encoder_noise, &AxisModel::lower_end_stop,
        &AxisModel::upper_end_stop, &AxisModel::motor_thermal_time_constant}) {
    AxisModel model;
    model.*parameter = 1.0;
    EXPECT_TRUE(has_effects(model));
  }
}

TEST(AxisModel, RefusesALowerEndStopThatIsNotBelowTheUpperOne) {
  AxisModel model;
  model.lower_end_stop = 100.0;
  EXPECT_NO_THROW(validate(model));
  for (const double upper : {100.0, 50.0}) {
    model.upper_end_stop = upper;
    try {
      validate(model);
      ADD_FAILURE() << upper << " is taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(std::string(error.what()), "lower_end_stop = 100: must be below upper_end_stop = " +
                                               std::to_string(static_cast<int>(upper)) + " UU");
    }
  }
  model.upper_end_stop = 101.0;
  EXPECT_NO_THROW(validate(model));
}

}  // namespace
}  // namespace vdrive
