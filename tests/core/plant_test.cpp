// SPDX-License-Identifier: Apache-2.0
// The plant against closed-form solutions, seen through the objects of the drive. SI parameters are
// chosen so that the expected figures can be computed by hand; 4096 user units are one revolution.
#include "core/support/axis_under_test.hpp"
#include "plant/servo_block.hpp"
#include "plant/servo_design.hpp"
#include "vdrive/plant/model_parameters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <string>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using test::kUnitsPerRadian;

/// Without friction: motor and load of 3e-4 kg.m2 each, rigid.
AxisConfiguration frictionless() {
  AxisConfiguration configuration;
  configuration.model.viscous_friction = 0.0;
  configuration.model.coulomb_friction = 0.0;
  return configuration;
}

/// Enabled, with a distant target and the steepest ramps, so that the torque limit decides.
void saturate(AxisUnderTest& axis, int sign) {
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("profile_velocity", 136'533);
  axis.write("profile_acc", 0xFFFFFFFF);
  axis.write("profile_dec", 0xFFFFFFFF);
  axis.enable();
  axis.write("position_user_target_value", sign * 2'000'000'000);
  axis.command(0x003F);
}

// ---- free motion -------------------------------------------------------------------------------

TEST(Plant, AcceleratesFreelyUnderAConstantTorqueLimit) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis(frictionless());
    axis.write("positive_torque_limit_relative", 200);  // 20 % of 3 N.m = 0.6 N.m
    axis.write("negative_torque_limit_relative", 200);
    saturate(axis, sign);
    // a = 0.6/6e-4 = 1000 rad/s². The torque follows its command with the current loop's
    // τ = 1/(2π·1000) s: v = a (t - τ (1 - e^(-t/τ))), x = a (t²/2 - τ t + τ² (1 - e^(-t/τ))).
    const double a = 1'000.0 * kUnitsPerRadian;
    const double tau = 1.0 / (2.0 * std::numbers::pi * 1'000.0);
    for (int tick = 1; tick <= 100; ++tick) {
      const double t = tick * 1.0e-3;
      const double x = a * (0.5 * t * t - tau * t + tau * tau * (1.0 - std::exp(-t / tau)));
      ASSERT_NEAR(axis.actual() * sign, x, 0.51) << "tick " << tick;
      const double mean = (x - a * (0.5 * (t - 1e-3) * (t - 1e-3) - tau * (t - 1e-3) +
                                    tau * tau * (1.0 - std::exp(-(t - 1e-3) / tau)))) *
                          1'000.0;
      ASSERT_NEAR(axis.velocity() * sign, mean, 1.1) << "606Ch is the reading over the tick";
      axis.step();
    }
  }
}

TEST(Plant, AcceleratesUnderTheTestLoadTorqueInItsDirection) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis(frictionless());
    axis.write("test_load_torque", sign * 300);  // 0.3 N.m on 6e-4 kg.m2: 500 rad/s²
    axis.step(200);
    const double a = 500.0 * kUnitsPerRadian;
    EXPECT_NEAR(axis.actual() * sign, 0.5 * a * 0.04, 1.0);
    EXPECT_NEAR(axis.velocity() * sign, a * 0.1995, 2.0);
  }
}

