// SPDX-License-Identifier: Apache-2.0
// Plans with limited jerk: textbook cases with numbers worked out by hand. jerk_property_test.cpp
// and jerk_programme_test.cpp check random plans.
#include "vdrive/motion/jerk_profile.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdrive {
namespace {

constexpr MotionLimits kLimits{.velocity = 100.0, .acceleration = 200.0, .deceleration = 200.0};
constexpr MotionJerk kJerk{.acceleration = 1000.0, .deceleration = 1000.0};

TEST(JerkProfile, RunsTheSevenSegmentsOfTheTextbook) {
  // 200 units/s² are built up in 0.2 s, to 20 units/s and 1000·0.2³/6 = 4/3 units. 0.3 s later the
  // axis has 80 units/s and 4/3 + 20·0.3 + 200·0.3²/2 = 49/3 units, at 0.7 s 100 units/s and
  // 100·0.7/2 = 35 units. Braking takes the same; 30 units remain for 0.3 s at 100 units/s.
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
  // Four phases of T with 2·J·T³ = distance: T = 0.1 s for 2 units. The peak is J·T² = 10 units/s.
  const JerkProfile profile = plan_jerk_move({}, 2.0, kLimits, kJerk);

  ASSERT_EQ(profile.segment_count(), 3U) << "the two falls in the middle are one";
  EXPECT_NEAR(profile.duration(), 0.4, 1.0e-12);
  EXPECT_NEAR(profile.at(0.1).acceleration, 100.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.2).velocity, 10.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.2).position, 1.0, 1.0e-11);
}

TEST(JerkProfile, HoldsTheAccelerationWhereTheVelocityIsNotReached) {
  // 50 units/s² after 0.05 s, held for 0.1 s: the peak is 50·0.15 = 7.5 units/s after 0.2 s and
  // 7.5·0.2/2 units; braking takes the same again.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 50.0, .deceleration = 50.0};
  const JerkProfile profile = plan_jerk_move({}, 1.5, limits, kJerk);

  ASSERT_EQ(profile.segment_count(), 5U);
  EXPECT_NEAR(profile.duration(), 0.4, 1.0e-12);
  EXPECT_NEAR(profile.at(0.1).acceleration, 50.0, 1.0e-12);
  EXPECT_NEAR(profile.at(0.2).velocity, 7.5, 1.0e-11);
}

TEST(JerkProfile, BrakesByItsDeceleration) {
  // Up as above: 0.7 s, 35 units. Down with 100 units/s²: 100/100 + 100/1000 = 1.1 s, 55 units. 110
  // units remain.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 200.0, .deceleration = 100.0};
  const JerkProfile profile = plan_jerk_move({}, 200.0, limits, kJerk);

  EXPECT_NEAR(profile.duration(), 0.7 + 1.1 + 1.1, 1.0e-12);
  EXPECT_NEAR(profile.at(2.35).acceleration, -100.0, 1.0e-9);
}

TEST(JerkProfile, HasAJerkForEachRamp) {
  // Down with 500 units/s³: 100/200 + 200/500 = 0.9 s, 45 units. 20 units remain.
  const MotionJerk jerk{.acceleration = 1000.0, .deceleration = 500.0};
  const JerkProfile profile = plan_jerk_move({}, 100.0, kLimits, jerk);

  EXPECT_NEAR(profile.duration(), 0.7 + 0.2 + 0.9, 1.0e-12);
  EXPECT_EQ(profile.segment(0).jerk, 1000.0);
  EXPECT_EQ(profile.segment(6).jerk, 500.0);
}

TEST(JerkProfile, MeetsAVelocityThatItsAccelerationForcesItOver) {
  // The acceleration ends after 0.2 s, at 95 + 200²/2000 = 115 units/s. From there down by 15
  // units/s: two phases of T with J·T² = 15.
  const JerkProfile profile = plan_jerk_velocity({0.0, 95.0, 200.0}, 100.0, kLimits, kJerk);

  EXPECT_NEAR(profile.at(0.2).velocity, 115.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.2).acceleration, 0.0, 1.0e-9);
  const double down = std::sqrt(15.0 / 1000.0);
  EXPECT_NEAR(profile.at(0.2 + down).velocity, 107.5, 1.0e-11);
  EXPECT_EQ(profile.at(0.2 + 2.0 * down + 1.0e-9).velocity, 100.0);
  EXPECT_TRUE(std::isinf(profile.duration()));
}

TEST(JerkProfile, StopsAnAxisThatSpeedsUpAfterTheRestOfItsAcceleration) {
  // Up to 15 units/s in 0.1 s: 10·0.1 + 100·0.1²/2 - 1000·0.1³/6 = 4/3 units. Then two phases of T
  // with J·T² = 15, over 15·T.
  const JerkProfile profile = plan_jerk_stop({0.0, 10.0, 100.0}, 200.0, kJerk);

  const double brake = std::sqrt(15.0 / 1000.0);
  EXPECT_NEAR(profile.at(0.1).velocity, 15.0, 1.0e-12);
  EXPECT_NEAR(profile.duration(), 0.1 + 2.0 * brake, 1.0e-12);
  EXPECT_NEAR(profile.end_position(), 4.0 / 3.0 + 15.0 * brake, 1.0e-12);
  EXPECT_EQ(profile.at(profile.duration()).position, profile.end_position());
}

