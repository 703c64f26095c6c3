// SPDX-License-Identifier: Apache-2.0
// plan_velocity: from any state to any velocity, as fast as the accelerations allow.
#include "support/random_cases.hpp"
#include "vdrive/motion/profile.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace vdrive {
namespace {

using test::Random;

double sign_of(double x) {
  return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0);
}

double capped(double target, const MotionLimits& limits) {
  return std::clamp(target, -limits.velocity, limits.velocity);
}

/// Time to reach the target: |dv|/d towards zero velocity, |dv|/a away from it.
double least_time(double from, double to, const MotionLimits& limits) {
  const bool reverses = from * to < 0.0;
  const double slower = reverses ? std::abs(from) : std::max(std::abs(from) - std::abs(to), 0.0);
  const double faster = reverses ? std::abs(to) : std::max(std::abs(to) - std::abs(from), 0.0);
  return slower / limits.deceleration + faster / limits.acceleration;
}

/// The time at which the profile's last change of velocity ends.
double change_time(const Profile& profile) {
  const std::size_t count = profile.segment_count();
  if (count == 0) return 0.0;
  const bool runs = std::isinf(profile.duration());
  return runs ? profile.segment(count - 1).reference_time : profile.duration();
}

TEST(PlanTimedMove, GivesTheTrapezoidOfTheTimes) {
  for (const double way : {6.0, -6.0}) {
    // Ramps of 1 s and 2 s in 4.5 s: the peak is 6 / (4.5 - 1.5) = 2.
    const Profile profile = plan_timed_move(
        10.0, 10.0 + way, {.duration = 4.5, .acceleration = 1.0, .deceleration = 2.0});
    const double sign = way / 6.0;
    EXPECT_EQ(profile.duration(), 4.5);
    EXPECT_EQ(profile.at(0.5).position, 10.0 + sign * 0.25);  // 2·0.5²/2
    EXPECT_EQ(profile.at(1.0).position, 10.0 + sign * 1.0);
    EXPECT_EQ(profile.at(1.0).velocity, sign * 2.0);
    EXPECT_EQ(profile.at(1.75).position, 10.0 + sign * 2.5);
    EXPECT_EQ(profile.at(2.5).position, 10.0 + sign * 4.0);
    EXPECT_EQ(profile.at(3.5).position, 10.0 + sign * 5.5);  // 1·1²/2 before the end
    EXPECT_EQ(profile.at(3.5).velocity, sign * 1.0);
    EXPECT_EQ(profile.at(4.5).position, 10.0 + way);
    EXPECT_EQ(profile.at(4.5).velocity, 0.0);
  }
}

