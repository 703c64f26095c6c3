// SPDX-License-Identifier: Apache-2.0
// Plans of limited jerk: cases from textbooks with numbers worked by hand, then properties of
// random plans, judged by a checker that knows the limits only, and their time by an enumeration.
#include "vdrive/motion/jerk_profile.hpp"

#include "core/support/random_cases.hpp"
#include "support/effort.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iomanip>
#include <limits>
#include <ostream>
#include <utility>

namespace vdrive {
namespace {

using test::number_of;
using test::Random;

constexpr double kUlp = std::numeric_limits<double>::epsilon();

struct JerkCase {
  MotionSample start;
  double target = 0.0;
  MotionLimits limits;
  MotionJerk jerk;
};

/// A failing case as an initialiser that can be pasted into a test.
std::ostream& operator<<(std::ostream& out, const JerkCase& c) {
  return out << std::setprecision(17) << "JerkCase{.start = {" << c.start.position << ", "
             << c.start.velocity << ", " << c.start.acceleration << "}, .target = " << c.target
             << ", .limits = {" << c.limits.velocity << ", " << c.limits.acceleration << ", "
             << c.limits.deceleration << "}, .jerk = {" << c.jerk.acceleration << ", "
             << c.jerk.deceleration << "}}";
}

JerkProfile plan_of(const JerkCase& c) {
  return plan_jerk_move(c.start, c.target, c.limits, c.jerk);
}

// ---- cases by hand ------------------------------------------------------------------------------

constexpr MotionLimits kLimits{.velocity = 100.0, .acceleration = 200.0, .deceleration = 200.0};
constexpr MotionJerk kJerk{.acceleration = 1000.0, .deceleration = 1000.0};

TEST(JerkProfile, RunsTheSevenSegmentsOfTheTextbook) {
  // 200 units/s² are built up in 0.2 s, to 20 units/s and 1000·0.2³/6 = 4/3 units. 80 units/s after
  // 0.3 s more, 4/3 + 20·0.3 + 200·0.3²/2 = 49/3 units. 100 units/s at 0.7 s, half of 100·0.7 = 35
  // units. The same to brake; 30 units are left for 0.3 s at 100 units/s.
  const JerkProfile profile = plan_jerk_move({}, 100.0, kLimits, kJerk);

  ASSERT_EQ(profile.segment_count(), 7U);
  EXPECT_NEAR(profile.duration(), 1.7, 1.0e-12);
  EXPECT_NEAR(profile.at(0.2).position, 4.0 / 3.0, 1.0e-12);
  EXPECT_NEAR(profile.at(0.2).velocity, 20.0, 1.0e-12);
  EXPECT_NEAR(profile.at(0.2).acceleration, 200.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.5).position, 49.0 / 3.0, 1.0e-12);
  EXPECT_NEAR(profile.at(0.5).velocity, 80.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.7).position, 35.0, 1.0e-12);
  EXPECT_EQ(profile.at(0.85).velocity, 100.0);
  EXPECT_EQ(profile.at(0.85).acceleration, 0.0);
  EXPECT_NEAR(profile.at(1.35).acceleration, -200.0, 1.0e-9);
  EXPECT_EQ(profile.end_position(), 100.0);
  EXPECT_TRUE(profile.reaches_target());
}

TEST(JerkProfile, RunsAShortMoveByItsJerkAlone) {
  // Four times T with 2·J·T³ = way: T = 0.1 s for 2 units. The peak is J·T² = 10 units/s.
  const JerkProfile profile = plan_jerk_move({}, 2.0, kLimits, kJerk);

  ASSERT_EQ(profile.segment_count(), 3U) << "the two falls in the middle are one";
  EXPECT_NEAR(profile.duration(), 0.4, 1.0e-12);
  EXPECT_NEAR(profile.at(0.1).acceleration, 100.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.2).velocity, 10.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.2).position, 1.0, 1.0e-11);
}

TEST(JerkProfile, HoldsTheAccelerationWhereTheVelocityIsNotReached) {
  // 50 units/s² after 0.05 s; held for 0.1 s: the peak is 50·0.15 = 7.5 units/s after 0.2 s, the
  // way to it 7.5·0.2/2 units, and once more to brake.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 50.0, .deceleration = 50.0};
  const JerkProfile profile = plan_jerk_move({}, 1.5, limits, kJerk);

  ASSERT_EQ(profile.segment_count(), 5U);
  EXPECT_NEAR(profile.duration(), 0.4, 1.0e-12);
  EXPECT_NEAR(profile.at(0.1).acceleration, 50.0, 1.0e-12);
  EXPECT_NEAR(profile.at(0.2).velocity, 7.5, 1.0e-11);
}

TEST(JerkProfile, BrakesByItsDeceleration) {
  // Up as above: 0.7 s, 35 units. Down by 100 units/s²: 100/100 + 100/1000 = 1.1 s, 55 units. 110
  // units are left.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 200.0, .deceleration = 100.0};
  const JerkProfile profile = plan_jerk_move({}, 200.0, limits, kJerk);

  EXPECT_NEAR(profile.duration(), 0.7 + 1.1 + 1.1, 1.0e-12);
  EXPECT_NEAR(profile.at(2.35).acceleration, -100.0, 1.0e-9);
}

TEST(JerkProfile, HasAJerkForEachRamp) {
  // Down with 500 units/s³: 100/200 + 200/500 = 0.9 s, 45 units. 20 units are left.
  const MotionJerk jerk{.acceleration = 1000.0, .deceleration = 500.0};
  const JerkProfile profile = plan_jerk_move({}, 100.0, kLimits, jerk);

  EXPECT_NEAR(profile.duration(), 0.7 + 0.2 + 0.9, 1.0e-12);
  EXPECT_EQ(profile.segment(0).jerk, 1000.0);
  EXPECT_EQ(profile.segment(6).jerk, 500.0);
}