TEST(Plant, CoastingDecaysExponentiallyUnderViscousFriction) {
  AxisConfiguration configuration = frictionless();
  configuration.model.viscous_friction = 2.0e-3;  // J/b = 0.3 s
  AxisUnderTest axis(configuration);
  axis.write("profile_velocity", 50'000);
  axis.enable();
  axis.write("position_user_target_value", 10'000'000);
  axis.command(0x003F);
  axis.step(1'000);
  axis.command(0x0000);
  const double start_speed = axis.velocity();
  const double start = axis.actual();
  for (int tick = 1; tick <= 1'500; ++tick) {
    axis.step();
    // 606Ch is the speed over a tick, half a tick late both at the start and here.
    const double decay = std::exp(-tick * 1.0e-3 / 0.3);
    ASSERT_NEAR(axis.velocity(), start_speed * decay, 2.0 + 1.0e-4 * start_speed) << tick;
  }
  // From the start, with speed v half a tick earlier: distance v·τ(1 - e^(-t/τ)).
  const double travelled = start_speed * std::exp(-0.5e-3 / 0.3) * 0.3 * (1.0 - std::exp(-5.0));
  EXPECT_NEAR(axis.actual() - start, travelled, 3.0);
}

TEST(Plant, CoulombFrictionStopsACoastingAxisInFiniteTimeWithoutCreep) {
  AxisConfiguration configuration = frictionless();
  configuration.model.coulomb_friction = 0.06;  // 100 rad/s² = 65190 units/s²
  for (const int sign : {1, -1}) {
    AxisUnderTest axis(configuration);
    axis.write("profile_velocity", 50'000);
    axis.enable();
    axis.write("position_user_target_value", sign * 10'000'000);
    axis.command(0x003F);
    axis.step(1'000);
    axis.command(0x0000);
    const double speed = std::abs(axis.velocity());
    const double start = axis.actual() * sign;
    const double deceleration = 100.0 * kUnitsPerRadian;
    axis.step(static_cast<std::uint64_t>(speed / deceleration * 1'000.0 * 0.5));
    EXPECT_NEAR(std::abs(axis.velocity()), speed * 0.5, 100.0) << "a straight line";
    axis.step(static_cast<std::uint64_t>(speed / deceleration * 1'000.0 * 0.5) + 3);
    EXPECT_EQ(axis.velocity(), 0);
    // v²/(2a); the first tick counts from half a tick before its end.
    EXPECT_NEAR(axis.actual() * sign - start, speed * speed / (2.0 * deceleration), 60.0);
    const std::int32_t rest = axis.actual();
    axis.step(5'000);
    EXPECT_EQ(axis.actual(), rest);
  }
}

TEST(Plant, MovesOnlyAboveTheBreakAwayTorque) {
  AxisConfiguration configuration = frictionless();
  configuration.model.coulomb_friction = 0.05;
  for (const int sign : {1, -1}) {
    AxisUnderTest axis(configuration);
    axis.write("test_load_torque", sign * 49);
    axis.step(2'000);
    EXPECT_EQ(axis.actual(), 0);
    axis.write("test_load_torque", sign * 51);
    axis.step(2'000);
    // 1 mN.m beyond friction: 1e-3/6e-4 = 1.667 rad/s², 2 s: 3.33 rad = 2173 units.
    EXPECT_NEAR(axis.actual() * sign, 0.5 * (1.0 / 0.6) * 4.0 * kUnitsPerRadian, 30.0);
  }
}

// ---- torque limits -----------------------------------------------------------------------------

TEST(Plant, TorqueLimitsHoldForEachSignSeparately) {
  for (const std::int64_t limit : {100, 500}) {
    for (const int sign : {1, -1}) {
      AxisUnderTest axis(frictionless());
      axis.write(sign > 0 ? "positive_torque_limit_relative" : "negative_torque_limit_relative",
                 limit);
      saturate(axis, sign);
      std::int64_t highest = 0;
      for (int i = 0; i < 20; ++i) {
        axis.step();
        highest = std::max<std::int64_t>(highest, axis.status().current_actual_value * sign);
      }
      EXPECT_EQ(highest, limit) << "6078h within 60E0h/60E1h [‰]";
      // The other side is limited only by 6072h = 300 %.
      axis.write("position_user_target_value", sign * -2'000'000'000);
      axis.command(0x000F);
      axis.command(0x003F);
      std::int64_t lowest = 0;
      for (int i = 0; i < 200; ++i) {
        axis.step();
        ASSERT_LE(axis.status().current_actual_value * sign, limit);
        lowest = std::min<std::int64_t>(lowest, axis.status().current_actual_value * sign);
      }
      EXPECT_LT(lowest, -2 * limit);
    }
  }
}

TEST(Plant, WithoutRelativeLimitsTheMaximumTorqueOf6072hHolds) {
  for (const std::int64_t maximum : {500, 3'000}) {
    AxisUnderTest axis(frictionless());
    axis.write("max_torque", maximum);
    saturate(axis, 1);
    std::int64_t highest = 0;
    for (int i = 0; i < 10; ++i) {
      axis.step();
      highest = std::max<std::int64_t>(highest, axis.status().torque_actual_value);
    }
    EXPECT_EQ(highest, maximum);
  }
}

TEST(Plant, TorqueLimitsActAtOnce) {
  AxisUnderTest axis(frictionless());
  saturate(axis, 1);
  axis.step(3);
  axis.write("positive_torque_limit_relative", 100);
  axis.step(3);
  EXPECT_EQ(axis.status().torque_demand, 100);
  EXPECT_EQ(axis.status().torque_actual_value, 100);
}

TEST(Plant, CurrentAndTorqueBalanceTheLoadAtRest) {
  AxisUnderTest axis(frictionless());
  axis.enable();
  axis.write("test_load_torque", 600);  // 0.6 N.m of 3 N.m: the motor holds with -20 %
  axis.step(3'000);
  EXPECT_EQ(axis.status().torque_actual_value, -200);
  EXPECT_EQ(axis.status().current_actual_value, -200);  // 0.6 N.m/0.6 N.m/A = 1 A of 5 A
  EXPECT_EQ(axis.actual(), 0);
  EXPECT_EQ(axis.status().current_error_value, 0);
}

// ---- two inertias ------------------------------------------------------------------------------

/// Two equal inertias of 3e-4 kg.m2 on a soft shaft, free of friction.
AxisConfiguration elastic(double stiffness) {
  AxisConfiguration configuration = frictionless();
  configuration.model.coupling = Coupling::two_inertia;
  configuration.model.coupling_stiffness = stiffness;
  configuration.model.coupling_damping = 0.0;
  return configuration;
}

/// Load minus motor position.
double twist_of(const AxisUnderTest& axis) {
  return axis.status().load_position_actual_value - axis.status().motor_position_actual_value;
}

TEST(Plant, TheFreeTwoInertiaSystemRingsAtItsResonanceWithoutLosingEnergy) {
  AxisUnderTest axis(elastic(2.0));
  // ω² = k (1/Jm + 1/Jl) = 2·2/3e-4: 115.47 rad/s, 18.378 Hz. With a constant torque T on the load
  // the twist oscillates around T/(2k) = 0.25 rad = 163 units with that amplitude.
  const double omega = std::sqrt(2.0 * 2.0 / 3.0e-4);
  const double mean = 0.25 * kUnitsPerRadian;
  axis.write("test_load_torque", 1'000);
  for (int tick = 1; tick <= 2'000; ++tick) {
    axis.step();
    const double expected = mean * (1.0 - std::cos(omega * tick * 1.0e-3));
    ASSERT_NEAR(twist_of(axis), expected, 1.6) << "tick " << tick;
  }
}

TEST(Plant, DampingOfTheShaftDecaysTheRingingAtItsRate) {
  AxisConfiguration configuration = elastic(2.0);
  configuration.model.coupling_damping = 1.0e-3;
  AxisUnderTest axis(configuration);
  // δ = c/2·(1/Jm + 1/Jl) = 0.5e-3·6666.7 = 3.333 1/s.
  axis.write("test_load_torque", 1'000);
  double last_peak = 0.0;
  for (int tick = 1; tick <= 1'000; ++tick) {
    axis.step();
    if (tick > 1'000 - 60) {  // the last period
      last_peak = std::max(last_peak, twist_of(axis));
    }
  }
  const double mean = 0.25 * kUnitsPerRadian;
  // With a period of 54.4 ms there is a peak between 0.945 and 1 s.
  const double latest = mean * (1.0 + std::exp(-3.333 * 1.0));
  const double earliest = mean * (1.0 + std::exp(-3.333 * 0.94));
  EXPECT_GE(last_peak, latest - 1.5);
  EXPECT_LE(last_peak, earliest + 1.5);
}

TEST(Plant, TwoInertiasMoveAsOneMassOnAverage) {
  AxisUnderTest axis(elastic(2.0));
  axis.write("test_load_torque", 100);
  axis.step(1'000);
  // Centre of mass: 0.1/(6e-4) = 166.7 rad/s² for 1 s.
  const double centre = 0.5 * (axis.actual() + axis.status().motor_position_actual_value);
  EXPECT_NEAR(centre, 0.5 * (1.0 / 6.0e-3) * kUnitsPerRadian, 2.0);
}

TEST(Plant, AStiffShaftBehavesLikeTheRigidAxis) {
  AxisConfiguration stiff;
  stiff.model.coupling = Coupling::two_inertia;
  AxisUnderTest elastic_axis(stiff);
  AxisUnderTest rigid_axis;
  for (AxisUnderTest* const axis : {&elastic_axis, &rigid_axis}) {
    axis->enable();
    axis->write("position_user_target_value", 50'000);
    axis->command(0x003F);
  }
  for (int i = 0; i < 3'000; ++i) {
    elastic_axis.step();
    rigid_axis.step();
    ASSERT_NEAR(elastic_axis.actual(), rigid_axis.actual(), 30) << "tick " << i;
  }
  EXPECT_EQ(elastic_axis.actual(), 50'000);
  EXPECT_TRUE(elastic_axis.reached());
}

TEST(Plant, InsideTheBacklashNoTorqueReachesTheLoad) {
  AxisConfiguration configuration = elastic(2'000.0);
  configuration.model.coupling_damping = 0.05;
  configuration.model.backlash = 0.2;  // ±0.1 rad = ±65 units
  configuration.model.load_coulomb_friction = 0.02;
  AxisUnderTest axis(configuration);
  axis.write("positive_torque_limit_relative", 10);  // 0.03 N.m: 100 rad/s² for the motor alone
  saturate(axis, 1);
  // 65.2 units at 65190 units/s²: 44.7 ms (and the current loop's delay).
  axis.step(43);
  EXPECT_EQ(axis.actual(), 0);
  EXPECT_GT(axis.status().motor_position_actual_value, 55);
  axis.step(20);
  EXPECT_GT(axis.actual(), 0);
}

TEST(Plant, ABlockedLoadHoldsTheMotorOnItsShaft) {
  AxisConfiguration configuration = elastic(20.0);
  configuration.model.coupling_damping = 0.02;
  AxisUnderTest axis(configuration);
  axis.write("test_blocked_load", 1);
  axis.write("positive_torque_limit_relative", 100);
  saturate(axis, 1);
  axis.step(3'000);
  EXPECT_EQ(axis.actual(), 0);
  // 0.3 N.m on 20 N.m/rad: 0.015 rad = 9.8 units.
  EXPECT_NEAR(axis.status().motor_position_actual_value, 0.015 * kUnitsPerRadian, 1.0);
}

// ---- gear --------------------------------------------------------------------------------------

TEST(Plant, TheLoadTurnsWithTheMotorTimesNumeratorOverDenominator) {
  struct Row {
    std::int64_t numerator;
    std::int64_t denominator;
  };

  for (const Row& row : {Row{1, 10}, Row{3, 1}, Row{2, 7}}) {
    AxisConfiguration configuration;
    configuration.model.load_inertia = 3.0e-5;
    AxisUnderTest axis(configuration);
    axis.write("gear_ratio_numerator", row.numerator);
    axis.write("gear_ratio_denominator", row.denominator);
    axis.write("profile_velocity", 2'000);
    axis.enable();
    axis.write("position_user_target_value", 4'200);
    axis.command(0x003F);
    const double ratio = static_cast<double>(row.numerator) / static_cast<double>(row.denominator);
    for (int i = 0; i < 5'000; ++i) {
      axis.step();
      const AxisStatus& s = axis.status();
      ASSERT_NEAR(s.load_position_actual_value, s.motor_position_actual_value * ratio,
                  0.5 + 0.5 * ratio);
      // Both speeds are differences of at least one encoder count: 0.49 units/s.
      ASSERT_NEAR(s.load_velocity_actual_value, s.motor_velocity_actual_value * ratio,
                  1.0 + 1.0 * ratio);
    }
    EXPECT_EQ(axis.actual(), 4'200) << row.numerator << "/" << row.denominator;
    EXPECT_TRUE(axis.reached());
  }
}

TEST(Plant, TheGearReflectsInertiaAndLoadTorqueToTheMotor) {
  AxisConfiguration configuration = frictionless();
  configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_denominator"), 2}};
  AxisUnderTest axis(configuration);
  // Load torque 0.3 N.m over r = 1/2: J at the motor 3e-4 + 3e-4/4, motor acceleration
  // 0.15/3.75e-4 = 400 rad/s², load 200 rad/s².
  axis.write("test_load_torque", 300);
  axis.step(200);
  EXPECT_NEAR(axis.velocity(), 200.0 * kUnitsPerRadian * 0.1995, 2.0);
  EXPECT_NEAR(axis.status().motor_velocity_actual_value, 400.0 * kUnitsPerRadian * 0.1995, 2.0);
}

TEST(Plant, TheGearCarriesTheMotorsTorqueToTheLoad) {
  struct Row {
    std::uint32_t numerator;
    std::uint32_t denominator;
  };

  for (const Row& row : {Row{1, 4}, Row{1, 1}, Row{2, 1}}) {
    AxisConfiguration configuration = frictionless();
    configuration.parameters = {
        {AxisUnderTest::address_of("gear_ratio_numerator"), row.numerator},
        {AxisUnderTest::address_of("gear_ratio_denominator"), row.denominator}};
    AxisUnderTest axis(configuration);
    axis.write("positive_torque_limit_relative", 100);  // 0.3 N.m at the motor
    saturate(axis, 1);
    axis.step(20);
    const std::int32_t first = axis.velocity();
    axis.step(50);
    // The motor sees 3e-4 (1 + r²); the load turns r times as fast.
    const double ratio = static_cast<double>(row.numerator) / row.denominator;
    const double expected = ratio * 0.3 / (3.0e-4 * (1.0 + ratio * ratio)) * 0.05;
    EXPECT_NEAR(axis.velocity() - first, expected * kUnitsPerRadian, 2.0) << ratio;
  }
}

TEST(Plant, SettingTheGearDoesNotMoveTheLoad) {
  AxisConfiguration configuration;
  configuration.initial_position = 12'345;
  AxisUnderTest axis(configuration);
  axis.step();
  axis.write("gear_ratio_denominator", 7);
  axis.step();
  EXPECT_EQ(axis.actual(), 12'345);
  axis.enable();
  EXPECT_EQ(axis.step(100), 0x0637);
  EXPECT_EQ(axis.actual(), 12'345);
}

// ---- encoders ----------------------------------------------------------------------------------

TEST(Plant, ACoarseEncoderShowsItsCountsInTheSpeed) {
  AxisConfiguration configuration;
  configuration.model.encoder_resolution = 4096.0;  // one count is one unit: 1000 units/s in 1 ms
  AxisUnderTest axis(configuration);
  axis.write("profile_velocity", 2'500);
  axis.enable();
  axis.write("position_user_target_value", 2'000);
  axis.command(0x003F);
  bool moved = false;
  for (int i = 0; i < 500; ++i) {
    axis.step();
    ASSERT_EQ(axis.status().motor_velocity_actual_value % 1'000, 0);
    moved = moved || axis.status().motor_velocity_actual_value != 0;
  }
  EXPECT_TRUE(moved);
}

TEST(Plant, TheDefaultEncoderGivesAUsableSpeed) {
  AxisUnderTest axis;
  axis.enable();
  axis.step(500);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    ASSERT_LT(std::abs(axis.velocity()), 10) << "ripple below 606Fh at standstill";
  }
}

TEST(Plant, WithOneEncoderBothReadingsComeFromTheMotor) {
  AxisConfiguration configuration = elastic(20.0);
  configuration.model.coupling_damping = 0.02;
  configuration.model.feedback = Feedback::single_encoder;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.write("position_user_target_value", 5'000);
  axis.command(0x003F);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    const AxisStatus& s = axis.status();
    ASSERT_EQ(s.load_position_actual_value, s.motor_position_actual_value);
    ASSERT_EQ(s.load_velocity_actual_value, s.motor_velocity_actual_value);
  }
}

// ---- loops -------------------------------------------------------------------------------------

TEST(Plant, TheDefaultAxisFollowsTheManualsExampleWithinTwoUnitsAndSettlesToTheUnit) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("profile_velocity", 1'000);
  axis.write("profile_acc", 6'000);
  axis.write("profile_dec", 6'000);
  axis.write("position_user_target_value", 10'000);
  axis.command(0x003F);
  for (int tick = 2; tick <= 10'300; ++tick) {
    axis.step();
    const bool constant_speed = tick > 300 && tick < 9'900;
    ASSERT_LT(std::abs(axis.read("load_position_error_value")), constant_speed ? 2 : 10) << tick;
  }
  EXPECT_EQ(axis.actual(), 10'000);
  EXPECT_EQ(axis.read("load_position_error_value"), 0);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    ASSERT_LT(std::abs(axis.velocity()), 10) << "606Ch below 606Fh after the move";
    ASSERT_EQ(axis.actual(), 10'000);
  }
}

/// Highest torque demand of the loops while nothing moves.
std::int64_t torque_at_rest(AxisUnderTest& axis) {
  std::int64_t highest = 0;
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    highest = std::max<std::int64_t>(highest, std::abs(axis.status().torque_demand));
  }
  return highest;
}

void expect_stable(Coupling coupling, double inertia_ratio) {
  for (const Feedback feedback : {Feedback::single_encoder, Feedback::dual_encoder}) {
    SCOPED_TRACE((coupling == Coupling::rigid ? "rigid " : "two inertias ") +
                 std::to_string(inertia_ratio));
    AxisConfiguration configuration;
    configuration.model.coupling = coupling;
    configuration.model.feedback = feedback;
    configuration.model.load_inertia = configuration.model.motor_inertia * inertia_ratio;
    AxisUnderTest axis(configuration, microseconds{125});
    axis.enable();
    axis.write("profile_velocity", 20'000);
    axis.write("profile_acc", 100'000);
    axis.write("profile_dec", 100'000);
    axis.write("position_user_target_value", 20'000);
    axis.command(0x003F);
    axis.step_for(microseconds{3'000'000});
    EXPECT_EQ(axis.actual(), 20'000);
    // Coulomb friction of 0.05 N.m is 17 ‰ of 3 N.m; no more is needed at rest.
    EXPECT_LE(torque_at_rest(axis), 40);
  }
}

TEST(Plant, TheDefaultTuningIsStableForARigidLoadOfATenthToThirtyTimesTheMotor) {
  for (const double ratio : {0.1, 0.3, 1.0, 3.0, 10.0, 30.0}) expect_stable(Coupling::rigid, ratio);
}

TEST(Plant, TheDefaultTuningIsStableForAnElasticLoadOfATenthToThirtyTimesTheMotor) {
  for (const double ratio : {0.1, 0.3, 1.0, 3.0, 10.0, 15.0, 20.0, 30.0}) {
    expect_stable(Coupling::two_inertia, ratio);
  }
}

TEST(Plant, AntiWindUpLetsAReleasedAxisReturnAndSettle) {
  AxisUnderTest axis;
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.enable();
  axis.write("test_blocked_load", 1);
  axis.write("position_user_target_value", 20'000);
  axis.command(0x003F);
  axis.step(3'000);
  axis.write("test_blocked_load", 0);
  axis.step(1'000);
  EXPECT_EQ(axis.actual(), 20'000) << "three seconds of saturation are not in the integrator";
}

// ---- sub-steps ---------------------------------------------------------------------------------

// The largest 5E00h accelerates the default axis by 2.1e6 N.m / 6e-4 kg.m² = 3.6e9 rad/s².
// 1,000,000 rpm are 68,266,667 UU/s.
TEST(Plant, TheLargestLoadTorqueLeavesASpeedFromWhichTheAxisComesToRest) {
  for (const Coupling coupling : {Coupling::rigid, Coupling::two_inertia}) {
    SCOPED_TRACE(to_string(coupling));
    AxisConfiguration configuration;
    configuration.model.coupling = coupling;
    AxisUnderTest axis(configuration);
    axis.enable();
    axis.write("test_load_torque", 0x7FFFFFFF);
    axis.step(1'000);
    axis.write("test_load_torque", 0);
    axis.step(100);  // until a shaft has stopped swinging
    EXPECT_LE(std::abs(axis.velocity()), 68'266'667);
    EXPECT_GT(axis.step_until(
                  [&axis] {
                    return axis.velocity() == 0;
                  },
                  30'000),
              0U);
  }
}

TEST(Plant, FreeMotionIsExactForAnySubStep) {
  // 0.1 s under a constant load torque with viscous friction: x = T/b (t - τ (1 - e^(-t/τ))).
  AxisConfiguration configuration = frictionless();
  configuration.model.viscous_friction = 6.0e-3;  // τ = 0.1 s
  const double expected = 0.6 / 6.0e-3 * (0.1 - 0.1 * (1.0 - std::exp(-1.0))) * kUnitsPerRadian;
  for (const std::int64_t period : {125, 160, 200, 250, 500, 1'000, 2'000, 5'000, 10'000}) {
    AxisUnderTest axis(configuration, microseconds{period});
    axis.write("test_load_torque", 600);
    axis.step_for(microseconds{100'000});
    EXPECT_NEAR(axis.actual(), expected, 0.51) << period << " us";
  }
}

TEST(Plant, CoulombStopsConvergeWithTheSubStep) {
  // The stopping distance is v²/2a, except for at most the distance travelled in the last sub-step.
  AxisConfiguration configuration = frictionless();
  configuration.model.coulomb_friction = 0.06;
  for (const std::int64_t period : {125, 126, 1'000, 10'000}) {
    AxisUnderTest axis(configuration, microseconds{period});
    axis.write("test_load_torque", 660);  // 1000 rad/s² beyond friction for 0.1 s
    axis.step_for(microseconds{100'000 / period * period});
    const double time = static_cast<double>(100'000 / period * period) * 1e-6;
    axis.write("test_load_torque", 0);
    const double v = 1'000.0 * time * kUnitsPerRadian;
    const double x = 0.5 * v * time;
    axis.step_for(microseconds{3'000'000});
    EXPECT_NEAR(axis.actual(), x + v * v / (2.0 * 100.0 * kUnitsPerRadian), 1.5) << period;
    EXPECT_EQ(axis.velocity(), 0);
  }
}

// ---- the model alone, at any sub-step ----------------------------------------------------------

/// One free axis of the servo kernel, without power: its exact state, stepped by any sub-step.
class FreeAxis {
 public:
  FreeAxis(const AxisModel& model, const Gear& gear, double substep)
      : model_(model), gear_(gear), substep_(substep) {
    validate(model);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (model.coupling == Coupling::rigid) {
        design_lane(model, gear, substep, lane, rigid_);
      } else {
        design_lane(model, gear, substep, lane, elastic_);
      }
    }
  }

  /// Velocities [rad/s].
  void set_speeds(double motor, double load) {
    state_.velocity[0] = motor * kUnitsPerRadian;
    state_.load_velocity[0] = load * kUnitsPerRadian;
  }

  /// Load position [rad] with the motor at 0: twists the shaft.
  void set_load_position(double position) { state_.load_position[0] = position * kUnitsPerRadian; }

  /// Torque at the load shaft [N.m].
  void set_load_torque(double torque) {
    state_.load_torque[0] = torque * load_torque_factor(model_, gear_);
  }

  void step() {
    if (model_.coupling == Coupling::rigid) {
      step(rigid_);
    } else {
      step(elastic_);
    }
  }

  void step_for(double seconds) {
    const auto steps = static_cast<std::uint64_t>(std::llround(seconds / substep_));
    for (std::uint64_t i = 0; i < steps; ++i) step();
  }

  /// [rad], and [rad/s] below.
  [[nodiscard]] double position() const { return state_.position[0] / kUnitsPerRadian; }

  [[nodiscard]] double velocity() const { return state_.velocity[0] / kUnitsPerRadian; }

  [[nodiscard]] double load_position() const { return state_.load_position[0] / kUnitsPerRadian; }

  [[nodiscard]] double load_velocity() const { return state_.load_velocity[0] / kUnitsPerRadian; }

  [[nodiscard]] const ServoState& state() const { return state_; }

  /// Kinetic energy of both inertias and of the twisted shaft [J].
  [[nodiscard]] double energy() const {
    const double ratio = static_cast<double>(gear_.numerator) / gear_.denominator;
    const double twist = ratio * position() - load_position();
    return 0.5 * model_.motor_inertia * velocity() * velocity() +
           0.5 * model_.load_inertia * load_velocity() * load_velocity() +
           0.5 * model_.coupling_stiffness * twist * twist;
  }

 private:
  /// Without power, with backlash: the general step.
  template <typename Parameters>
  void step(const Parameters& parameters) {
    const ServoBlock<Parameters> block{&parameters, &demand_, &state_};
    step_servo(std::span(&block, 1), {.first = 0, .last = 1, .count = 1.0, .length = substep_},
               {.general = true, .play = true});
  }

  AxisModel model_;
  Gear gear_;
  double substep_;
  RigidParameters rigid_{};
  ElasticParameters elastic_{};
  DemandBlock demand_{};
  ServoState state_{};
};

constexpr double kServoCycle = 125.0e-6;

TEST(PlantModel, AnUndampedTwoInertiaSystemKeepsItsEnergyWithoutInput) {
  for (const Gear& gear : {Gear{1, 1}, Gear{1, 5}, Gear{3, 1}}) {
    FreeAxis axis(elastic(2.0).model, gear, kServoCycle);
    axis.set_load_torque(0.5);
    axis.step_for(0.02);  // a push, then nothing from outside
    axis.set_load_torque(0.0);
    const double energy = axis.energy();
    ASSERT_GT(energy, 1.0e-3);
    // 4 s: 73 periods at 18.4 Hz (gear 1:1); each sub-step is checked.
    for (int i = 0; i < 32'000; ++i) {
      axis.step();
      ASSERT_NEAR(axis.energy(), energy, 1.0e-9 * energy) << "sub-step " << i;
    }
  }
}

TEST(PlantModel, AReleasedTwistedShaftExchangesEnergyBetweenTwistAndSpeed) {
  // ω = sqrt(k (1/Jm + 1/Jl)) = 115.47 rad/s: after a quarter of a period the shaft is straight,
  // and all of ½ k φ² = 0.01 J is kinetic energy: J v² = 0.01, v = 5.7735 rad/s on each side.
  const double omega = std::sqrt(2.0 * 2.0 / 3.0e-4);
  const double quarter = 0.5 * std::numbers::pi / omega;
  FreeAxis axis(elastic(2.0).model, {}, quarter / 100.0);
  axis.set_load_position(0.1);
  for (int i = 0; i < 100; ++i) axis.step();
  EXPECT_NEAR(axis.position(), axis.load_position(), 1.0e-12);
  EXPECT_NEAR(axis.velocity(), std::sqrt(0.01 / 3.0e-4), 1.0e-9);
  EXPECT_NEAR(axis.load_velocity(), -std::sqrt(0.01 / 3.0e-4), 1.0e-9);
}

TEST(PlantModel, FrictionAndDampingNeverAddEnergy) {
  struct Row {
    const char* name;
    double AxisModel::*parameter;
    double value;
    double slack;  // [J] per sub-step
  };

  // In the sub-step of a Coulomb stop the inertia travels up to ah²/8 too far (see below), against
  // a shaft torque of at most sqrt(2kE) = 1 N.m, which also bounds a: (1 + 0.01)/3e-4 rad/s².
  const double stop = 1.0 * (1.01 / 3.0e-4) * kServoCycle * kServoCycle / 8.0;
  for (const Row& row : {Row{"shaft damping", &AxisModel::coupling_damping, 1.0e-3, 0.0},
                         Row{"motor viscous", &AxisModel::viscous_friction, 1.0e-3, 0.0},
                         Row{"load viscous", &AxisModel::load_viscous_friction, 1.0e-3, 0.0},
                         Row{"motor Coulomb", &AxisModel::coulomb_friction, 0.01, stop},
                         Row{"load Coulomb", &AxisModel::load_coulomb_friction, 0.01, stop}}) {
    AxisModel model = elastic(2.0).model;
    model.*row.parameter = row.value;
    FreeAxis axis(model, {}, kServoCycle);
    axis.set_load_position(0.5);
    axis.set_speeds(3.0, -1.0);
    const double first = axis.energy();
    double before = first;
    for (int i = 0; i < 16'000; ++i) {  // 2 s, 37 periods
      axis.step();
      ASSERT_LE(axis.energy(), before * (1.0 + 1.0e-12) + row.slack)
          << row.name << ", sub-step " << i;
      before = axis.energy();
    }
    EXPECT_LT(before, 0.7 * first) << row.name;
  }
}

TEST(PlantModel, LinearMotionDoesNotDependOnTheSubStep) {
  // Constant load torque on damped inertias, 0.1 s in 10 to 12800 sub-steps. The discretisation is
  // exact for inputs that are held, so only rounding remains.
  AxisModel rigid = frictionless().model;
  rigid.viscous_friction = 2.0e-3;
  AxisModel soft = elastic(2.0).model;
  soft.coupling_damping = 1.0e-3;
  soft.load_viscous_friction = 1.0e-3;
  for (const AxisModel& model : {rigid, soft}) {
    for (const Gear& gear : {Gear{1, 1}, Gear{2, 7}}) {
      FreeAxis coarse(model, gear, 0.01);
      coarse.set_load_torque(0.3);
      coarse.step_for(0.1);
      for (const double substep : {5.0e-3, 1.0e-3, kServoCycle, 0.1 / 12'800.0}) {
        FreeAxis fine(model, gear, substep);
        fine.set_load_torque(0.3);
        fine.step_for(0.1);
        EXPECT_NEAR(fine.position(), coarse.position(), 1.0e-10 * std::abs(coarse.position()));
        EXPECT_NEAR(fine.velocity(), coarse.velocity(), 1.0e-10 * std::abs(coarse.velocity()));
      }
    }
  }
}

TEST(PlantModel, ACoulombStopConvergesWithTheSquareOfTheSubStep) {
  // Until the stop each sub-step is exact. The axis enters the last one with a·θh and would still
  // travel a(θh)²/2; the kernel lets it travel h/2 times its speed, aθh²/2. The difference a h²
  // θ(1 - θ)/2 is greatest for θ = 1/2: a h²/8, a quarter of that for half the sub-step.
  AxisModel model = frictionless().model;
  model.coulomb_friction = 0.06;
  const double a = 0.06 / 6.0e-4;  // 100 rad/s²
  for (const double h : {1.0e-3, 5.0e-4, 2.5e-4, 1.25e-4, 6.25e-5}) {
    const double speed = a * h * (std::floor(0.2 / h) + 0.5);
    FreeAxis axis(model, {}, h);
    axis.set_speeds(speed, 0.0);
    axis.step_for(0.3);
    EXPECT_EQ(axis.velocity(), 0.0);
    const double error = axis.position() - speed * speed / (2.0 * a);
    EXPECT_NEAR(error, a * h * h / 8.0, 1.0e-3 * a * h * h) << h;
  }
}

/// Largest relative error of the speed at which two equal masses separate after colliding through
/// the backlash, over eight instants of the impact within a sub-step.
double impact_error(double substep) {
  AxisModel model = elastic(2.0).model;
  model.backlash = 0.2;
  double worst = 0.0;
  for (int phase = 0; phase < 8; ++phase) {
    FreeAxis axis(model, {}, substep);
    constexpr double kSpeed = 10.0;  // crossing the backlash of 0.1 rad takes 10 ms
    axis.set_load_position(kSpeed * substep * phase / 8.0);
    axis.set_speeds(kSpeed, 0.0);
    axis.step_for(0.05);  // contact lasts π/ω = 27 ms
    EXPECT_NEAR(axis.velocity() + axis.load_velocity(), kSpeed, 1.0e-9) << "momentum";
    const double parting = axis.load_velocity() - axis.velocity();
    worst = std::max(worst, std::abs(parting / kSpeed - 1.0));
  }
  return worst;
}

TEST(PlantModel, AnImpactThroughTheBacklashConvergesWithTheSquareOfTheSubStep) {
  // An elastic impact: equal masses exchange their speeds. Contact begins up to a sub-step h late,
  // with an overlap for which no work was done, and ends up to h late: each changes the relative
  // speed by at most (ωh)²/2, one up, one down, ω² = k (1/Jm + 1/Jl).
  const double omega_squared = 2.0 * 2.0 / 3.0e-4;
  double before = 0.0;
  for (const double h : {1.0e-3, 5.0e-4, 2.5e-4, 1.25e-4, 6.25e-5, 3.125e-5}) {
    const double error = impact_error(h);
    EXPECT_LE(error, 0.5 * omega_squared * h * h * 1.05) << h;
    EXPECT_TRUE(before == 0.0 || error < before / 2.8) << h << ": " << error << " after " << before;
    before = error;
  }
}

TEST(PlantModel, EncodersShowTheNearestCount) {
  AxisModel model = elastic(2.0).model;
  model.encoder_resolution = 10'000.0;
  model.load_encoder_resolution = 65'536.0;
  FreeAxis axis(model, {}, kServoCycle);
  axis.set_load_torque(0.1);
  for (int i = 0; i < 8'000; ++i) {
    axis.step();
    const double motor_counts = axis.state().motor_reading[0] * 10'000.0 / 4096.0;
    const double load_counts = axis.state().load_reading[0] * 65'536.0 / 4096.0;
    ASSERT_NEAR(motor_counts, std::round(motor_counts), 1.0e-6);
    ASSERT_NEAR(load_counts, std::round(load_counts), 1.0e-6);
    ASSERT_LE(std::abs(axis.state().position[0] * 10'000.0 / 4096.0 - motor_counts), 0.5 + 1e-6);
    ASSERT_LE(std::abs(axis.state().load_position[0] * 65'536.0 / 4096.0 - load_counts),
              0.5 + 1e-6);
  }
}

}  // namespace

// Manual, 607Fh: the actual speed of the motor does not exceed the application speed limit. The
// default is 136533 UU/s; 5 % are allowed for the overshoot of the velocity loop.
TEST(Plant, TheActualSpeedStaysWithinTheSpeedLimitWhenABlockedAxisIsReleased) {
  AxisUnderTest axis;
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.enable();
  axis.write("test_blocked_load", 1);
  axis.write("position_user_target_value", 20'000);
  axis.command(0x003F);
  axis.step(3'000);
  axis.write("test_blocked_load", 0);
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    ASSERT_LE(std::abs(axis.velocity()), 136'533 * 1.05);
  }
}

}  // namespace vdrive
