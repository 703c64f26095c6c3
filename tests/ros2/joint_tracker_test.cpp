// SPDX-License-Identifier: Apache-2.0
#include "joint_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <random>

namespace vdrive::ros2 {
namespace {

constexpr double kTick = 0.001;

JointLimits limits() {
  JointLimits limits;
  limits.velocity = 10.0;
  limits.ramp = 100.0;
  return limits;
}

TEST(JointTracker, StaysInPlaceUntilAPositionArrives) {
  JointTracker tracker(JointMotion{0.7});
  EXPECT_TRUE(tracker.is_at_rest());
  EXPECT_EQ(tracker.step(kTick, limits()).position, 0.7);
}

TEST(JointTracker, RestsExactlyAtTheLastPosition) {
  JointTracker tracker(JointMotion{0.0});
  tracker.go_to(1.0, 0.01);
  double highest = 0.0;
  int ticks = 0;
  while (!tracker.is_at_rest() && ++ticks < 10'000) {
    highest = std::max(highest, tracker.step(kTick, limits()).position);
  }
  EXPECT_EQ(tracker.now().position, 1.0);
  EXPECT_LE(highest, 1.0 + 1e-12) << "no overshoot";
  // 0.1 s and 0.5 rad to 10 rad/s, and the same to rest: 0.2 s.
  EXPECT_NEAR(ticks, 200, 3);
}

TEST(JointTracker, FollowsARampOfSeparatePositionsAtConstantSpeed) {
  JointTracker tracker(JointMotion{0.0});
  double slowest = 1e9;
  double fastest = 0.0;
  for (int command = 1; command <= 100; ++command) {
    tracker.go_to(0.01 * command, 0.015);  // 1 rad/s at 100 Hz; the line is half as long again
    for (int tick = 0; tick < 10; ++tick) {
      const double speed = tracker.step(kTick, limits()).velocity;
      if (command > 50) {
        slowest = std::min(slowest, speed);
        fastest = std::max(fastest, speed);
      }
    }
  }
  EXPECT_NEAR(slowest, 1.0, 0.01);
  EXPECT_NEAR(fastest, 1.0, 0.01);
}

TEST(JointTracker, KeepsItsLimitsForAnyPositions) {
  std::mt19937 random(4711);  // NOLINT(cert-*): the same every time
  std::uniform_real_distribution<double> goals(-3.0, 3.0);
  std::uniform_real_distribution<double> times(0.0, 0.05);
  JointTracker tracker(JointMotion{0.0});
  JointMotion before = tracker.now();
  for (int command = 0; command < 2'000; ++command) {
    tracker.go_to(goals(random), times(random));
    for (int tick = 0; tick < 17; ++tick) {
      const JointMotion now = tracker.step(kTick, limits());
      ASSERT_LE(std::abs(now.velocity), 10.0 + 1e-9);
      ASSERT_LE(std::abs(now.velocity - before.velocity), 100.0 * kTick + 1e-9);
      ASSERT_NEAR(now.position, before.position + now.velocity * kTick, 1e-8);
      before = now;
    }
  }
}

TEST(JointTracker, BrakesToRestOnItsRamp) {
  JointTracker tracker(JointMotion{1.0, 5.0});
  tracker.stop(limits());
  int ticks = 0;
  while (!tracker.is_at_rest() && ++ticks < 1'000) (void)tracker.step(kTick, limits());
  EXPECT_NEAR(tracker.now().position, 1.125, 1e-9);  // 1 + 5² / (2 * 100)
  EXPECT_NEAR(ticks, 50, 3);
}

// ---- velocities and efforts

TEST(ValueLine, StaysAtItsStartUntilAValueArrives) {
  ValueLine line(0.7);
  EXPECT_TRUE(line.is_at_goal());
  EXPECT_EQ(line.step(kTick, 1.0), 0.7);
}

// 1 in 10 ms is 0.1 per tick.
TEST(ValueLine, ReachesAValueInAStraightLineAndExactly) {
  ValueLine line(0.0);
  line.go_to(1.0, 0.01);
  double last = 0.0;
  int ticks = 0;
  while (!line.is_at_goal() && ++ticks < 100) {
    const double now = line.step(kTick, 1'000.0);
    if (ticks <= 10) {
      EXPECT_NEAR(now - last, 0.1, 1e-12);
    }
    last = now;
  }
  EXPECT_EQ(last, 1.0);
  EXPECT_NEAR(ticks, 10, 1);
}

// The slope limits a line of 0.1 per tick to 0.02.
TEST(ValueLine, IsAsSlowAsItsSlope) {
  ValueLine line(0.0);
  line.go_to(-1.0, 0.01);
  int ticks = 0;
  while (!line.is_at_goal() && ++ticks < 100) (void)line.step(kTick, 20.0);
  EXPECT_NEAR(ticks, 50, 1);
}

TEST(ValueLine, TurnsAtOnceToAnotherValue) {
  ValueLine line(0.0);
  line.go_to(10.0, 0.0);
  for (int tick = 0; tick < 10; ++tick) (void)line.step(kTick, 100.0);
  line.go_to(-10.0, 0.0);
  EXPECT_NEAR(line.step(kTick, 100.0), 0.9, 1e-12) << "1.0 less a step of 0.1";
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
      const double now = line.step(kTick, 100.0);
      ASSERT_LE(std::abs(now - before), 0.1 + 1e-12)
          << std::setprecision(17) << "at " << before << ": line.go_to(" << goal << ", " << time
          << "), tick " << tick;
      before = now;
    }
  }
}

}  // namespace
}  // namespace vdrive::ros2