TEST(JerkProfile, MeetsAVelocityThatItsAccelerationForcesItOver) {
  // 200 units/s² end after 0.2 s, at 95 + 200²/2000 = 115 units/s. From there 15 units/s down:
  // twice T with J·T² = 15.
  const JerkProfile profile = plan_jerk_velocity({0.0, 95.0, 200.0}, 100.0, kLimits, kJerk);

  EXPECT_NEAR(profile.at(0.2).velocity, 115.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.2).acceleration, 0.0, 1.0e-9);
  const double down = std::sqrt(15.0 / 1000.0);
  EXPECT_NEAR(profile.at(0.2 + down).velocity, 107.5, 1.0e-11);
  EXPECT_EQ(profile.at(0.2 + 2.0 * down + 1.0e-9).velocity, 100.0);
  EXPECT_TRUE(std::isinf(profile.duration()));
}

TEST(JerkProfile, StopsAnAxisThatSpeedsUpAfterTheRestOfItsAcceleration) {
  // 0.1 s up to 15 units/s: 10·0.1 + 100·0.1²/2 - 1000·0.1³/6 = 4/3 units. Then twice T with
  // J·T² = 15 over 15·T.
  const JerkProfile profile = plan_jerk_stop({0.0, 10.0, 100.0}, 200.0, kJerk);

  const double brake = std::sqrt(15.0 / 1000.0);
  EXPECT_NEAR(profile.at(0.1).velocity, 15.0, 1.0e-12);
  EXPECT_NEAR(profile.duration(), 0.1 + 2.0 * brake, 1.0e-12);
  EXPECT_NEAR(profile.end_position(), 4.0 / 3.0 + 15.0 * brake, 1.0e-12);
  EXPECT_EQ(profile.at(profile.duration()).position, profile.end_position());
}

TEST(JerkProfile, ComesBackFromAnOvershootThatItCannotAvoid) {
  // -200 units/s² end after 0.2 s, at 5 - 20 = -15 units/s, at 5·0.2 - 200·0.2²/2 + 1000·0.2³/6 =
  // -5/3 units. The stop takes 15·T more.
  const MotionSample start{0.0, 5.0, -200.0};
  const double back = std::sqrt(15.0 / 1000.0);
  const double rest = -5.0 / 3.0 - 15.0 * back;

  const JerkProfile stop = plan_jerk_stop(start, 200.0, kJerk);
  EXPECT_NEAR(stop.duration(), 0.2 + 2.0 * back, 1.0e-12);
  EXPECT_NEAR(stop.end_position(), rest, 1.0e-12);

  // A target on the near side of that is reached from behind, without a rest there.
  const JerkProfile move = plan_jerk_move(start, rest + 2.0, kLimits, kJerk);
  EXPECT_EQ(move.end_position(), rest + 2.0);
  EXPECT_GT(move.at(move.duration() - 0.05).velocity, 0.0);
  EXPECT_LT(move.duration(), stop.duration() + 0.4) << "0.4 s from rest to rest";
}

TEST(JerkProfile, BrakesTwiceForATargetALittleBehindTheEndOfItsStop) {
  // 50 units/s at -100 units/s²: 0.45 s down to 5 units/s, 12.375 units, then 0.1 s and 1/6 unit.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 200.0, .deceleration = 100.0};
  const MotionSample start{0.0, 50.0, -100.0};
  const double rest = 12.375 + 1.0 / 6.0;
  EXPECT_NEAR(plan_jerk_stop(start, 100.0, kJerk).end_position(), rest, 1.0e-12);

  const JerkProfile profile = plan_jerk_move(start, rest + 0.05, limits, kJerk);
  ASSERT_EQ(profile.segment_count(), 4U) << "less, more, held, to rest";
  EXPECT_EQ(profile.segment(0).jerk, 1000.0);
  EXPECT_EQ(profile.segment(1).jerk, -1000.0);
  EXPECT_EQ(profile.segment(2).jerk, 0.0);
  EXPECT_EQ(profile.segment(3).jerk, 1000.0);
  for (double time = 0.0; time < profile.duration(); time += 1.0e-3) {
    EXPECT_LE(profile.at(time).acceleration, 0.0) << time;
  }
}

TEST(JerkProfile, TurnsWithTheSmallerAccelerationOfBothRamps) {
  for (const auto& [acceleration, deceleration] :
       {std::pair{50.0, 200.0}, std::pair{200.0, 50.0}}) {
    const MotionLimits limits{
        .velocity = 100.0, .acceleration = acceleration, .deceleration = deceleration};
    const JerkProfile profile = plan_jerk_velocity({0.0, -100.0, 0.0}, 100.0, limits, kJerk);

    double slowing = 0.0;
    double turning = 0.0;
    double speeding = 0.0;
    for (double time = 0.0; time < 6.0; time += 1.0e-4) {
      const MotionSample now = profile.at(time);
      double& highest = std::abs(now.velocity) < 0.01 ? turning
                        : now.velocity < 0.0          ? slowing
                                                      : speeding;
      highest = std::max(highest, now.acceleration);
    }
    // 0.01 units/s beside 0 the acceleration is (2·1000·0.01)/(2·50) = 0.2 higher at most.
    EXPECT_NEAR(turning, 50.0, 0.25);
    EXPECT_NEAR(slowing, deceleration, 1.0e-9);
    EXPECT_NEAR(speeding, acceleration, 1.0e-9);
    // The ramp of 50 units/s²: 0.05 s for 1.25 units/s at its outer end, 98.75/50 = 1.975 s held.
    // The one of 200: 0.2 s and 20 units/s, 61.25/200 = 0.30625 s held, 0.15 s and 18.75 units/s
    // between 50 and 200 units/s².
    const JerkSegment& last = profile.segment(profile.segment_count() - 2);
    EXPECT_NEAR(last.end_time, 0.05 + 1.975 + 0.2 + 0.30625 + 0.15, 1.0e-12);
  }
}

