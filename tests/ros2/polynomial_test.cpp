// SPDX-License-Identifier: Apache-2.0
#include "polynomial.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace vdrive::ros2 {
namespace {

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
  // t³ - 3t² + 2t: its slope 3t² - 6t + 2 is 0 at 1 - 1/sqrt(3) and 1 + 1/sqrt(3), where it is
  // 2/(3 sqrt(3)) = 0.3849 and the negative of that.
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