TEST(PlanVelocity, AcceleratesAndThenRunsWithoutEnd) {
  const Profile profile =
      plan_velocity({100.0, 0.0}, 50.0, {.velocity = 80.0, .acceleration = 25.0});
  // 50/25 = 2 s over 50·2/2 = 50 units.
  EXPECT_TRUE(std::isinf(profile.duration()));
  EXPECT_DOUBLE_EQ(profile.at(1.0).velocity, 25.0);
  EXPECT_DOUBLE_EQ(profile.at(2.0).position, 150.0);
  EXPECT_DOUBLE_EQ(profile.at(2.0).velocity, 50.0);
  EXPECT_DOUBLE_EQ(profile.at(1002.0).position, 50'150.0);
  EXPECT_EQ(profile.at(1002.0).acceleration, 0.0);
}

TEST(PlanVelocity, SlowsDownWithTheDeceleration) {
  const Profile profile = plan_velocity(
      {0.0, -100.0}, -40.0, {.velocity = 200.0, .acceleration = 1.0, .deceleration = 30.0});
  EXPECT_DOUBLE_EQ(change_time(profile), 2.0);
  EXPECT_DOUBLE_EQ(profile.at(1.0).velocity, -70.0);
  EXPECT_DOUBLE_EQ(profile.at(10.0).velocity, -40.0);
}

TEST(PlanVelocity, ReversesWithBothRamps) {
  const Profile profile = plan_velocity(
      {0.0, 60.0}, -20.0, {.velocity = 200.0, .acceleration = 10.0, .deceleration = 30.0});
  // 60/30 = 2 s to rest at 60, then 20/10 = 2 s back to -20 at 40.
  EXPECT_DOUBLE_EQ(profile.at(2.0).velocity, 0.0);
  EXPECT_DOUBLE_EQ(profile.at(2.0).position, 60.0);
  EXPECT_DOUBLE_EQ(profile.at(4.0).velocity, -20.0);
  EXPECT_DOUBLE_EQ(profile.at(4.0).position, 40.0);
}

TEST(PlanVelocity, IsCappedByTheVelocityLimit) {
  for (const double sign : {1.0, -1.0}) {
    const Profile profile =
        plan_velocity({0.0, 0.0}, sign * 1.0e9, {.velocity = 30.0, .acceleration = 10.0});
    EXPECT_DOUBLE_EQ(profile.at(2.0).velocity, sign * 20.0);
    EXPECT_DOUBLE_EQ(profile.at(1.0e6).velocity, sign * 30.0);
  }
}

TEST(PlanVelocity, AStartAboveTheLimitSlowsDownToIt) {
  const Profile profile =
      plan_velocity({0.0, 90.0}, 90.0, {.velocity = 30.0, .deceleration = 20.0});
  EXPECT_DOUBLE_EQ(change_time(profile), 3.0);
  EXPECT_DOUBLE_EQ(profile.at(5.0).velocity, 30.0);
}

TEST(PlanVelocity, TheSlowestVelocityRunsWithoutEnd) {
  for (const double target : {0.25, -0.25, 1.0, -1.0}) {
    const Profile profile = plan_velocity(
        {0.0, 0.0}, target, {.velocity = 10.0, .acceleration = 1.0, .deceleration = 1.0});
    EXPECT_EQ(profile.at(1.0e6).velocity, target);
    // Starting from rest costs v²/2 = v·t/2 compared with full speed all the way.
    EXPECT_NEAR(profile.at(1.0e6).position, target * 1.0e6 - 0.5 * target * std::abs(target), 1e-6);
  }
}

TEST(PlanVelocity, AcceptsAStartVelocityBelow1) {
  const Profile profile =
      plan_velocity({0.0, 0.5}, 5.0, {.velocity = 10.0, .acceleration = 1.0, .deceleration = 2.0});
  EXPECT_EQ(profile.at(0.0).velocity, 0.5);
  EXPECT_EQ(profile.at(1.0).velocity, 1.5);
  EXPECT_EQ(profile.at(1.0).position, 1.0);  // 0.5·1 + 1·1²/2
}

TEST(PlanVelocity, ToZeroEndsAtRestAtTheEndOfTheRamp) {
  const Profile profile =
      plan_velocity({10.0, -40.0}, 0.0, {.velocity = 100.0, .deceleration = 20.0});
  EXPECT_DOUBLE_EQ(profile.duration(), 2.0);
  EXPECT_DOUBLE_EQ(profile.end_position(), -30.0);
  EXPECT_EQ(profile.at(3.0).velocity, 0.0);
}

TEST(PlanVelocity, FromRestToZeroOrWithoutVelocityGivesNoMotion) {
  EXPECT_EQ(plan_velocity({5.0, 0.0}, 0.0, {.velocity = 10.0}).segment_count(), 0U);
  EXPECT_EQ(plan_velocity({5.0, 0.0}, -0.0, {.velocity = 10.0}).segment_count(), 0U);
  const Profile still = plan_velocity({5.0, 0.0}, 100.0, {.velocity = 0.0});
  EXPECT_EQ(still.segment_count(), 0U);
  EXPECT_EQ(still.end_position(), 5.0);
}

TEST(PlanVelocity, KeepsThePresentVelocityWithoutARamp) {
  const Profile profile = plan_velocity({5.0, 70.0}, 70.0, {.velocity = 100.0});
  ASSERT_EQ(profile.segment_count(), 1U);
  EXPECT_EQ(profile.segment(0).acceleration, 0.0);
  EXPECT_EQ(profile.at(3.0).position, 215.0);
}

struct VelocityCase {
  MotionState start;
  double target = 0.0;
  MotionLimits limits;
};

VelocityCase random_velocity_case(Random& random) {
  const auto magnitude = [&random](double most) {
    return most * std::pow(10.0, -6.0 * random.unit());
  };
  const auto velocity = [&random, &magnitude] {
    return random.one_in(8) ? 0.0 : (random.one_in(2) ? 1.0 : -1.0) * magnitude(1.0e7);
  };
  return {.start = {.position = (random.unit() - 0.5) * 4.0e9, .velocity = velocity()},
          .target = velocity(),
          .limits = {.velocity = random.one_in(10) ? 0.0 : magnitude(1.0e7),
                     .acceleration = magnitude(4.0e9),
                     .deceleration = magnitude(4.0e9)}};
}

void expect_properties(const VelocityCase& c) {
  const Profile profile = plan_velocity(c.start, c.target, c.limits);
  const double goal = capped(c.target, c.limits);
  const double time = least_time(c.start.velocity, goal, c.limits);
  ASSERT_NEAR(change_time(profile), time, 1e-12 + 1e-9 * time);
  const double late = profile.at(2.0 * time + 1.0).velocity;
  ASSERT_NEAR(late, goal, 1e-9 * std::abs(goal));

  // Continuity: each piece starts where the previous one ended.
  MotionState end = c.start;
  double start_time = 0.0;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    const Segment& segment = profile.segment(i);
    const MotionSample first = sample(segment, start_time);
    const double scale = std::abs(c.start.velocity) + std::abs(goal);
    ASSERT_NEAR(first.velocity, end.velocity, 1e-9 * scale + 1e-12);
    ASSERT_NEAR(first.position, end.position, 1e-6 + 1e-9 * scale * (start_time + 1.0));
    ASSERT_TRUE(segment.acceleration == 0.0 ||
                std::abs(segment.acceleration) == c.limits.acceleration ||
                std::abs(segment.acceleration) == c.limits.deceleration);
    if (std::isinf(segment.end_time)) break;
    const MotionSample last = sample(segment, segment.end_time);
    // It slows down with one acceleration and speeds up with the other.
    const bool slows = std::abs(last.velocity) < std::abs(first.velocity);
    ASSERT_EQ(std::abs(segment.acceleration),
              slows ? c.limits.deceleration : c.limits.acceleration);
    end = {last.position, last.velocity};
    start_time = segment.end_time;
  }

  // Always between start and goal.
  const double low = std::min(c.start.velocity, goal);
  const double high = std::max(c.start.velocity, goal);
  for (int i = 0; i <= 8; ++i) {
    const double v = profile.at(time * i / 8.0).velocity;
    ASSERT_GE(v, low - 1e-9 * std::abs(low));
    ASSERT_LE(v, high + 1e-9 * std::abs(high));
  }
}