TEST(JerkProfile, TurnsWithTheJerkOfEachRamp) {
  // Slowing down 100 units/s² are built up in 0.2 s, 10 units/s, and held for 40/100 s; speeding up
  // they are held for 45/100 s and taken back in 0.1 s, 5 units/s.
  const MotionLimits limits{.velocity = 50.0, .acceleration = 100.0, .deceleration = 100.0};
  const MotionJerk jerk{.acceleration = 1000.0, .deceleration = 500.0};
  const JerkProfile profile = plan_jerk_velocity({0.0, -50.0, 0.0}, 50.0, limits, jerk);

  EXPECT_NEAR(profile.segment(0).end_time, 0.2, 1.0e-12);
  EXPECT_NEAR(profile.segment(profile.segment_count() - 2).end_time, 0.2 + 0.4 + 0.45 + 0.1,
              1.0e-12);
  EXPECT_NEAR(profile.at(0.6).velocity, 0.0, 1.0e-11);
  EXPECT_EQ(profile.at(2.0).velocity, 50.0);
}

TEST(JerkProfile, ComesBackWithinALowerAccelerationAtOnce) {
  // 150 units/s² where 50 are allowed: 0.1 s of falling, then held.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 50.0, .deceleration = 50.0};
  const JerkProfile profile = plan_jerk_velocity({0.0, 10.0, 150.0}, 100.0, limits, kJerk);

  EXPECT_NEAR(profile.at(0.05).acceleration, 100.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.1).acceleration, 50.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.11).acceleration, 50.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.1).velocity, 20.0, 1.0e-11);  // (150 + 50)/2·0.1
}

TEST(JerkProfile, ComesBackWithinALowerVelocityAtOnce) {
  // From 100 to 50 units/s: 50/200 + 200/1000 = 0.45 s, also where the target is far ahead.
  const MotionLimits limits{.velocity = 50.0, .acceleration = 200.0, .deceleration = 200.0};
  const JerkProfile profile = plan_jerk_move({0.0, 100.0, 0.0}, 1.0e4, limits, kJerk);

  EXPECT_NEAR(profile.at(0.2).acceleration, -200.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.25).velocity, 70.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.45).velocity, 50.0, 1.0e-11);
  EXPECT_EQ(profile.at(0.46).velocity, 50.0);
  EXPECT_EQ(profile.at(100.0).velocity, 50.0);
}

TEST(JerkProfile, GoesBeyondItsTargetWhereTheJerkIsLoweredAtTheBeginOfItsBraking) {
  // With 1000 units/s³ the stop from 100 units/s is the 35 units to the target. With 500 the
  // acceleration takes 0.4 s, to 60 units/s and 100·0.4 - 500·0.4³/6 = 104/3 units; 0.3 s and 9
  // units more to 0 at -200 units/s²: no motion turns before 131/3 units. A stop takes 45.
  const MotionJerk lowered{.acceleration = 500.0, .deceleration = 500.0};
  const JerkProfile profile = plan_jerk_move({0.0, 100.0, 0.0}, 35.0, kLimits, lowered);

  double highest = 0.0;
  int turns = 0;
  for (double time = 1.0e-3; time < profile.duration(); time += 1.0e-3) {
    highest = std::max(highest, profile.at(time).position);
    turns +=
        (profile.at(time).velocity < 0.0) != (profile.at(time - 1.0e-3).velocity < 0.0) ? 1 : 0;
  }
  EXPECT_GE(highest, 131.0 / 3.0 - 1.0e-3);
  EXPECT_LT(highest, 45.0);
  EXPECT_EQ(turns, 1);
  EXPECT_EQ(profile.end_position(), 35.0);
}

TEST(JerkProfile, TurnsBeforeItsTargetWhereTheJerkIsLoweredAtTheEndOfItsBraking) {
  // 20 units/s at -200 units/s²: with 1000 units/s³ 0.2 s and 20·0.2 - 200·0.2²/2 + 1000·0.2³/6 =
  // 4/3 units to rest. With 500 the acceleration ends after 0.4 s, at -20 units/s and -8/3 units.
  // From there to 20 units/s takes 2·√(40/500) s over no way, the stop 2·√(20/500) s and 4 units.
  const MotionJerk lowered{.acceleration = 500.0, .deceleration = 500.0};
  const JerkProfile profile = plan_jerk_move({0.0, 20.0, -200.0}, 4.0 / 3.0, kLimits, lowered);

  EXPECT_NEAR(profile.at(0.4).velocity, -20.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.4).position, -8.0 / 3.0, 1.0e-11);
  EXPECT_EQ(profile.end_position(), 4.0 / 3.0);
  // A target that rounding moves by 1e-15 units costs (1e-15/500)^(1/3) = 1e-6 s at most.
  EXPECT_NEAR(profile.duration(), 0.4 + 2.0 * std::sqrt(0.08) + 0.4, 1.0e-5);
}

TEST(JerkProfile, StaysWithoutVelocity) {
  const MotionLimits none{.velocity = 0.0, .acceleration = 200.0, .deceleration = 200.0};
  const JerkProfile still = plan_jerk_move({3.0, 0.0, 0.0}, 10.0, none, kJerk);
  EXPECT_EQ(still.duration(), 0.0);
  EXPECT_EQ(still.end_position(), 3.0);
  EXPECT_FALSE(still.reaches_target());

  const JerkProfile moving = plan_jerk_move({0.0, 15.0, 0.0}, 10.0, none, kJerk);
  EXPECT_NEAR(moving.end_position(), 15.0 * std::sqrt(0.015), 1.0e-12);
  EXPECT_FALSE(moving.reaches_target());
}

