// SPDX-License-Identifier: Apache-2.0
#include "joint_path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace vdrive::ros2 {
namespace {

using testing::HasSubstr;

JointPath path(const JointMotion& start, const std::vector<PathPoint>& points) {
  return {start, points};
}

TEST(JointPath, IsAStraightLineBetweenPointsThatHavePositionsOnly) {
  const JointPath line =
      path({1.0}, {{.time = 2.0, .position = 5.0}, {.time = 3.0, .position = 5.0}});
  EXPECT_DOUBLE_EQ(line.at(0.5).position, 2.0);  // 1 + 4 * 0.5 / 2
  EXPECT_DOUBLE_EQ(line.at(0.5).velocity, 2.0);
  EXPECT_DOUBLE_EQ(line.at(2.5).position, 5.0);
  EXPECT_DOUBLE_EQ(line.duration(), 3.0);
}

TEST(JointPath, IsCubicBetweenPointsThatHaveVelocities) {
  // From rest to rest in 2 s: 3 s² - 2 s³ of the distance, with s = t/2. At half time, half the
  // distance and 1.5 times the mean velocity.
  const JointPath cubic = path({0.0}, {{.time = 2.0, .position = 4.0, .velocity = 0.0}});
  EXPECT_DOUBLE_EQ(cubic.at(1.0).position, 2.0);
  EXPECT_DOUBLE_EQ(cubic.at(1.0).velocity, 3.0);
  EXPECT_DOUBLE_EQ(cubic.at(0.5).position, 0.625);  // 4 (3/16 - 2/64)
}

TEST(JointPath, IsQuinticBetweenPointsThatHaveAccelerations) {
  // 10 s³ - 15 s⁴ + 6 s⁵ of the distance: at s = 1/2 half of it, at 15/8 of the mean velocity.
  const JointPath quintic =
      path({0.0}, {{.time = 2.0, .position = 4.0, .velocity = 0.0, .acceleration = 0.0}});
  EXPECT_DOUBLE_EQ(quintic.at(1.0).position, 2.0);
  EXPECT_DOUBLE_EQ(quintic.at(1.0).velocity, 3.75);
  EXPECT_NEAR(quintic.at(0.0).acceleration, 0.0, 1e-12);
  EXPECT_NEAR(quintic.at(1.999999).acceleration, 0.0, 1e-4);
}

TEST(JointPath, MeetsPositionVelocityAndAccelerationOfEachPoint) {
  const std::vector<PathPoint> points{
      {.time = 1.0, .position = 0.5, .velocity = 0.4, .acceleration = -0.3},
      {.time = 1.7, .position = -0.2, .velocity = -1.0, .acceleration = 0.2},
      {.time = 3.0, .position = 0.1, .velocity = 0.0, .acceleration = 0.0}};
  const JointPath smooth = path({0.1, 0.2, 0.3}, points);
  for (const double beside : {-1e-9, 1e-9}) {
    for (std::size_t i = 0; i < 2; ++i) {
      const JointMotion there = smooth.at(points[i].time + beside);
      EXPECT_NEAR(there.position, points[i].position, 1e-7);
      EXPECT_NEAR(there.velocity, *points[i].velocity, 1e-7);
      EXPECT_NEAR(there.acceleration, *points[i].acceleration, 1e-6);
    }
  }
  EXPECT_DOUBLE_EQ(smooth.at(-1.0).position, 0.1);
}

TEST(JointPath, StaysAtItsLastPointAfterItsEnd) {
  const JointPath line = path({0.0}, {{.time = 1.0, .position = 2.0}});
  EXPECT_DOUBLE_EQ(line.at(7.0).position, 2.0);
  EXPECT_DOUBLE_EQ(line.at(7.0).velocity, 0.0);
}

TEST(JointPath, ContinuesAPresentMotionWithoutAStep) {
  const JointPath line =
      path({0.0, 3.0}, {{.time = 1.0, .position = 1.0}, {.time = 2.0, .position = 3.0}});
  EXPECT_DOUBLE_EQ(line.at(0.0).velocity, 3.0);
  EXPECT_NEAR(line.at(1.0 - 1e-9).velocity, 2.0, 1e-6) << "the speed of the next line";
}

TEST(JointPath, NamesTheVelocityLimitThatItsExtremeBreaks) {
  // The peak of 3 rad/s is between the points, at which the joint is at rest.
  const JointPath cubic = path({0.0}, {{.time = 2.0, .position = 4.0, .velocity = 0.0}});
  JointLimits limits;
  limits.velocity = 3.0;
  EXPECT_EQ(cubic.check(limits, "rad"), std::nullopt);
  limits.velocity = 2.99;
  const auto broken = cubic.check(limits, "rad");
  ASSERT_TRUE(broken);
  EXPECT_THAT(*broken, HasSubstr("velocity 3 rad/s at 1 s is beyond the limit 2.99 rad/s"));
}

TEST(JointPath, NamesThePositionLimitThatItOvershootsBetweenPoints) {
  // From 0 to 0 in 1 s with v0 = 4: p = 4t - 8t² + 4t³, with its maximum at t = 1/3: 16/27.
  const JointPath cubic = path({0.0, 4.0}, {{.time = 1.0, .position = 0.0, .velocity = 0.0}});
  JointLimits limits;
  limits.upper = 16.0 / 27.0;
  EXPECT_EQ(cubic.check(limits, "m"), std::nullopt);
  limits.upper = 0.59;
  const auto broken = cubic.check(limits, "m");
  ASSERT_TRUE(broken);
  EXPECT_THAT(*broken, HasSubstr("position 0.592593 m at 0.333333 s is beyond the limit 0.59 m"));
}

TEST(JointPath, ComparesAccelerationsWithTheLowerLimit) {
  // From rest to rest, 4 rad in 2 s: 6 * 4 / 2² = 6 rad/s² at both ends.
  const JointPath cubic = path({0.0}, {{.time = 2.0, .position = 4.0, .velocity = 0.0}});
  JointLimits limits;
  limits.acceleration = 10.0;
  limits.deceleration = 5.0;
  EXPECT_TRUE(cubic.check(limits, "rad"));
  limits.deceleration = 6.0;
  EXPECT_FALSE(cubic.check(limits, "rad"));
}

TEST(JointPath, CanReturnFromBeyondALimit) {
  JointLimits limits;
  limits.upper = 1.0;
  EXPECT_FALSE(path({2.0}, {{.time = 1.0, .position = 0.0}}).check(limits, "rad"));
  EXPECT_TRUE(path({2.0}, {{.time = 1.0, .position = 2.1}}).check(limits, "rad"));
}

// Each number is finite but the differences are not. The coefficients would be NaN, which exceeds
// no limit.
TEST(JointPath, IsRefusedWhenItCannotBeCalculated) {
  const JointLimits none;
  const JointPath quintic =
      path({0.0}, {{.time = 1.0, .position = 0.0, .velocity = 0.0, .acceleration = 1e308},
                   {.time = 2.0, .position = 0.0, .velocity = 0.0, .acceleration = -1e308}});
  EXPECT_THAT(quintic.check(none, "rad").value_or(""), HasSubstr("numerically unbounded"));
  const JointPath brief = path({0.0}, {{.time = 1e-300, .position = 1.0, .velocity = 0.0}});
  EXPECT_TRUE(brief.check(none, "rad"));
}

// ---- polynomials

TEST(Polynomial, OfThirdDegreeHasPositionAndVelocityAtBothEnds) {
  const Polynomial way = cubic({1.0, 2.0, 0.0}, {4.0, -1.0, 0.0}, 2.0);
  EXPECT_DOUBLE_EQ(value(way, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(value(way, 2.0), 4.0);
  EXPECT_DOUBLE_EQ(value(derivative(way), 0.0), 2.0);
  EXPECT_DOUBLE_EQ(value(derivative(way), 2.0), -1.0);
}

TEST(Polynomial, OfFifthDegreeHasTheAccelerationsToo) {
  const Polynomial way = quintic({1.0, 2.0, 3.0}, {4.0, -1.0, 0.5}, 2.0);
  const Polynomial acceleration = derivative(derivative(way));
  EXPECT_DOUBLE_EQ(value(way, 2.0), 4.0);
  EXPECT_DOUBLE_EQ(value(derivative(way), 2.0), -1.0);
  EXPECT_DOUBLE_EQ(value(acceleration, 0.0), 3.0);
  EXPECT_NEAR(value(acceleration, 2.0), 0.5, 1e-12);
}

TEST(Polynomial, HasItsExtremesInsideOrAtTheEnds) {
  // t³ - 3t² + 2t: its derivative 3t² - 6t + 2 is 0 at 1 - 1/sqrt(3) and 1 + 1/sqrt(3), where the
  // value is 2/(3 sqrt(3)) = 0.3849 and its negative.
  const Polynomial wave{0.0, 2.0, -3.0, 1.0};
  const Extremes inside = extremes(wave, 2.0);
  EXPECT_NEAR(inside.high, 0.384900179459750, 1e-12);
  EXPECT_NEAR(inside.high_time, 0.422649730810374, 1e-7);
  EXPECT_NEAR(inside.low, -0.384900179459750, 1e-12);
  EXPECT_NEAR(inside.low_time, 1.577350269189626, 1e-7);
  const Extremes longer = extremes(wave, 3.0);
  EXPECT_DOUBLE_EQ(longer.high, 6.0) << "27 - 27 + 6 at the end";
  EXPECT_DOUBLE_EQ(longer.high_time, 3.0);
}

TEST(Polynomial, OfABoundlessMessageIsNotCalculable) {
  EXPECT_TRUE(is_calculable({1e9, -1e9}, 1e6));
  EXPECT_FALSE(is_calculable({0.0, 1e150}, 1e60)) << "1e210 at its end";
  EXPECT_FALSE(is_calculable({0.0, std::numeric_limits<double>::infinity()}, 1.0));
  EXPECT_FALSE(is_calculable({std::numeric_limits<double>::quiet_NaN()}, 1.0));
}

}  // namespace
}  // namespace vdrive::ros2