TEST(PlanVelocity, HoldsItsPropertiesInRandomCases) {
  const std::uint64_t cases = test::case_count(100'000, 10'000'000);
  Random random(11);
  for (std::uint64_t i = 0; i < cases; ++i) {
    SCOPED_TRACE("case " + std::to_string(i));
    ASSERT_NO_FATAL_FAILURE(expect_properties(random_velocity_case(random)));
  }
}

TEST(PlanVelocity, IsSymmetricInTheSign) {
  Random random(12);
  for (int i = 0; i < 2'000; ++i) {
    const VelocityCase c = random_velocity_case(random);
    const Profile a = plan_velocity(c.start, c.target, c.limits);
    const Profile b = plan_velocity({-c.start.position, -c.start.velocity}, -c.target, c.limits);
    const double time = change_time(a);
    ASSERT_EQ(time, change_time(b));
    for (const double t : {0.0, 0.3 * time, 0.9 * time, time, time + 1.0}) {
      ASSERT_EQ(a.at(t).velocity, -b.at(t).velocity);
      ASSERT_EQ(a.at(t).position, -b.at(t).position);
    }
    ASSERT_EQ(sign_of(a.at(time + 1.0).velocity), -sign_of(b.at(time + 1.0).velocity));
  }
}

}  // namespace
}  // namespace vdrive