TEST(JerkProfile, EndsAtOnceOnItsTarget) {
  const JerkProfile profile = plan_jerk_move({7.0, 0.0, 0.0}, 7.0, kLimits, kJerk);
  EXPECT_EQ(profile.segment_count(), 0U);
  EXPECT_EQ(profile.at(0.0).position, 7.0);
  EXPECT_TRUE(profile.reaches_target());
}

TEST(JerkProfile, KeepsItsStartBeforeAndItsEndAfterTheMotion) {
  const JerkProfile profile = plan_jerk_move({5.0, 0.0, 0.0}, 105.0, kLimits, kJerk);
  EXPECT_EQ(profile.at(-1.0).position, 5.0);
  for (const double time : {profile.duration(), 1.0e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(profile.at(time).position, 105.0) << time;
    EXPECT_EQ(profile.at(time).velocity, 0.0) << time;
    EXPECT_EQ(profile.at(time).acceleration, 0.0) << time;
  }
}

TEST(JerkProfile, TakesExactlyTheTimesOfASynchronousMove) {
  // 2 s, ramps of 0.6 s and 0.8 s with 0.1 s of jerk at each end: the peak is 130/(2 - 0.7) = 100
  // units/s, the accelerations 100/(0.6 - 0.1) = 200 and 100/(0.8 - 0.1) = 142.857 units/s².
  const MoveTimes times{.duration = 2.0, .acceleration = 0.6, .deceleration = 0.8, .jerk = 0.1};
  const MotionLimits limits = limits_of(-130.0, times);
  EXPECT_NEAR(limits.velocity, 100.0, 1.0e-12);
  EXPECT_NEAR(limits.acceleration, 200.0, 1.0e-9);
  EXPECT_NEAR(limits.deceleration, 1000.0 / 7.0, 1.0e-9);
  EXPECT_NEAR(jerk_of(limits, times).acceleration, 2000.0, 1.0e-6);

  const JerkProfile profile = plan_timed_jerk_move(10.0, -120.0, times);
  EXPECT_EQ(profile.segment_count(), 7U);
  EXPECT_NEAR(profile.duration(), 2.0, 1.0e-12);
  EXPECT_NEAR(profile.at(0.3).acceleration, -200.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.6).position, 10.0 - 30.0, 1.0e-9);  // 100·0.6/2
  EXPECT_NEAR(profile.at(1.0).velocity, -100.0, 1.0e-9);
  EXPECT_NEAR(profile.at(1.2).position, -120.0 + 40.0, 1.0e-9);  // 100·0.8/2
  EXPECT_EQ(profile.at(profile.duration()).position, -120.0);

  const JerkProfile still = plan_timed_jerk_move(10.0, 10.0, times);
  EXPECT_NEAR(still.duration(), 2.0, 1.0e-12);
  EXPECT_EQ(still.at(1.0).position, 10.0);
}

// ---- random plans -------------------------------------------------------------------------------

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.unit());
}

double signed_unit(Random& random) {
  return 2.0 * random.unit() - 1.0;
}

JerkCase random_jerk_case(Random& random) {
  JerkCase c;
  c.limits.velocity = log_uniform(random, 1.0, 1.0e6);
  c.limits.acceleration = log_uniform(random, 1.0e2, 1.0e6);
  c.limits.deceleration =
      random.one_in(3) ? c.limits.acceleration : log_uniform(random, 1.0e2, 1.0e6);
  c.jerk.acceleration = log_uniform(random, 1.0e3, 1.0e8);
  c.jerk.deceleration = random.one_in(2) ? c.jerk.acceleration : log_uniform(random, 1.0e3, 1.0e8);
  if (!random.one_in(3)) {
    c.start.velocity = signed_unit(random) * c.limits.velocity * (random.one_in(4) ? 2.0 : 1.0);
  }
  if (!random.one_in(3)) {
    const double highest = std::max(c.limits.acceleration, c.limits.deceleration);
    c.start.acceleration = signed_unit(random) * highest * (random.one_in(4) ? 2.0 : 1.0);
  }
  c.start.position = std::nearbyint(1.0e6 * signed_unit(random));
  // Far away, near by, and around the end of the stop.
  const double base = random.one_in(3)
                          ? plan_jerk_stop(c.start, c.limits.deceleration, c.jerk).end_position()
                          : c.start.position;
  c.target = base + signed_unit(random) * log_uniform(random, 1.0e-2, 1.0e7);
  return c;
}

/// What rounding may cost.
struct JerkTolerance {
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
};

JerkTolerance tolerance_of_plan(const JerkCase& c, const JerkProfile& profile) {
  double position = std::max(std::abs(c.start.position), std::abs(c.target));
  double velocity = std::max(std::abs(c.start.velocity), c.limits.velocity);
  double acceleration =
      std::max({std::abs(c.start.acceleration), c.limits.acceleration, c.limits.deceleration});
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    position = std::max(position, std::abs(profile.segment(i).position));
    velocity = std::max(velocity, std::abs(profile.segment(i).velocity));
    acceleration = std::max(acceleration, std::abs(profile.segment(i).acceleration));
  }
  const double jerk = std::max(c.jerk.acceleration, c.jerk.deceleration);
  const double instant = 16.0 * kUlp * profile.duration();
  // A velocity follows from a²/2J, whose rounding counts as well.
  const double rounded = 256.0 * kUlp;
  return {rounded * position + instant * velocity,
          rounded * (velocity + acceleration * acceleration / jerk) + instant * acceleration,
          rounded * acceleration + instant * jerk};
}

