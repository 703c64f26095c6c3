// SPDX-License-Identifier: Apache-2.0
#include "value_line.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iomanip>
#include <random>

namespace vdrive::ros2 {
namespace {

constexpr double kPeriod = 0.001;

TEST(ValueLine, StaysAtItsStartUntilAValueArrives) {
  ValueLine line(0.7);
  EXPECT_TRUE(line.is_at_goal());
  EXPECT_EQ(line.step(kPeriod, 1.0), 0.7);
}

// 1 in 10 ms is 0.1 a tick.
TEST(ValueLine, ReachesAValueInAStraightLineAndExactly) {
  ValueLine line(0.0);
  line.go_to(1.0, 0.01);
  double last = 0.0;
  int ticks = 0;
  while (!line.is_at_goal() && ++ticks < 100) {
    const double now = line.step(kPeriod, 1'000.0);
    if (ticks <= 10) {
      EXPECT_NEAR(now - last, 0.1, 1e-12);
    }
    last = now;
  }
  EXPECT_EQ(last, 1.0);
  EXPECT_NEAR(ticks, 10, 1);
}

// A line that would have 0.1 a tick has 0.02.
TEST(ValueLine, IsAsSlowAsItsSlope) {
  ValueLine line(0.0);
  line.go_to(-1.0, 0.01);
  int ticks = 0;
  while (!line.is_at_goal() && ++ticks < 100) (void)line.step(kPeriod, 20.0);
  EXPECT_NEAR(ticks, 50, 1);
}

TEST(ValueLine, TurnsAtOnceToAnotherValue) {
  ValueLine line(0.0);
  line.go_to(10.0, 0.0);
  for (int tick = 0; tick < 10; ++tick) (void)line.step(kPeriod, 100.0);
  line.go_to(-10.0, 0.0);
  EXPECT_NEAR(line.step(kPeriod, 100.0), 0.9, 1e-12) << "1.0 less a step of 0.1";
}

TEST(ValueLine, KeepsItsSlopeForAnyValues) {
  std::mt19937 random(4711);  // NOLINT(cert-*): the same every time
  std::uniform_real_distribution<double> goals(-3.0, 3.0);
  std::uniform_real_distribution<double> times(0.0, 0.05);
  ValueLine line(0.0);
  double before = 0.0;
  for (int command = 0; command < 2'000; ++command) {
    const double goal = goals(random);
    const double time = times(random);
    line.go_to(goal, time);
    for (int tick = 0; tick < 17; ++tick) {
      const double now = line.step(kPeriod, 100.0);
      ASSERT_LE(std::abs(now - before), 0.1 + 1e-12)
          << std::setprecision(17) << "at " << before << ": line.go_to(" << goal << ", " << time
          << "), tick " << tick;
      before = now;
    }
  }
}

}  // namespace
}  // namespace vdrive::ros2