TEST(JerkProfile, ComesBackFromAnOvershootThatItCannotAvoid) {
  // The acceleration ends after 0.2 s, at 5 - 20 = -15 units/s, at 5·0.2 - 200·0.2²/2 + 1000·0.2³/6
  // = -5/3 units. The stop from there takes two phases of T with J·T² = 15, over 15·T units.
  const MotionSample start{0.0, 5.0, -200.0};
  const double back = std::sqrt(15.0 / 1000.0);
  const double rest = -5.0 / 3.0 - 15.0 * back;

  const JerkProfile stop = plan_jerk_stop(start, 200.0, kJerk);
  EXPECT_NEAR(stop.duration(), 0.2 + 2.0 * back, 1.0e-12);
  EXPECT_NEAR(stop.end_position(), rest, 1.0e-12);

  // A target on the near side of `rest` is reached on the way back, without coming to rest first.
  const JerkProfile move = plan_jerk_move(start, rest + 2.0, kLimits, kJerk);
  EXPECT_EQ(move.end_position(), rest + 2.0);
  EXPECT_GT(move.at(move.duration() - 0.05).velocity, 0.0);
  EXPECT_LT(move.duration(), stop.duration() + 0.4) << "0.4 s from rest to rest";
}

TEST(JerkProfile, BrakesTwiceForATargetALittlePastTheEndOfItsStop) {
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
    // Within 0.01 units/s of 0 the acceleration is at most (2·1000·0.01)/(2·50) = 0.2 higher.
    EXPECT_NEAR(turning, 50.0, 0.25);
    EXPECT_NEAR(slowing, deceleration, 1.0e-9);
    EXPECT_NEAR(speeding, acceleration, 1.0e-9);
    // Each ramp covers 100 units/s.
    // The ramp with 50 units/s²: between 0 and 50 units/s² it takes 0.05 s for 1.25 units/s, and at
    // 50 units/s² it takes 98.75/50 = 1.975 s.
    // The ramp with 200 units/s²: between 0 and 200 units/s² it takes 0.2 s for 20 units/s, at
    // 200 units/s² 61.25/200 = 0.30625 s, and between 200 and 50 units/s² 0.15 s for 18.75 units/s.
    const JerkSegment& last = profile.segment(profile.segment_count() - 2);
    EXPECT_NEAR(last.end_time, 0.05 + 1.975 + 0.2 + 0.30625 + 0.15, 1.0e-12);
  }
}

TEST(JerkProfile, TurnsWithTheJerkOfEachRamp) {
  // While slowing down, 100 units/s² are built up in 0.2 s, 10 units/s, and held for 40/100 s;
  // while speeding up they are held for 45/100 s and taken back in 0.1 s, 5 units/s.
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
  // 150 units/s² where 50 are allowed: decreasing for 0.1 s, then held.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 50.0, .deceleration = 50.0};
  const JerkProfile profile = plan_jerk_velocity({0.0, 10.0, 150.0}, 100.0, limits, kJerk);

  EXPECT_NEAR(profile.at(0.05).acceleration, 100.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.1).acceleration, 50.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.11).acceleration, 50.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.1).velocity, 20.0, 1.0e-11);  // (150 + 50)/2·0.1
}

TEST(JerkProfile, ComesBackWithinALowerVelocityAtOnce) {
  // From 100 to 50 units/s: 50/200 + 200/1000 = 0.45 s, even if the target is far ahead.
  const MotionLimits limits{.velocity = 50.0, .acceleration = 200.0, .deceleration = 200.0};
  const JerkProfile profile = plan_jerk_move({0.0, 100.0, 0.0}, 1.0e4, limits, kJerk);

  EXPECT_NEAR(profile.at(0.2).acceleration, -200.0, 1.0e-9);
  EXPECT_NEAR(profile.at(0.25).velocity, 70.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.45).velocity, 50.0, 1.0e-11);
  EXPECT_EQ(profile.at(0.46).velocity, 50.0);
  EXPECT_EQ(profile.at(100.0).velocity, 50.0);
}

TEST(JerkProfile, GoesBeyondItsTargetWhereTheJerkIsLoweredAtTheBeginOfItsBraking) {
  // With 1000 units/s³ stopping from 100 units/s takes the 35 units to the target. With 500 the
  // deceleration takes 0.4 s to build up, to 60 units/s and 100·0.4 - 500·0.4³/6 = 104/3 units, and
  // another 0.3 s and 9 units to 0 at -200 units/s²: no motion turns before 131/3 units. A stop
  // takes 45.
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
  // From there to 20 units/s takes 2·√(40/500) s and no distance, the stop 2·√(20/500) s
  // and 4 units.
  const MotionJerk lowered{.acceleration = 500.0, .deceleration = 500.0};
  const JerkProfile profile = plan_jerk_move({0.0, 20.0, -200.0}, 4.0 / 3.0, kLimits, lowered);

  EXPECT_NEAR(profile.at(0.4).velocity, -20.0, 1.0e-11);
  EXPECT_NEAR(profile.at(0.4).position, -8.0 / 3.0, 1.0e-11);
  EXPECT_EQ(profile.end_position(), 4.0 / 3.0);
  // A target that rounding moves by 1e-15 units costs at most (1e-15/500)^(1/3) = 1e-6 s.
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

}  // namespace
}  // namespace vdrive