void expect_continuous(const JerkCase& c, const JerkProfile& profile, const JerkTolerance& slack) {
  MotionSample before = c.start;
  double time = 0.0;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    const JerkSegment& segment = profile.segment(i);
    ASSERT_GE(segment.end_time, time) << c;
    const MotionSample begin = sample(segment, time);
    ASSERT_NEAR(begin.position, before.position, slack.position) << c << " segment " << i;
    ASSERT_NEAR(begin.velocity, before.velocity, slack.velocity) << c << " segment " << i;
    ASSERT_NEAR(begin.acceleration, before.acceleration, slack.acceleration)
        << c << " segment " << i;
    time = segment.end_time;
    before = sample(segment, time);
  }
  ASSERT_TRUE(profile.reaches_target()) << c;
  ASSERT_EQ(profile.end_position(), c.target) << c;
  if (profile.segment_count() == 0) return;
  ASSERT_EQ(before.position, c.target) << c;
  ASSERT_EQ(before.velocity, 0.0) << c;
  ASSERT_EQ(before.acceleration, 0.0) << c;
}

/// @return the velocity in `direction` after an acceleration >= 0 in it has ended at once.
double settled_speed(const MotionSample& state, const MotionJerk& jerk, double direction) {
  const double v = direction * state.velocity;
  const double w = 0.5 * state.acceleration * state.acceleration;
  if (v >= 0.0) return v + w / jerk.acceleration;
  const double until_rest = -v * jerk.deceleration;
  return w <= until_rest ? v + w / jerk.deceleration : (w - until_rest) / jerk.acceleration;
}

/// The highest velocity in the direction that the start forces, whatever is planned.
double forced_speed(const JerkCase& c, double direction) {
  const bool grows = direction * c.start.acceleration > 0.0;
  const double settled =
      grows ? settled_speed(c.start, c.jerk, direction) : direction * c.start.velocity;
  return std::max(settled, c.limits.velocity);
}

/// @return the direction, 1 or -1, against which nothing forces the motion: the start does not go
///         backward, its acceleration ends before that, and the target lies ahead of the fastest
///         stop. Else 0.
double kept_direction(const JerkCase& c, const JerkTolerance& slack) {
  const double rest = plan_jerk_velocity(c.start, 0.0, c.limits, c.jerk).end_position();
  if (std::abs(c.target - rest) <= slack.position) return 0.0;
  const double direction = c.target > rest ? 1.0 : -1.0;
  const double speed = direction * c.start.velocity;
  const double w = 0.5 * c.start.acceleration * c.start.acceleration;
  const bool brakes = direction * c.start.acceleration < 0.0;
  return speed < 0.0 || (brakes && w > speed * c.jerk.deceleration) ? 0.0 : direction;
}

/// @return the lowest and the highest velocity: none against the direction that it has to keep.
std::pair<double, double> allowed_velocities(const JerkCase& c, const JerkTolerance& slack) {
  const double kept = kept_direction(c, slack);
  const double backward = kept > 0.0 ? 0.0 : forced_speed(c, -1.0);
  const double forward = kept < 0.0 ? 0.0 : forced_speed(c, 1.0);
  return {-backward - slack.velocity, forward + slack.velocity};
}

/// @return the shortest time in which the velocity falls by `span`, from no acceleration to none.
double time_of_fall(double span, double deceleration, double jerk) {
  const bool is_capped = span > deceleration * deceleration / jerk;
  return is_capped ? span / deceleration + deceleration / jerk : 2.0 * std::sqrt(span / jerk);
}

/// A start above the velocity limit, or forced over it, is back as soon as the jerk allows: the
/// acceleration ends, then the rest of the velocity goes with the deceleration and its jerk.
void expect_back_at_its_velocity(const JerkCase& c, const JerkProfile& profile,
                                 const JerkTolerance& slack) {
  for (const double direction : {1.0, -1.0}) {
    const double acceleration = direction * c.start.acceleration;
    if (direction * c.start.velocity < 0.0 || acceleration < 0.0) continue;
    const double over = settled_speed(c.start, c.jerk, direction) - c.limits.velocity;
    if (over <= 0.0) continue;
    const double time = acceleration / c.jerk.acceleration +
                        time_of_fall(over, c.limits.deceleration, c.jerk.deceleration);
    ASSERT_LE(direction * profile.at(time).velocity, c.limits.velocity + 4.0 * slack.velocity) << c;
  }
}

/// @return by how much the acceleration is outside of its limits in this state.
double excess_of(const JerkCase& c, const MotionSample& state, const JerkTolerance& slack) {
  const double direction = state.velocity < 0.0 ? -1.0 : 1.0;
  const double along = direction * state.acceleration;
  const double higher = std::max(c.limits.acceleration, c.limits.deceleration);
  // At a velocity that is 0 up to rounding the side is not known.
  const bool has_side = std::abs(state.velocity) > slack.velocity;
  const double up = has_side ? c.limits.acceleration : higher;
  const double down = has_side ? c.limits.deceleration : higher;
  return std::max(along - up, -down - along);
}

void expect_within_limits(const JerkCase& c, const JerkProfile& profile,
                          const JerkTolerance& slack) {
  const auto [lowest, highest] = allowed_velocities(c, slack);
  double begin = 0.0;
  // As long as the acceleration of the start falls at the full jerk, nothing can be done.
  bool only_returns = true;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    const JerkSegment& segment = profile.segment(i);
    const double length = segment.end_time - begin;
    for (int k = 0; k <= 16; ++k) {
      const MotionSample now = sample(segment, begin + length * k / 16.0);
      ASSERT_LE(now.velocity, highest) << c << " segment " << i;
      ASSERT_GE(now.velocity, lowest) << c << " segment " << i;
      const bool returns = only_returns && segment.jerk * c.start.acceleration < 0.0 &&
                           now.acceleration * c.start.acceleration >= 0.0;
      ASSERT_TRUE(returns || excess_of(c, now, slack) <=
                                 4.0 * slack.acceleration + 1.0e-9 * std::abs(now.acceleration))
          << c << " segment " << i << " at " << begin + length * k / 16.0;
      const bool has_quadrant = std::abs(now.velocity) > slack.velocity &&
                                std::abs(now.acceleration) > slack.acceleration && k > 0 && k < 16;
      const double most =
          now.velocity * now.acceleration > 0.0 ? c.jerk.acceleration : c.jerk.deceleration;
      if (has_quadrant) {
        ASSERT_LE(std::abs(segment.jerk), most) << c << " segment " << i;
      }
    }
    only_returns = only_returns && segment.jerk * c.start.acceleration < 0.0;
    begin = segment.end_time;
  }
}

