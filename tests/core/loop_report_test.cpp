// SPDX-License-Identifier: Apache-2.0
// The servo loops with loads behind gears and shafts: the report, and the behaviour of the axis.
#include "vdrive/plant/loop_report.hpp"

#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>

namespace vdrive {
namespace {

using test::AxisUnderTest;

constexpr std::chrono::milliseconds kLoopPeriod{1};

AxisConfiguration geared(std::int64_t numerator, std::int64_t denominator) {
  AxisConfiguration configuration;
  configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_numerator"), numerator},
                              {AxisUnderTest::address_of("gear_ratio_denominator"), denominator}};
  return configuration;
}

/// A lift: 0.1 kg.m2 on the load side of a ten-to-one reduction gear, on a shaft of 2000 N.m/rad.
AxisConfiguration lift() {
  AxisConfiguration configuration = geared(1, 10);
  configuration.model.coupling = Coupling::two_inertia;
  configuration.model.load_inertia = 0.1;
  configuration.model.viscous_friction = 0.0;
  configuration.model.coulomb_friction = 0.0;
  return configuration;
}

TEST(LoopReport, OfTheDefaultAxisHasTheConfiguredBandwidthsAndNoRinging) {
  const LoopReport report = examine_loops({}, kLoopPeriod);
  EXPECT_DOUBLE_EQ(report.gear_ratio, 1.0);
  EXPECT_DOUBLE_EQ(report.inertia_ratio, 2.0);
  EXPECT_EQ(report.load_resonance, 0.0);
  EXPECT_NEAR(report.velocity_bandwidth, 100.0, 1e-9);
  EXPECT_NEAR(report.position_bandwidth, 16.0, 1e-9);
  EXPECT_EQ(report.ringing, 0.0);
  // 409600 UU/s² are 200π rad/s², on 6e-4 kg.m2; 6072h is 300 % of 3 N.m.
  EXPECT_NEAR(report.torque_needed, 200.0 * std::numbers::pi * 6.0e-4, 1e-9);
  EXPECT_NEAR(report.torque_limit, 9.0, 1e-9);
}

TEST(LoopReport, HasTheReflectedInertiaOfTheGear) {
  // 3e-4 kg.m2 at the load: a hundredth of it through a reduction gear, a hundred times as much the
  // other way.
  EXPECT_NEAR(examine_loops(geared(1, 10), kLoopPeriod).inertia_ratio, 1.01, 1e-9);
  EXPECT_NEAR(examine_loops(geared(10, 1), kLoopPeriod).inertia_ratio, 101.0, 1e-9);
  // The motor turns ten times as fast as the load: 2000π rad/s² on 3.03e-4 kg.m2.
  EXPECT_NEAR(examine_loops(geared(1, 10), kLoopPeriod).torque_needed,
              2'000.0 * std::numbers::pi * 3.03e-4, 1e-9);
}

TEST(LoopReport, ShowsTheReducedBandwidthsOfAHeavyElasticLoad) {
  AxisConfiguration configuration = geared(10, 1);
  configuration.model.coupling = Coupling::two_inertia;
  const LoopReport report = examine_loops(configuration, kLoopPeriod);
  // sqrt(2000 / 3e-4) = 2582 rad/s.
  EXPECT_NEAR(report.load_resonance, 410.9, 0.1);
  // With the motor alone the loop is as fast as the current loop of 1000 Hz; with 101 times the
  // motor's inertia 9.9 Hz remain, and half of that for the position loop.
  EXPECT_NEAR(report.velocity_bandwidth, 1'000.0 / 101.0, 1e-6);
  EXPECT_NEAR(report.position_bandwidth, 500.0 / 101.0, 1e-6);
}

TEST(LoopReport, FindsTheRingingOfALightlyDampedLoad) {
  AxisConfiguration configuration = geared(1, 10);
  configuration.model.coupling = Coupling::two_inertia;
  configuration.model.load_inertia = 3.0e-3;
  const LoopReport report = examine_loops(configuration, kLoopPeriod);
  // 3e-3 kg.m2 on 2000 N.m/rad: 816 rad/s = 130 Hz; its own damping is 0.05 / 2 / 2.45 = 0.01, four
  // time constants of which are 0.48 s. The loops add to that.
  EXPECT_NEAR(report.ringing, 130.0, 3.0);
  EXPECT_GT(report.ringing_time, 0.1);
  EXPECT_LT(report.ringing_time, 0.48);
}

TEST(Loops, OfALiftHaveTheBandwidthOfItsShaft) {
  const LoopReport report = examine_loops(lift(), kLoopPeriod);
  // The damping of the velocity loop is matched to the spring:
  // r² sqrt(k J) / Jm = 0.01 · 14.14 / 3e-4 = 471 1/s, which is 17.3 Hz with 4.33 times the motor's
  // inertia. The position loop is reduced in proportion, to 2.8 Hz.
  EXPECT_NEAR(report.velocity_bandwidth, 17.3, 0.1);
  EXPECT_NEAR(report.position_bandwidth, 2.77, 0.01);
  EXPECT_LT(report.ringing_time, 0.1);
}

// With the configured 100 Hz and 16 Hz the loop of the load encoder excites the load at 24 Hz: a
// second later the axis still swings by 38 UU.
TEST(Loops, HoldALiftBehindAReducingGearWithoutRinging) {
  AxisUnderTest axis(lift());
  axis.enable();
  axis.step(100);
  ASSERT_EQ(axis.actual(), 0);
  axis.write("test_load_torque", 5'000);  // 5 N.m at the load: 0.5 N.m at the motor
  std::int32_t first = 0;
  std::int32_t opposite = 0;
  for (int tick = 0; tick < 1'000; ++tick) {
    axis.step();
    first = std::max(first, axis.actual());
    opposite = std::min(opposite, axis.actual());
  }
  EXPECT_EQ(axis.state(), PowerState::operation_enabled);
  // A load of 0.1 kg.m2 and the loops of the previous test: 7.3 UU, from an integration of the
  // linear model.
  EXPECT_NEAR(first, 7, 2);
  // With a damping of 0.6 it swings back by exp(-0.6 π / 0.8) = 9.5 %, which is less than a unit.
  EXPECT_GE(opposite, -1);
  EXPECT_LE(std::abs(axis.actual()), 1) << "it is at rest after a second";
}

}  // namespace
}  // namespace vdrive
