// SPDX-License-Identifier: Apache-2.0
// The common times of a straight line in axis space.
#include "groups/line_times.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::client {
namespace {

using std::chrono::microseconds;

constexpr microseconds kPeriod{1000};

AxisDistance way(double distance, const MotionLimits& limits) {
  return {.distance = distance, .limits = limits};
}

/// The ways of a failing case as an initialiser to paste into a test.
std::string ways_text(const std::vector<AxisDistance>& ways) {
  std::ostringstream text;
  text << std::setprecision(17) << "const std::vector<AxisWay> ways{";
  for (const AxisDistance& each : ways) {
    text << "{.distance = " << each.distance << ", .limits = {" << each.limits.velocity << ", "
         << each.limits.acceleration << ", " << each.limits.deceleration << "}, .jerk = {"
         << each.jerk.acceleration << ", " << each.jerk.deceleration << "}}, ";
  }
  text << "};";
  return text.str();
}

TEST(LineTimes, OfOneAxisAreItsOwnTrapezoid) {
  // 1000 UU/s reached in 0.1 s (50 UU) and left in 0.2 s (100 UU), 849.5 UU in between in 0.8495 s,
  // rounded up to a tick.
  const std::vector ways{
      way(999.5, {.velocity = 1000, .acceleration = 10'000, .deceleration = 5000})};
  const auto times = plan_line(ways, kPeriod);
  ASSERT_TRUE(times);
  EXPECT_EQ(times->acceleration, microseconds{100'000});
  EXPECT_EQ(times->deceleration, microseconds{200'000});
  EXPECT_EQ(times->duration, microseconds{1'150'000});
}

TEST(LineTimes, OfAShortDistanceAreATriangle) {
  // 99 UU with ramps of 10000 UU/s²: 49.5 UU = a·t²/2, t = sqrt(99/1e4) s = 99498.7 us each.
  const std::vector ways{
      way(99, {.velocity = 5000, .acceleration = 10'000, .deceleration = 10'000})};
  const auto times = plan_line(ways, kPeriod);
  ASSERT_TRUE(times);
  EXPECT_EQ(times->acceleration, microseconds{99'499});
  EXPECT_EQ(times->deceleration, microseconds{99'499});
  EXPECT_EQ(times->duration, microseconds{199'000});
}

TEST(LineTimes, TakeTheSpeedOfOneAxisAndTheRampOfAnother) {
  // Along the path: 1000/1000 = 1 /s from the first axis, 2000/500 = 4 /s² from the second.
  const std::vector ways{way(1000, {.velocity = 1000, .acceleration = 1e9, .deceleration = 1e9}),
                         way(500, {.velocity = 1e9, .acceleration = 2000, .deceleration = 2000})};
  const auto times = plan_line(ways, kPeriod);
  ASSERT_TRUE(times);
  EXPECT_EQ(times->acceleration, microseconds{250'000});
  EXPECT_EQ(times->duration, microseconds{1'250'000});
}

TEST(LineTimes, RoundUpToWholeTicks) {
  const std::vector ways{
      way(1000, {.velocity = 999, .acceleration = 10'000, .deceleration = 10'000})};
  const auto times = plan_line(ways, microseconds{2000});
  ASSERT_TRUE(times);
  EXPECT_EQ(times->duration % microseconds{2000}, microseconds{0});
}

TEST(LineTimes, GrowByTheJerkTimeOfTheRamps) {
  // With 200000 UU/s³ the acceleration takes 50 ms to reach 10000 UU/s², and each ramp lasts that
  // much longer. The way is 1000 UU at 1000 UU/s. The second axis does not limit the path.
  const MotionLimits limits{.velocity = 1000, .acceleration = 10'000, .deceleration = 10'000};
  const std::vector ways{
      AxisDistance{.distance = 1000, .limits = limits, .jerk = {200'000, 200'000}},
      way(100, {.velocity = 1e6, .acceleration = 1e9, .deceleration = 1e9})};
  const auto times = plan_line(ways, kPeriod);
  ASSERT_TRUE(times);
  EXPECT_EQ(times->jerk, microseconds{50'000});
  EXPECT_EQ(times->acceleration, microseconds{150'000});
  EXPECT_EQ(times->deceleration, microseconds{150'000});
  EXPECT_NEAR(static_cast<double>(times->duration.count()), 1'150'000, 1'000);
  for (const AxisDistance& each : ways) EXPECT_TRUE(keeps_limits(each, *times));
}

TEST(LineTimes, OfAShortDistanceFollowFromTheJerkAlone) {
  // Four phases of T with 2·J·T³ = 2 UU: T = 0.1 s at 1000 UU/s³.
  const MotionLimits limits{.velocity = 100, .acceleration = 200, .deceleration = 200};
  const std::vector ways{AxisDistance{.distance = 2, .limits = limits, .jerk = {1'000, 1'000}}};
  const auto times = plan_line(ways, kPeriod);
  ASSERT_TRUE(times);
  EXPECT_NEAR(static_cast<double>(times->jerk.count()), 100'000, 1);
  EXPECT_NEAR(static_cast<double>(times->duration.count()), 400'000, 1'000);
  EXPECT_TRUE(keeps_limits(ways.front(), *times));
}

TEST(LineTimes, KeepTheJerkOfEveryAxis) {
  std::mt19937_64 random(13);
  const auto magnitude = [&](double low, double high) {
    return std::pow(10.0, std::uniform_real_distribution<double>(low, high)(random));
  };
  for (int run = 0; run < 5'000; ++run) {
    std::vector<AxisDistance> ways;
    for (int axis = 0; axis < 4; ++axis) {
      ways.push_back({.distance = std::floor(magnitude(0, 6)) + 0.5,
                      .limits = {.velocity = std::floor(magnitude(3, 6)),
                                 .acceleration = std::floor(magnitude(3, 7)),
                                 .deceleration = std::floor(magnitude(3, 7))},
                      .jerk = {std::floor(magnitude(4, 9)), std::floor(magnitude(4, 9))}});
    }
    const auto times = plan_line(ways, kPeriod);
    ASSERT_TRUE(times) << ways_text(ways);
    for (const AxisDistance& each : ways)
      ASSERT_TRUE(keeps_limits(each, *times)) << ways_text(ways);
    ASSERT_GE(times->acceleration, 2 * times->jerk) << ways_text(ways);
    ASSERT_GE(times->deceleration, 2 * times->jerk) << ways_text(ways);
    ASSERT_GE(times->duration, times->acceleration + times->deceleration) << ways_text(ways);
  }
}

/// @return the limits that a drive derives from the times and its way.
MotionLimits limits_with(const LineTimes& times, double distance) {
  const auto seconds = [](microseconds time) {
    return static_cast<double>(time.count()) * 1.0e-6;
  };
  return limits_of(distance, {.duration = seconds(times.duration),
                              .acceleration = seconds(times.acceleration),
                              .deceleration = seconds(times.deceleration),
                              .jerk = seconds(times.jerk)});
}

TEST(LineTimes, OfALineInMotionLeadToTheFullSpeedHoweverShortItIs) {
  // The ramps to 1000 UU/s and back take 50 + 100 UU: 150/7 = 21.4 ways of 7 UU.
  const std::vector ways{way(7, {.velocity = 1000, .acceleration = 10'000, .deceleration = 5000})};
  const auto moving = plan_moving_line(ways);
  ASSERT_TRUE(moving);
  EXPECT_EQ(moving->stretch, 22U);
  EXPECT_EQ(moving->times.acceleration, microseconds{100'000});
  EXPECT_EQ(moving->times.deceleration, microseconds{200'000});
  // 154 UU at 1000 UU/s, plus half of both ramps.
  EXPECT_NEAR(static_cast<double>(moving->times.duration.count()), 304'000, 2);
  const MotionLimits limits = limits_with(moving->times, 7.0 * moving->stretch);
  EXPECT_NEAR(limits.velocity, 1000, 0.1);
  EXPECT_NEAR(limits.acceleration, 10'000, 1);
  EXPECT_NEAR(limits.deceleration, 5000, 1);
}

TEST(LineTimes, OfALineInMotionKeepTheLimitsOfEveryAxis) {
  std::mt19937_64 random(17);
  const auto magnitude = [&](double low, double high) {
    return std::pow(10.0, std::uniform_real_distribution<double>(low, high)(random));
  };
  for (int run = 0; run < 5'000; ++run) {
    std::vector<AxisDistance> ways;
    for (int axis = 0; axis < 4; ++axis) {
      ways.push_back({.distance = std::floor(magnitude(0, 6)),
                      .limits = {.velocity = std::floor(magnitude(3, 6)),
                                 .acceleration = std::floor(magnitude(3, 7)),
                                 .deceleration = std::floor(magnitude(3, 7))},
                      .jerk = {std::floor(magnitude(4, 9)), std::floor(magnitude(4, 9))}});
    }
    const auto moving = plan_moving_line(ways);
    ASSERT_TRUE(moving) << ways_text(ways);
    for (AxisDistance stretched : ways) {
      stretched.distance *= moving->stretch;
      ASSERT_LE(stretched.distance, 4294967295.0) << ways_text(ways);
      ASSERT_TRUE(keeps_limits(stretched, moving->times)) << ways_text(ways);
    }
  }
}

TEST(LineTimes, OfALineInMotionAreMissingBeyondTheRangeOfTheObject) {
  const MotionLimits limits{.velocity = 1000, .acceleration = 1e9, .deceleration = 1e9};
  EXPECT_TRUE(plan_moving_line(std::vector{way(4'294'900, limits)}));
  EXPECT_FALSE(plan_moving_line(std::vector{way(4'294'968, limits)}));
}

TEST(LineTimes, OfALineInMotionGiveATimeThatCoversAStopAndTheWayBack) {
  // Ramps of 0.1 s and 0.2 s, speed 1 /s. At this speed with the complete way left, the time is 1 s
  // and half of the ramp of 0.2 s. At this speed with no way left, the stop takes 0.2 s and 0.1 of
  // the way; the way back has both ramps with a peak of sqrt(2·0.1·10·5/15) = 0.82 /s and takes
  // 0.24 s.
  const LineTimes times{.duration = microseconds{1'150'000},
                        .acceleration = microseconds{100'000},
                        .deceleration = microseconds{200'000}};
  EXPECT_GE(longest_duration(times, 1.0, 1.0), microseconds{1'100'000});
  EXPECT_GE(longest_duration(times, 0.0, 1.0), microseconds{440'000});
  EXPECT_LE(longest_duration(times, 1.0, 1.0), microseconds{5'000'000});
}

TEST(LineTimes, OfNoDistanceAreZero) {
  const std::vector ways{way(0, {.velocity = 0, .acceleration = 1, .deceleration = 1})};
  const auto times = plan_line(ways, kPeriod);
  ASSERT_TRUE(times);
  EXPECT_EQ(times->duration, microseconds{0});
}

TEST(LineTimes, AreMissingForAnAxisThatMayNotMove) {
  const std::vector ways{way(1, {.velocity = 0, .acceleration = 1, .deceleration = 1})};
  EXPECT_FALSE(plan_line(ways, kPeriod));
}

TEST(LineTimes, AreMissingBeyondTheRangeOfTheObject) {
  // 2^32 - 1 us are 4294.967295 s.
  const MotionLimits limits{.velocity = 1000, .acceleration = 1e9, .deceleration = 1e9};
  EXPECT_TRUE(plan_line(std::vector{way(4'294'900, limits)}, kPeriod));
  EXPECT_FALSE(plan_line(std::vector{way(4'294'968, limits)}, kPeriod));
  EXPECT_FALSE(plan_line(std::vector{way(1e9, limits)}, kPeriod));
}

/// The duration without rounding, derived in another way: along the shared path, with the smallest
/// limits of all axes.
double ideal_seconds(const std::vector<AxisDistance>& ways) {
  double velocity = 1e300;
  double acceleration = 1e300;
  double deceleration = 1e300;
  for (const AxisDistance& each : ways) {
    if (each.distance == 0) continue;
    velocity = std::min(velocity, each.limits.velocity / each.distance);
    acceleration = std::min(acceleration, each.limits.acceleration / each.distance);
    deceleration = std::min(deceleration, each.limits.deceleration / each.distance);
  }
  // The share of the path that the ramps take at full speed.
  const double ramps = velocity * velocity * (0.5 / acceleration + 0.5 / deceleration);
  if (ramps >= 1.0) return std::sqrt(2.0 * (1.0 / acceleration + 1.0 / deceleration));
  return velocity / acceleration + velocity / deceleration + (1.0 - ramps) / velocity;
}

TEST(LineTimes, NeverExceedALimitAndLastOneTickLongerThanTheIdealAtMost) {
  std::mt19937_64 random(7);
  const auto magnitude = [&](double low, double high) {
    return std::pow(10.0, std::uniform_real_distribution<double>(low, high)(random));
  };
  int planned = 0;
  for (int run = 0; run < 20'000; ++run) {
    const auto count = std::uniform_int_distribution<std::size_t>(1, 64)(random);
    const microseconds period{std::uniform_int_distribution<int>(125, 10'000)(random)};
    std::vector<AxisDistance> ways;
    for (std::size_t axis = 0; axis < count; ++axis) {
      ways.push_back(
          way(std::floor(magnitude(-0.5, run % 2 == 0 ? 9 : 6)) + (axis % 2 == 0 ? 0.5 : 0.0),
              {.velocity = std::floor(magnitude(4, 9)),
               .acceleration = std::floor(magnitude(3, 9.6)),
               .deceleration = std::floor(magnitude(3, 9.6))}));
    }
    const auto times = plan_line(ways, period);
    const double ideal = ideal_seconds(ways);
    if (!times) {
      ASSERT_GT(ideal, 4294.9) << "run " << run;
      continue;
    }
    ++planned;
    for (const AxisDistance& each : ways) {
      ASSERT_TRUE(each.distance == 0 || keeps_limits(each, *times)) << "run " << run;
    }
    ASSERT_GE(times->duration, times->acceleration + times->deceleration);
    ASSERT_EQ(times->duration % period, microseconds{0});
    const double seconds = static_cast<double>(times->duration.count()) * 1e-6;
    const double tick = static_cast<double>(period.count()) * 1e-6;
    // One tick for rounding up, another in case a limit needs it in its last bit.
    ASSERT_LE(seconds, ideal + 2.0 * tick + 3e-6) << "run " << run;
    ASSERT_GE(seconds, ideal * (1.0 - 1e-9)) << "run " << run;
  }
  EXPECT_GT(planned, 10'000);
}

}  // namespace
}  // namespace vdrive::client