void expect_the_mirror_image(const JerkCase& c, const JerkProfile& profile) {
  const JerkProfile mirror = plan_jerk_move(
      {-c.start.position, -c.start.velocity, -c.start.acceleration}, -c.target, c.limits, c.jerk);
  ASSERT_EQ(mirror.duration(), profile.duration()) << c;
  for (int k = 0; k <= 8; ++k) {
    const double time = profile.duration() * k / 8.0;
    ASSERT_EQ(mirror.at(time).position, -profile.at(time).position) << c;
    ASSERT_EQ(mirror.at(time).velocity, -profile.at(time).velocity) << c;
    ASSERT_EQ(mirror.at(time).acceleration, -profile.at(time).acceleration) << c;
  }
}

/// A part of a fastest motion is the fastest one between its ends.
void expect_the_same_time_from_its_middle(const JerkCase& c, const JerkProfile& profile,
                                          const JerkTolerance& slack, Random& random) {
  const double now = profile.duration() * random.unit();
  JerkCase middle = c;
  middle.start = profile.at(now);
  const JerkProfile again = plan_of(middle);
  // A target that rounding moved by δ costs a detour of about (δ/J)^(1/3).
  const double jerk = std::min(c.jerk.acceleration, c.jerk.deceleration);
  const double detour = 16.0 * std::cbrt(64.0 * slack.position / jerk) +
                        16.0 * std::sqrt(64.0 * slack.velocity / jerk);
  ASSERT_NEAR(now + again.duration(), profile.duration(),
              detour + 1.0e-8 * (profile.duration() + again.duration()))
      << c << " replanned at " << now;
}

TEST(JerkProfileProperty, KeepsItsLimitsAndEndsExactlyInEveryPlan) {
#ifdef __OPTIMIZE__
  const auto cases =
      number_of<std::uint64_t>({.usual = 200'000, .full = 10'000'000, .nightly = 1'000'000'000});
#else
  constexpr std::uint64_t cases = 5'000;
#endif
  Random random(0x6A65726BU);
  for (std::uint64_t i = 0; i < cases; ++i) {
    const JerkCase c = random_jerk_case(random);
    const JerkProfile profile = plan_of(c);
    const JerkTolerance slack = tolerance_of_plan(c, profile);
    ASSERT_TRUE(std::isfinite(profile.duration())) << c;
    ASSERT_LE(profile.segment_count(), JerkProfile::kMaximumSegments) << c;
    expect_continuous(c, profile, slack);
    expect_within_limits(c, profile, slack);
    expect_back_at_its_velocity(c, profile, slack);
    if (i % 16 == 0) {
      expect_the_mirror_image(c, profile);
      expect_the_same_time_from_its_middle(c, profile, slack, random);
    }
    if (HasFatalFailure()) return;
  }
}

TEST(JerkProfileProperty, EndsExactlyWithAnyValuesOfTheRegisters) {
  Random random(0x72656773U);
  const std::uint64_t cases = test::case_count(50'000, 10'000'000);
  for (std::uint64_t i = 0; i < cases; ++i) {
    const auto at_least_one = [&random] {
      return std::max(1.0, static_cast<double>(random.word()));
    };
    JerkCase c;
    c.limits = {static_cast<double>(random.word()), at_least_one(), at_least_one()};
    c.jerk = {at_least_one(), at_least_one()};
    c.start = {static_cast<double>(static_cast<std::int32_t>(random.word())),
               signed_unit(random) * static_cast<double>(random.word()),
               signed_unit(random) * static_cast<double>(random.word())};
    c.target = static_cast<double>(static_cast<std::int32_t>(random.word()));
    const JerkProfile profile = plan_of(c);
    ASSERT_TRUE(std::isfinite(profile.duration())) << c;
    ASSERT_TRUE(std::isfinite(profile.end_position())) << c;
    if (c.limits.velocity == 0.0) continue;
    ASSERT_EQ(profile.end_position(), c.target) << c;
    ASSERT_EQ(profile.at(profile.duration()).position, c.target) << c;
    if (profile.segment_count() == 0) continue;
    const JerkSegment& last = profile.segment(profile.segment_count() - 1);
    ASSERT_EQ(sample(last, last.end_time).position, c.target) << c;
  }
}

// ---- the time -----------------------------------------------------------------------------------

/// One axis with one acceleration for both ramps, in the direction of the first jerk.
struct Enumeration {
  using Real = long double;

  Real v;
  Real a;
  Real distance;
  Real highest_v;
  Real highest_a;
  Real jerk;

  enum class Verdict : std::uint8_t { too_short, fits, too_long };

  struct Outcome {
    Verdict push = Verdict::fits;
    Real way = 0.0L;
    Real time = 0.0L;
  };

  /// Motion at constant jerk `j` for `t`.
  static void go(Real& x, Real& speed, Real& acceleration, Real j, Real t) {
    x += t * (speed + t * (acceleration / 2 + t * j / 6));
    speed += t * (acceleration + t * j / 2);
    acceleration += t * j;
  }

  /// +J (then the cap) for `push`, -J (then the lower cap), +J to rest: each as long as it has to
  /// be.
  [[nodiscard]] Outcome without_cruise(Real push) const {
    Real x = 0.0L;
    Real speed = v;
    Real acceleration = a;
    const Real rise = std::min(push, (highest_a - a) / jerk);
    go(x, speed, acceleration, jerk, rise);
    go(x, speed, acceleration, 0.0L, push - rise);
    // With the lowest acceleration l: speed + a²/2J - l²/J = 0.
    const Real square = jerk * speed + acceleration * acceleration / 2;
    const Real peak = acceleration > 0 ? speed + acceleration * acceleration / (2 * jerk) : speed;
    if (square < 0) return {.push = Verdict::too_short};
    if (peak > highest_v * (1 + 1.0e-15L)) return {.push = Verdict::too_long};
    const Real lowest = std::min(std::sqrt(square), highest_a);
    const Real fall = (acceleration + lowest) / jerk;
    if (fall < 0) return {.push = Verdict::too_short};
    const Real held = (square - lowest * lowest) / (jerk * lowest);
    go(x, speed, acceleration, -jerk, fall);
    if (lowest > 0) go(x, speed, acceleration, 0.0L, held);
    go(x, speed, acceleration, jerk, lowest / jerk);
    return {Verdict::fits, x, push + fall + (lowest > 0 ? held : 0.0L) + lowest / jerk};
  }

  [[nodiscard]] Real error(Real push) const { return without_cruise(push).way - distance; }

  /// Neighbours in [from, to] between which the verdict changes: with that of `from`, and without.
  [[nodiscard]] std::pair<Real, Real> border(Real from, Real to) const {
    const Verdict verdict = without_cruise(from).push;
    for (int i = 0; i < 120; ++i) {
      const Real middle = (from + to) / 2;
      (without_cruise(middle).push == verdict ? from : to) = middle;
    }
    return {from, to};
  }

  [[nodiscard]] Real time_at_root(Real low, Real high) const {
    const bool grows = error(high) > 0;
    for (int i = 0; i < 120; ++i) {
      const Real middle = (low + high) / 2;
      ((error(middle) < 0) == grows ? low : high) = middle;
    }
    return without_cruise(high).time;
  }

  /// Every root in [low, high], where each push fits, also if there were more than one.
  [[nodiscard]] Real shortest_between(Real low, Real high) const {
    constexpr int kPoints = 200;
    Real best = std::numeric_limits<Real>::infinity();
    for (int i = 0; i < kPoints; ++i) {
      const Real from = low + (high - low) * i / kPoints;
      const Real to = i + 1 == kPoints ? high : low + (high - low) * (i + 1) / kPoints;
      if ((error(from) <= 0) != (error(to) <= 0)) best = std::min(best, time_at_root(from, to));
    }
    return best;
  }

  /// While a < 0, +J keeps speed - a²/2J: each push fits or none. From a = 0 on, both the lowest
  /// acceleration and the peak of the velocity grow with the push: first it is too short, then it
  /// fits, then it is too long, at the latest after √(2·2V/2J) of rise and 2V/A of cap.
  [[nodiscard]] Real shortest_without_cruise() const {
    const Real settled = std::max<Real>(-a, 0) / jerk;
    Real best = std::numeric_limits<Real>::infinity();
    if (settled > 0 && without_cruise(0).push == Verdict::fits) {
      best = shortest_between(0, border(0, settled).first);
    }
    Real low = settled;
    Real high = settled + 2 * (std::sqrt(2 * highest_v / jerk) + 2 * highest_v / highest_a);
    if (without_cruise(low).push == Verdict::too_short) low = border(low, high).second;
    if (without_cruise(low).push != Verdict::fits) return best;
    high = border(low, high).first;
    return std::min(best, shortest_between(low, high));
  }

  /// Up to the highest velocity, along it, and down.
  [[nodiscard]] Real with_cruise() const {
    Real x = 0.0L;
    Real speed = v;
    Real acceleration = a;
    const Real square = jerk * (highest_v - v) + a * a / 2;
    const Real peak = std::min(std::sqrt(square), highest_a);
    const Real held = (square - peak * peak) / (jerk * peak);
    go(x, speed, acceleration, jerk, (peak - a) / jerk);
    go(x, speed, acceleration, 0.0L, held);
    go(x, speed, acceleration, -jerk, peak / jerk);
    const Real up = (peak - a) / jerk + held + peak / jerk;
    const Real lowest = std::min(std::sqrt(jerk * highest_v), highest_a);
    const Real down = 2 * lowest / jerk + (jerk * highest_v - lowest * lowest) / (jerk * lowest);
    const Real cruise = distance - x - highest_v * down / 2;
    return cruise < 0 ? std::numeric_limits<Real>::infinity() : up + cruise / highest_v + down;
  }

  [[nodiscard]] Real shortest() const { return std::min(with_cruise(), shortest_without_cruise()); }
};

TEST(JerkProfileProperty, IsNoSlowerThanAnySequenceOfItsJerks) {
#ifdef __OPTIMIZE__
  const auto cases =
      number_of<std::uint64_t>({.usual = 1'000, .full = 100'000, .nightly = 1'000'000});
#else
  constexpr std::uint64_t cases = 100;
#endif
  using Real = Enumeration::Real;
  const auto exact = [](double value) {
    return static_cast<Real>(value);
  };
  Random random(0x74696D65U);
  for (std::uint64_t i = 0; i < cases; ++i) {
    JerkCase c;
    c.limits.velocity = log_uniform(random, 10.0, 1.0e4);
    c.limits.acceleration = log_uniform(random, 1.0e2, 1.0e5);
    c.limits.deceleration = c.limits.acceleration;
    c.jerk.acceleration = log_uniform(random, 1.0e3, 1.0e6);
    c.jerk.deceleration = c.jerk.acceleration;
    c.start.velocity = signed_unit(random) * c.limits.velocity;
    c.start.acceleration = signed_unit(random) * c.limits.acceleration;
    // A start that its acceleration does not force over the velocity.
    const double forced = std::max(forced_speed(c, 1.0), forced_speed(c, -1.0));
    if (forced > c.limits.velocity) c.start.acceleration = 0.0;
    const double rest = plan_jerk_stop(c.start, c.limits.deceleration, c.jerk).end_position();
    // Not nearer: where δ is left the time goes with its cube root, and rest is rounded.
    c.target = rest + (random.one_in(2) ? 1.0 : -1.0) * log_uniform(random, 1.0e-2, 1.0e5);
    Real shortest = std::numeric_limits<Real>::infinity();
    for (const Real sign : {1.0L, -1.0L}) {
      const Enumeration enumeration{.v = sign * exact(c.start.velocity),
                                    .a = sign * exact(c.start.acceleration),
                                    .distance = sign * exact(c.target),
                                    .highest_v = exact(c.limits.velocity),
                                    .highest_a = exact(c.limits.acceleration),
                                    .jerk = exact(c.jerk.acceleration)};
      shortest = std::min(shortest, enumeration.shortest());
    }
    const auto expected = static_cast<double>(shortest);
    ASSERT_TRUE(std::isfinite(expected)) << c;
    ASSERT_NEAR(plan_of(c).duration(), expected, 1.0e-7 * expected) << c;
  }
}

/// How a detour begins: for some time towards some velocity, which keeps the limits.
MotionSample after_a_detour(const JerkCase& c, const MotionSample& start, double time,
                            Random& random) {
  const double velocity = signed_unit(random) * (random.one_in(2) ? 1.0 : 2.0);
  return plan_jerk_velocity(start, velocity * c.limits.velocity, c.limits, c.jerk).at(time);
}

/// The same towards a velocity that lies ahead in `direction`: the acceleration stays >= 0 in it.
MotionSample after_a_hesitation(const JerkCase& c, const MotionSample& start, double direction,
                                double time, Random& random) {
  const double settled = settled_speed(start, c.jerk, direction);
  const double velocity = settled + random.unit() * (c.limits.velocity - settled);
  return plan_jerk_velocity(start, direction * velocity, c.limits, c.jerk).at(time);
}

/// What rounding may cost: a target that it moved by δ costs a detour of about (δ/J)^(1/3).
double rounding_of_time(const JerkCase& c, const JerkProfile& direct) {
  const JerkTolerance slack = tolerance_of_plan(c, direct);
  const double jerk = std::min(c.jerk.acceleration, c.jerk.deceleration);
  return 16.0 * std::cbrt(64.0 * slack.position / jerk) +
         16.0 * std::sqrt(64.0 * slack.velocity / jerk) + 1.0e-9 * direct.duration();
}

/// Calls `turn` with the time of a detour once or twice. @return the sum of the times.
template <typename Turn>
double take_turns(const JerkProfile& direct, Random& random, Turn turn) {
  double spent = 0.0;
  const std::uint64_t turns = 1 + random.below(2);
  for (std::uint64_t i = 0; i < turns; ++i) {
    const double time = 0.7 * direct.duration() * random.unit() * random.unit();
    turn(time);
    spent += time;
  }
  return spent;
}

// Whatever an axis does first, within its limits: the fastest motion from there is not earlier at
// the target. This holds for different ramps, too, and for starts outside of the limits.
TEST(JerkProfileProperty, IsNotSlowerThanADetour) {
#ifdef __OPTIMIZE__
  const auto cases =
      number_of<std::uint64_t>({.usual = 100'000, .full = 2'000'000, .nightly = 100'000'000});
#else
  constexpr std::uint64_t cases = 3'000;
#endif
  Random random(0x6465746FU);
  for (std::uint64_t i = 0; i < cases; ++i) {
    JerkCase c = random_jerk_case(random);
    c.jerk.deceleration = c.jerk.acceleration;
    const JerkProfile direct = plan_of(c);
    JerkCase rest = c;
    const double spent = take_turns(direct, random, [&](double time) {
      rest.start = after_a_detour(c, rest.start, time, random);
    });
    ASSERT_GE(spent + plan_of(rest).duration(), direct.duration() - rounding_of_time(c, direct))
        << c << rest;
  }
}

// With different jerks this holds for motions that never go backward. Others may be earlier: from
// rest, 1 unit/s² takes 1 s to build up with 1 unit/s³. Where speeds are taken back with 100
// units/s³, 0.2 s of moving backward (0.1 s down to -0.1 units/s² and as long back to 0: -0.01
// units/s) and √(2·0.01/100) s end at rest with √(2·100·0.01) = 1.41 units/s².
TEST(JerkProfileProperty, IsNotSlowerThanAHesitationWithTwoJerks) {
#ifdef __OPTIMIZE__
  const auto cases =
      number_of<std::uint64_t>({.usual = 100'000, .full = 2'000'000, .nightly = 100'000'000});
#else
  constexpr std::uint64_t cases = 3'000;
#endif
  Random random(0x68657369U);
  std::uint64_t compared = 0;
  for (std::uint64_t i = 0; i < cases; ++i) {
    JerkCase c = random_jerk_case(random);
    const auto direction_of = [](const JerkCase& now) {
      const JerkProfile stop = plan_jerk_velocity(now.start, 0.0, now.limits, now.jerk);
      return now.target > stop.end_position() ? 1.0 : -1.0;
    };
    if (const double wanted = direction_of(c);
        wanted * c.start.acceleration < 0.0 || wanted * c.start.velocity < 0.0) {
      c.start = {.position = c.start.position};
    }
    const double direction = direction_of(c);
    if (settled_speed(c.start, c.jerk, direction) > c.limits.velocity) continue;
    const JerkProfile direct = plan_of(c);
    JerkCase rest = c;
    const double spent = take_turns(direct, random, [&](double time) {
      rest.start = after_a_hesitation(c, rest.start, direction, time, random);
    });
    if (direction_of(rest) != direction) continue;  // too far: it comes back to the target
    ++compared;
    ASSERT_GE(spent + plan_of(rest).duration(), direct.duration() - rounding_of_time(c, direct))
        << c << rest;
  }
  EXPECT_GE(compared, cases / 2);
}

}  // namespace
}  // namespace vdrive
