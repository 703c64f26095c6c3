// SPDX-License-Identifier: Apache-2.0
// The profile generator: named cases with derived numbers, then properties over the full domain of
// the 32-bit registers. VDRIVE_NIGHTLY=1 runs 1e7 random cases instead of 1e5.
#include "vdrive/motion/profile.hpp"

#include "core/support/axis_under_test.hpp"
#include "drive/block.hpp"
#include "drive/frame.hpp"
#include "drive/objects.hpp"
#include "drive/power.hpp"
#include "drive/tick.hpp"
#include "plant/servo_block.hpp"
#include "support/random_cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <limits>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive {
namespace {

using test::case_count;
using test::Random;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Case {
  MotionState start;
  double target = 0.0;
  MotionLimits limits;
};

/// A failing case as an initialiser that can be pasted into a test.
std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << std::setprecision(17) << "Case{.start = {" << c.start.position << ", "
             << c.start.velocity << "}, .target = " << c.target << ", .limits = {"
             << c.limits.velocity << ", " << c.limits.acceleration << ", " << c.limits.deceleration
             << "}}";
}

Profile plan(const Case& c) {
  return plan_move(c.start, c.target, c.limits);
}

Case mirrored(const Case& c) {
  return {{-c.start.position, -c.start.velocity}, -c.target, c.limits};
}

// ---- named cases -------------------------------------------------------------------------------

// The manual's example: 607Ah = 10000, 6081h = 1000, 6083h = 6084h = 6000.
const Case kManual{{0.0, 0.0}, 10000.0, {1000.0, 6000.0, 6000.0}};

TEST(TrapezoidalProfile, RunsTheManualsExampleIn10166Milliseconds) {
  const Profile profile = plan(kManual);

  // Ramps: 1000/6000 = 1/6 s and 1000²/(2·6000) = 83.333 units each; cruise:
  // (10000 - 166.667)/1000 = 9.83333 s; 10.16667 s in total.
  EXPECT_NEAR(profile.duration(), 10.0 + 1.0 / 6.0, 1e-12);
  EXPECT_NEAR(profile.at(1.0 / 6.0).position, 1000.0 / 12.0, 1e-9);
  EXPECT_NEAR(profile.at(1.0 / 6.0).velocity, 1000.0, 1e-9);
  EXPECT_NEAR(profile.at(5.0).position, 1000.0 / 12.0 + 1000.0 * (5.0 - 1.0 / 6.0), 1e-9);
  EXPECT_NEAR(profile.at(10.0).position, 10000.0 - 1000.0 / 12.0, 1e-9);
  EXPECT_EQ(profile.at(5.0).velocity, 1000.0);
  EXPECT_EQ(profile.end_position(), 10000.0);
  EXPECT_TRUE(profile.reaches_target());
}

TEST(TrapezoidalProfile, StaysAtItsEnd) {
  const Profile profile = plan(kManual);

  for (const double time : {profile.duration(), 1e300, std::numeric_limits<double>::infinity()}) {
    const MotionSample sample = profile.at(time);
    EXPECT_EQ(sample.position, 10000.0) << time;
    EXPECT_EQ(sample.velocity, 0.0) << time;
    EXPECT_EQ(sample.acceleration, 0.0) << time;
  }
}

TEST(TrapezoidalProfile, RunsTheDefaultsAsATriangle) {
  // 10000 units at 409600/s²: the peak would be sqrt(10000·409600) = 64000 < 68267, so the move
  // lasts 2·64000/409600 = 0.3125 s.
  const Profile profile = plan({{0.0, 0.0}, 10000.0, {68267.0, 409600.0, 409600.0}});

  EXPECT_NEAR(profile.duration(), 0.3125, 1e-12);
  EXPECT_NEAR(profile.at(0.15625).velocity, 64000.0, 1e-6);
  EXPECT_NEAR(profile.at(0.15625).position, 5000.0, 1e-8);
}

TEST(TrapezoidalProfile, UsesAccelerationToSpeedUpAndDecelerationToSlowDown) {
  // 3000 units at 1000/s, up with 2000/s² (0.5 s, 250 units), down with 500/s² (2 s, 1000 units):
  // cruise 1750 units, 1.75 s.
  const Profile profile = plan({{0.0, 0.0}, 3000.0, {1000.0, 2000.0, 500.0}});

  EXPECT_NEAR(profile.duration(), 4.25, 1e-12);
  EXPECT_EQ(profile.at(0.25).acceleration, 2000.0);
  EXPECT_EQ(profile.at(1.0).acceleration, 0.0);
  EXPECT_EQ(profile.at(3.0).acceleration, -500.0);
}

TEST(TrapezoidalProfile, AZeroLengthMoveEndsAtOnce) {
  const Profile profile = plan({{7.0, 0.0}, 7.0, {1000.0, 10.0, 10.0}});

  EXPECT_EQ(profile.duration(), 0.0);
  EXPECT_EQ(profile.at(0.0).position, 7.0);
  EXPECT_TRUE(profile.reaches_target());
}

TEST(TrapezoidalProfile, ReversesWhenTargetLiesInsideStoppingDistance) {
  // At 1000/s with 1000/s²: stopping distance 500, target 100 ahead. Stop at 500 after 1 s, then
  // back 400 units: peak sqrt(400·1000) = 632.46, 2·0.63246 s.
  const Profile profile = plan({{0.0, 1000.0}, 100.0, {1000.0, 1000.0, 1000.0}});

  EXPECT_NEAR(profile.at(1.0).position, 500.0, 1e-9);
  EXPECT_NEAR(profile.at(1.0).velocity, 0.0, 1e-9);
  EXPECT_NEAR(profile.duration(), 1.0 + 2.0 * std::sqrt(0.4), 1e-12);
  EXPECT_EQ(profile.end_position(), 100.0);
}

TEST(TrapezoidalProfile, ReversesWhenTheTargetLiesBehind) {
  const Profile profile = plan({{0.0, 1000.0}, -1000.0, {1000.0, 1000.0, 1000.0}});

  // Stop at 500 after 1 s; back 1500: 0.5 s up, 1 s at 1000, 0.5 s down; 500 + 500 + 500 units.
  EXPECT_NEAR(profile.duration(), 1.0 + 1.0 + 0.5 + 1.0, 1e-12);
  EXPECT_EQ(profile.end_position(), -1000.0);
}

TEST(TrapezoidalProfile, SlowsDownToALowerLimitWithTheDeceleration) {
  // From 2000/s to 1000/s with 500/s²: 2 s, 3000 units; then 1000/s; stop in 2 s, 1000 units.
  const Profile profile = plan({{0.0, 2000.0}, 10000.0, {1000.0, 9999.0, 500.0}});

  EXPECT_NEAR(profile.at(2.0).velocity, 1000.0, 1e-9);
  EXPECT_NEAR(profile.at(2.0).position, 3000.0, 1e-9);
  EXPECT_NEAR(profile.duration(), 2.0 + 6.0 + 2.0, 1e-12);
}

TEST(TrapezoidalProfile, AcceleratesToAHigherLimitFromThePresentSpeed) {
  const Profile profile = plan({{0.0, 500.0}, 10000.0, {1000.0, 1000.0, 1000.0}});

  EXPECT_NEAR(profile.at(0.5).velocity, 1000.0, 1e-9);
  EXPECT_NEAR(profile.at(0.5).position, 375.0, 1e-9);  // (500 + 1000)/2·0.5
}

TEST(TrapezoidalProfile, WithoutVelocityStaysAndDoesNotReachTheTarget) {
  const Profile profile = plan({{3.0, 0.0}, 10.0, {0.0, 10.0, 10.0}});

  EXPECT_EQ(profile.duration(), 0.0);
  EXPECT_EQ(profile.end_position(), 3.0);
  EXPECT_FALSE(profile.reaches_target());
}

TEST(TrapezoidalProfile, WithoutVelocityBrakesFromMotion) {
  const Profile profile = plan({{0.0, -100.0}, 10.0, {0.0, 10.0, 50.0}});

  EXPECT_NEAR(profile.duration(), 2.0, 1e-12);
  EXPECT_NEAR(profile.end_position(), -100.0, 1e-9);  // 100²/(2·50)
  EXPECT_FALSE(profile.reaches_target());
}

TEST(TrapezoidalProfile, CrossesTheWholeRangeOf32Bits) {
  for (const double velocity : {1.0, 1000.0, 4294967295.0}) {
    for (const double ramp : {1.0, 409600.0, 4294967040.0}) {
      const Profile profile = plan({{-2147483648.0, 0.0}, 2147483647.0, {velocity, ramp, ramp}});
      EXPECT_EQ(profile.at(profile.duration()).position, 2147483647.0);
      EXPECT_EQ(profile.at(1e300).position, 2147483647.0);
      EXPECT_TRUE(std::isfinite(profile.duration()));
    }
  }
}

TEST(TrapezoidalProfile, MovesASingleUnitUnderTheSteepestRamps) {
  const Profile profile = plan({{0.0, 0.0}, 1.0, {4294967295.0, 4294967295.0, 4294967295.0}});
  // Peak sqrt(1·4294967295) = 65536: 2·65536/4294967295 s.
  EXPECT_NEAR(profile.duration(), 2.0 * std::sqrt(1.0 / 4294967295.0), 1e-15);
  EXPECT_EQ(profile.end_position(), 1.0);
}

TEST(TrapezoidalProfile, HoldsItsStartBeforeAndItsEndAfterTheMotion) {
  const Profile profile = plan(kManual);

  EXPECT_EQ(profile.at(-1.0).position, 0.0);
  EXPECT_EQ(profile.at(0.0).position, 0.0);
  EXPECT_EQ(profile.at(11.0).position, 10000.0);
  EXPECT_EQ(profile.at(11.0).velocity, 0.0);
  EXPECT_EQ(profile.at(11.0).acceleration, 0.0);
}

TEST(StopProfile, BrakesToRestInVelocityOverDeceleration) {
  for (const double sign : {1.0, -1.0}) {
    const Profile profile = plan_stop({10.0, sign * 3000.0}, 6000.0);

    EXPECT_NEAR(profile.duration(), 0.5, 1e-15);
    EXPECT_NEAR(profile.end_position(), 10.0 + sign * 750.0, 1e-9);  // 3000²/(2·6000)
    EXPECT_NEAR(profile.at(0.25).velocity, sign * 1500.0, 1e-9);
    EXPECT_TRUE(profile.reaches_target());
  }
}

TEST(StopProfile, OfAnAxisAtRestIsEmpty) {
  const Profile profile = plan_stop({10.0, 0.0}, 6000.0);
  EXPECT_EQ(profile.segment_count(), 0U);
  EXPECT_EQ(profile.at(0.0).position, 10.0);
}

// ---- properties --------------------------------------------------------------------------------

/// Registers as a master may set them; 0 in 6083h or 6084h counts as 1.
Case random_case(Random& random) {
  Case c;
  c.limits.velocity = static_cast<double>(random.word());
  c.limits.acceleration = std::max(1.0, static_cast<double>(random.word()));
  c.limits.deceleration = std::max(1.0, static_cast<double>(random.word()));
  c.start.position = static_cast<double>(static_cast<std::int32_t>(random.word()));
  if (random.one_in(2)) c.start.position += random.unit();
  switch (random.below(4)) {
    case 0:  // a relative move, which may leave the range
      c.target = std::nearbyint(c.start.position) +
                 static_cast<double>(static_cast<std::int32_t>(random.word()));
      break;
    case 1:  // nearby
      c.target = std::nearbyint(c.start.position) + static_cast<double>(random.below(201)) - 100.0;
      break;
    default:
      c.target = static_cast<double>(static_cast<std::int32_t>(random.word()));
      break;
  }
  switch (random.below(4)) {
    case 0:
      c.start.velocity = static_cast<double>(random.word());
      break;
    case 1:
      c.start.velocity = -static_cast<double>(random.word()) * random.unit();
      break;
    case 2:
      c.start.velocity = (random.one_in(2) ? 1.0 : -1.0) * c.limits.velocity * random.unit();
      break;
    default:
      break;
  }
  return c;
}

/// The errors that rounding may cause: a time near T is exact to an ulp of T, positions to ulps of
/// the largest.
struct Tolerance {
  double position;
  double velocity;
};

Tolerance tolerance_of(const Case& c, const Profile& profile) {
  const double fastest = std::max(c.limits.velocity, std::abs(c.start.velocity));
  const double steepest = std::max(c.limits.acceleration, c.limits.deceleration);
  double farthest = std::max(std::abs(c.start.position), std::abs(c.target));
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    farthest = std::max(farthest, std::abs(profile.segment(i).position));
  }
  double peak = std::abs(c.start.velocity);
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    peak = std::max(peak, std::abs(profile.segment(i).velocity));
  }
  const double instant = 4.0 * kEpsilon * profile.duration();
  return {16.0 * kEpsilon * farthest + instant * peak + 0.5 * steepest * instant * instant,
          16.0 * kEpsilon * fastest + instant * steepest};
}

void expect_exact_end(const Case& c, const Profile& profile) {
  ASSERT_TRUE(std::isfinite(profile.duration())) << c;
  ASSERT_GE(profile.duration(), 0.0) << c;
  if (c.limits.velocity == 0.0) {
    const double rest = c.start.position +
                        0.5 * c.start.velocity * std::abs(c.start.velocity) / c.limits.deceleration;
    ASSERT_NEAR(profile.end_position(), rest, tolerance_of(c, profile).position) << c;
    ASSERT_EQ(profile.reaches_target(), profile.end_position() == c.target) << c;
    return;
  }
  ASSERT_TRUE(profile.reaches_target()) << c;
  ASSERT_EQ(profile.end_position(), c.target) << c;
  const MotionSample end = profile.at(profile.duration());
  ASSERT_EQ(end.position, c.target) << c;
  ASSERT_EQ(end.velocity, 0.0) << c;
  if (profile.segment_count() > 0) {
    const Segment& last = profile.segment(profile.segment_count() - 1);
    ASSERT_EQ(sample(last, last.end_time).position, c.target) << c;
  }
}

void expect_limits(const Case& c, const Profile& profile) {
  const Tolerance tolerance = tolerance_of(c, profile);
  double speed_before = std::abs(c.start.velocity);
  double begin = 0.0;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    const Segment& segment = profile.segment(i);
    const double from = sample(segment, begin).velocity;
    const double to = sample(segment, segment.end_time).velocity;
    const double steeper = std::abs(segment.acceleration);
    const bool speeds_up = std::abs(to) > std::abs(from);
    ASSERT_TRUE(steeper == 0.0 ||
                steeper == (speeds_up ? c.limits.acceleration : c.limits.deceleration) ||
                std::abs(to - from) <= tolerance.velocity)
        << c << " segment " << i;
    // The velocity exceeds the limit only while the axis brakes from a start above it.
    ASSERT_LE(std::abs(to), std::max(c.limits.velocity, std::abs(from)) + tolerance.velocity) << c;
    if (speeds_up || steeper == 0.0) {
      ASSERT_LE(std::abs(to), c.limits.velocity + tolerance.velocity) << c << " segment " << i;
    }
    ASSERT_LE(std::abs(from), speed_before + tolerance.velocity) << c << " segment " << i;
    speed_before = std::abs(to);
    begin = segment.end_time;
  }
}

void expect_continuity(const Case& c, const Profile& profile) {
  const Tolerance tolerance = tolerance_of(c, profile);
  double position = c.start.position;
  double velocity = c.start.velocity;
  double time = 0.0;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    const Segment& segment = profile.segment(i);
    ASSERT_GE(segment.end_time, time) << c;
    const MotionSample begin = sample(segment, time);
    ASSERT_NEAR(begin.position, position, tolerance.position) << c << " segment " << i;
    ASSERT_NEAR(begin.velocity, velocity, tolerance.velocity) << c << " segment " << i;
    time = segment.end_time;
    position = sample(segment, time).position;
    velocity = sample(segment, time).velocity;
  }
  ASSERT_NEAR(velocity, 0.0, tolerance.velocity) << c;
  ASSERT_NEAR(position, profile.end_position(), tolerance.position) << c;
}

void expect_symmetry(const Case& c, const Profile& profile) {
  const Profile mirror = plan(mirrored(c));
  ASSERT_EQ(mirror.duration(), profile.duration()) << c;
  ASSERT_EQ(mirror.end_position(), -profile.end_position()) << c;
  for (int k = 0; k <= 8; ++k) {
    const double time = profile.duration() * k / 8.0;
    ASSERT_EQ(mirror.at(time).position, -profile.at(time).position) << c;
    ASSERT_EQ(mirror.at(time).velocity, -profile.at(time).velocity) << c;
  }
}

/// Within a segment, position and velocity follow from an earlier sample and its acceleration, so
/// sampling in one step or in many gives the same result.
void expect_same_in_many_steps(const Case& c, const Profile& profile, Random& random) {
  const Tolerance tolerance = tolerance_of(c, profile);
  double begin = 0.0;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    const double end = profile.segment(i).end_time;
    const double first = begin + (end - begin) * random.unit() * 0.5;
    const double second = first + (end - first) * random.unit() * 0.5;
    const MotionSample from = profile.at(first);
    const MotionSample to = profile.at(second);
    const double step = second - first;
    if (second < end && first >= begin) {
      ASSERT_NEAR(from.position + (from.velocity + 0.5 * from.acceleration * step) * step,
                  to.position, 2.0 * tolerance.position)
          << c;
      ASSERT_NEAR(from.velocity + from.acceleration * step, to.velocity, 2.0 * tolerance.velocity)
          << c;
    }
    begin = end;
  }
}

void expect_replanning_changes_nothing(const Case& c, const Profile& profile, Random& random) {
  const double now = profile.duration() * random.unit();
  const MotionSample state = profile.at(now);
  const Case middle{{state.position, state.velocity}, c.target, c.limits};
  const Profile again = plan(middle);
  const Tolerance first = tolerance_of(c, profile);
  const Tolerance second = tolerance_of(middle, again);
  // A velocity error v·ε when planning again moves the end of the braking distance by v²·ε/d.
  const double v = std::abs(state.velocity);
  const double brake = (first.velocity + second.velocity) * (v / c.limits.deceleration);
  const double slack = 8.0 * (first.position + second.position + brake);
  for (int k = 0; k <= 8; ++k) {
    const double ahead = (profile.duration() - now) * k / 8.0;
    ASSERT_NEAR(again.at(ahead).position, profile.at(now + ahead).position,
                slack + 8.0 * first.velocity * ahead)
        << c << " replanned at " << now;
  }
}

// ---- independent minimum time: bisection over the reachable rest positions ---------------------

/// Farthest position in positive direction at which the axis can rest after `time` >= |v0|/d, from
/// the definition of the limits; it grows monotonically with `time`.
double farthest_rest(MotionState start, double time, const MotionLimits& limits) {
  const double a = limits.acceleration;
  const double d = limits.deceleration;
  double x = start.position;
  double v = start.velocity;
  double remaining = time;
  if (v < 0.0) {  // stop first
    x -= 0.5 * v * v / d;
    remaining -= -v / d;
    v = 0.0;
  }
  if (v > limits.velocity) {  // down to the limit, cruise, down to rest
    return x + 0.5 * v * v / d + limits.velocity * std::max(remaining - v / d, 0.0);
  }
  // The time beyond the shortest stop is spent on speeding up by `gain` and slowing down again.
  const double spare = std::max(remaining - v / d, 0.0);
  const double gain = std::min(spare / (1.0 / a + 1.0 / d), limits.velocity - v);
  const double peak = v + gain;
  const double cruise = std::max(spare - gain / a - gain / d, 0.0);
  return x + 0.5 * v * v / d + (v + 0.5 * gain) * (gain / a) + (v + 0.5 * gain) * (gain / d) +
         peak * cruise;
}

bool reachable(const Case& c, double time) {
  const Case m = mirrored(c);
  return c.target <= farthest_rest(c.start, time, c.limits) &&
         m.target <= farthest_rest(m.start, time, m.limits);
}

double minimum_time(const Case& c) {
  double low = std::abs(c.start.velocity) / c.limits.deceleration;
  double high = std::max(2.0 * low, 1.0e-9);
  while (!reachable(c, high)) high *= 2.0;
  for (int i = 0; i < 120 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (reachable(c, middle) ? high : low) = middle;
  }
  return high;
}

void expect_minimum_time(const Case& c, const Profile& profile) {
  if (c.limits.velocity == 0.0) return;
  // If the target lies at the stopping distance, the time depends on a square root of the position;
  // so the time that rounding of positions may cost is found by shifting the target.
  const double stop = 0.5 * c.start.velocity * c.start.velocity / c.limits.deceleration;
  const double slack = 16.0 * kEpsilon * (std::abs(c.start.position) + std::abs(c.target) + stop);
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0.0;
  const double to_stop = c.start.position + (c.start.velocity < 0.0 ? -stop : stop) - c.target;
  for (const double shift : {-slack, 0.0, slack, std::clamp(to_stop, -slack, slack)}) {
    Case shifted = c;
    shifted.target += shift;
    const double time = minimum_time(shifted);
    shortest = std::min(shortest, time);
    longest = std::max(longest, time);
  }
  ASSERT_GE(profile.duration(), shortest * (1.0 - 1e-11) - 1e-15) << c << " faster than possible";
  ASSERT_LE(profile.duration(), longest * (1.0 + 1e-11) + 1e-15) << c << " slower than necessary";
}

TEST(ProfileProperties, ExactEndLimitsContinuityAndSymmetryHoldOverTheWholeDomain) {
  Random random(1);
  const std::uint64_t count = case_count(100'000, 10'000'000);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Case c = random_case(random);
    const Profile profile = plan(c);
    ASSERT_NO_FATAL_FAILURE(expect_exact_end(c, profile));
    ASSERT_NO_FATAL_FAILURE(expect_limits(c, profile));
    ASSERT_NO_FATAL_FAILURE(expect_continuity(c, profile));
    ASSERT_NO_FATAL_FAILURE(expect_symmetry(c, profile));
    ASSERT_NO_FATAL_FAILURE(expect_same_in_many_steps(c, profile, random));
  }
}

TEST(ProfileProperties, ReplanningInTheMiddleChangesNothing) {
  Random random(2);
  const std::uint64_t count = case_count(100'000, 10'000'000);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Case c = random_case(random);
    ASSERT_NO_FATAL_FAILURE(expect_replanning_changes_nothing(c, plan(c), random));
  }
}

TEST(ProfileProperties, DurationEqualsTheShortestThatABisectionFinds) {
  Random random(3);
  const std::uint64_t count = case_count(30'000, 1'000'000);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Case c = random_case(random);
    ASSERT_NO_FATAL_FAILURE(expect_minimum_time(c, plan(c)));
  }
}

TEST(ProfileProperties, DemandNeverLeavesTheRangeBetweenItsExtremes) {
  // Monotone approach: the target is overshot only as far as a start that cannot stop forces it.
  Random random(4);
  const std::uint64_t count = case_count(100'000, 10'000'000);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Case c = random_case(random);
    const Profile profile = plan(c);
    const double stop = c.start.position +
                        0.5 * c.start.velocity * std::abs(c.start.velocity) / c.limits.deceleration;
    const double end = c.limits.velocity == 0.0 ? stop : c.target;
    const double low = std::min({c.start.position, stop, end});
    const double high = std::max({c.start.position, stop, end});
    const double slack = 4.0 * tolerance_of(c, profile).position;
    for (int k = 0; k <= 16; ++k) {
      const double x = profile.at(profile.duration() * k / 16.0).position;
      ASSERT_GE(x, low - slack) << c;
      ASSERT_LE(x, high + slack) << c;
    }
  }
}

TEST(ProfileProperties, StopsEndAtTheStoppingDistanceOverTheWholeDomain) {
  Random random(5);
  const std::uint64_t count = case_count(100'000, 10'000'000);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Case c = random_case(random);
    const Profile profile = plan_stop(c.start, c.limits.deceleration);
    const double time = std::abs(c.start.velocity) / c.limits.deceleration;
    const double end = c.start.position + 0.5 * c.start.velocity * time;
    ASSERT_NEAR(profile.duration(), time, 4.0 * kEpsilon * time) << c;
    ASSERT_NEAR(profile.end_position(), end,
                16.0 * kEpsilon * (std::abs(c.start.position) + std::abs(end)))
        << c;
    ASSERT_EQ(profile.at(profile.duration()).velocity, 0.0) << c;
    ASSERT_TRUE(profile.reaches_target()) << c;
  }
}

TEST(ProfileProperties, NoErrorGrowsWithTheLengthOfTheMove) {
  // 1 unit/s over the full range takes 49710 days; full seconds coincide with whole units.
  const Profile profile = plan({{-2147483648.0, 0.0}, 2147483647.0, {1.0, 1.0, 1.0}});
  for (const double day : {24.9, 49.7, 10000.0, 49709.0}) {
    const double time = std::floor(day * 86400.0);
    // After the ramp (1 s, 0.5 units): x = x0 + t - 0.5.
    EXPECT_NEAR(profile.at(time).position, -2147483648.0 + time - 0.5, 1e-6) << day << " days";
  }
  EXPECT_EQ(profile.at(profile.duration()).position, 2147483647.0);
}

// ---- the ends of every register, in all combinations -------------------------------------------

constexpr double kLowestRegister = -2147483648.0;
constexpr double kHighestRegister = 2147483647.0;
constexpr double kWholeRange = 4294967295.0;

/// Starts and targets: the ends of int32 and their neighbours, one unit and the full range apart,
/// and relative targets that leave the range.
std::vector<Case> extreme_ways() {
  std::vector<Case> ways;
  for (const double from : {kLowestRegister, -1.0, 0.0, kHighestRegister}) {
    for (const double way : {1.0, 2.0, 100.0, 2147483648.0, kWholeRange}) {
      ways.push_back({{from, 0.0}, from + way, {}});
      ways.push_back({{from, 0.0}, from - way, {}});
    }
    for (const double to : {kLowestRegister, kHighestRegister}) {
      ways.push_back({{from, 0.0}, to, {}});
    }
  }
  return ways;
}

void expect_finite(const Case& c, const Profile& profile) {
  for (int k = -1; k <= 17; ++k) {
    const MotionSample now = profile.at(profile.duration() * k / 16.0);
    ASSERT_TRUE(std::isfinite(now.position) && std::isfinite(now.velocity) &&
                std::isfinite(now.acceleration))
        << c;
  }
}

/// Register values of 6083h and 6084h; 0 counts as 1 (in the drive).
constexpr std::array<double, 4> kExtremeRamps{1.0, 409600.0, 4294967040.0, 4294967295.0};

void expect_all_properties(const Case& c, Random& random) {
  const Profile profile = plan(c);
  ASSERT_NO_FATAL_FAILURE(expect_finite(c, profile));
  ASSERT_NO_FATAL_FAILURE(expect_exact_end(c, profile));
  ASSERT_NO_FATAL_FAILURE(expect_limits(c, profile));
  ASSERT_NO_FATAL_FAILURE(expect_continuity(c, profile));
  ASSERT_NO_FATAL_FAILURE(expect_symmetry(c, profile));
  ASSERT_NO_FATAL_FAILURE(expect_same_in_many_steps(c, profile, random));
  ASSERT_NO_FATAL_FAILURE(expect_replanning_changes_nothing(c, profile, random));
  ASSERT_NO_FATAL_FAILURE(expect_minimum_time(c, profile));
}

TEST(ProfileProperties, HoldForAllCombinationsOfRegisterExtremes) {
  Random random(6);
  std::uint64_t cases = 0;
  for (const Case& way : extreme_ways()) {
    for (const double speed : {0.0, 1.0, 136533.0, 4294967295.0}) {
      for (const double up : kExtremeRamps) {
        for (const double down : kExtremeRamps) {
          // At rest, slow, on the limit, faster than the limit; towards the target and away from
          // it. This includes starts inside the stopping distance and beyond the target.
          for (const double start : {0.0, 1.0, -1.0, speed, -speed, 2.0 * speed + 1.0,
                                     -2.0 * speed - 1.0, 4294967295.0, -4294967295.0}) {
            Case c = way;
            c.start.velocity = start;
            c.limits = {speed, up, down};
            ASSERT_NO_FATAL_FAILURE(expect_all_properties(c, random));
            ++cases;
          }
        }
      }
    }
  }
  EXPECT_EQ(cases, 48U * 4U * 16U * 9U);
}

// ---- the demand of an axis ---------------------------------------------------------------------

struct AxisCase {
  std::int64_t speed;         // 6081h
  std::int64_t acceleration;  // 6083h and 6084h
  std::int32_t from;
  std::int32_t to;
};

/// Checks 6062h and 606Bh in every tick against the closed form that the registers define.
void expect_demand_on_the_profile(const AxisCase& c, int ticks) {
  AxisConfiguration configuration;
  configuration.initial_position = c.from;
  test::AxisUnderTest axis(configuration);
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("app_speed_limit", 0xFFFFFFFF);
  axis.write("motor_max_speed_rpm", 0xFFFFFFFF);
  axis.write("profile_velocity", c.speed);
  axis.write("profile_acc", c.acceleration);
  axis.write("profile_dec", c.acceleration);
  axis.enable();
  axis.write("position_user_target_value", c.to);
  axis.controlword(0x001F);
  // 0 in 6083h or 6084h counts as 1; both are capped by 60C5h and 60C6h.
  const double ramp = std::clamp(static_cast<double>(c.acceleration), 1.0, 4294967040.0);
  const Profile profile = plan({{static_cast<double>(c.from), 0.0},
                                static_cast<double>(c.to),
                                {static_cast<double>(c.speed), ramp, ramp}});
  for (int tick = 1; tick <= ticks; ++tick) {
    axis.step();
    const MotionSample expected = profile.at(tick * 1.0e-3);
    ASSERT_EQ(axis.demand(), std::llrint(expected.position)) << "tick " << tick;
    // 606Bh is an INTEGER32 and saturates.
    ASSERT_NEAR(axis.demand_velocity(),
                std::clamp(expected.velocity, kLowestRegister, kHighestRegister), 0.51)
        << "tick " << tick;
  }
  const bool over = profile.duration() < ticks * 1.0e-3 && c.speed != 0;
  ASSERT_TRUE(!over || axis.demand() == c.to);
}

TEST(AxisDemand, EqualsTheProfileInEveryTickAtTheEndsOfTheRegisters) {
  constexpr auto kLow = std::numeric_limits<std::int32_t>::min();
  constexpr auto kHigh = std::numeric_limits<std::int32_t>::max();
  const auto ticks = static_cast<int>(case_count(3'100, 10'000));
  for (const std::int64_t speed : {0LL, 1LL, 136'533LL, 4294967295LL}) {
    for (const std::int64_t acceleration : {0LL, 1LL, 409'600LL, 4294967040LL, 4294967295LL}) {
      for (const auto& [from, to] :
           {std::pair{kLow, kHigh}, std::pair{kHigh, kLow}, std::pair{0, 1}, std::pair{0, -1},
            std::pair{kLow, kLow + 1}, std::pair{kHigh - 1, kHigh}, std::pair{0, kLow}}) {
        SCOPED_TRACE(std::to_string(speed) + " units/s, " + std::to_string(acceleration) +
                     " units/s2, " + std::to_string(from) + " to " + std::to_string(to));
        ASSERT_NO_FATAL_FAILURE(
            expect_demand_on_the_profile({speed, acceleration, from, to}, ticks));
      }
    }
  }
}

TEST(AxisDemand, OfRelativeMovesWrapsAtBothEndsOfTheRegister) {
  for (const int sign : {1, -1}) {
    AxisConfiguration configuration;
    configuration.initial_position = sign > 0 ? 2147483647 : -2147483647 - 1;
    test::AxisUnderTest axis(configuration);
    axis.write("following_error_window", 0xFFFFFFFF);
    axis.write("app_speed_limit", 0xFFFFFFFF);
    axis.write("motor_max_speed_rpm", 0xFFFFFFFF);
    axis.write("profile_velocity", 4294967295);
    axis.write("profile_acc", 4294967295);
    axis.write("profile_dec", 4294967295);
    axis.write("positioning_option_code", 0);
    axis.enable();
    // Ten times across the full range: 2147483647 units each, modulo 2³².
    auto expected = static_cast<std::uint32_t>(configuration.initial_position);
    for (int i = 0; i < 10; ++i) {
      axis.write("position_user_target_value", sign * 2147483647LL);
      axis.command(0x007F);
      axis.command(0x000F);
      expected += static_cast<std::uint32_t>(sign * 2147483647LL);
      // sqrt(4·2³¹/2³²) = 1.41 s
      axis.step(1'500);
      ASSERT_EQ(axis.demand(), static_cast<std::int32_t>(expected)) << "move " << i;
      ASSERT_EQ(axis.demand_velocity(), 0);
    }
  }
}

// ---- uptimes -----------------------------------------------------------------------------------

/// One drive without a bank: all that depends on its running time is in its state, which a test can
/// set to any time. A tick is 1 ms: 2³¹ ticks are 24.9 days, 2³² are 49.7.
class LongRunningDrive {
 public:
  LongRunningDrive() {
    // A power-up does not set the test-bench objects: without their defaults, 5E21h would place
    // switches at 0.
    for (std::size_t row = 0; row < kObjectTable.size(); ++row) {
      registers_.values[row] = kObjectTable[row].default_value;
    }
    power_up(axis_, true);
    write("op_mode_cmd", 1);
    write("following_error_window", 0xFFFFFFFF);
  }

  void write(std::string_view name, std::int64_t value) {
    ASSERT_EQ(write_object(axis_, *find_object(name), value).code, AbortCode::none);
  }

  /// One tick of an ideal servo: the load is at the demand.
  void tick() {
    begin_tick(axis_);
    watch_tick(axis_);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): filled by the next statement
    NumberBlock numbers;
    round_numbers(block_, numbers);
    end_tick(axis_, numbers);
    block_.servo.load_reading[0] = demand_position() + distance_;
  }

  void tick(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  /// Puts the load this far from the demand [UU].
  void push_away(double distance) { distance_ = distance; }

  /// Following errors set bit 13 and are not faults.
  void only_warn() { registers_.settings.following_error_is_fault = false; }

  DriveState& state() { return state_; }

  [[nodiscard]] double demand_position() const { return block_.demand.position[0]; }

  void set_demand_position(double position) { block_.demand.position[0] = position; }

  /// Sets the time to `ticks` after the plan, in its segment number `segment`.
  void go_to(double ticks, std::size_t segment) {
    block_.demand.plan_ticks[0] = ticks;
    put_segment(axis_, with_jerk(profile().segment(segment)));
  }

  [[nodiscard]] const Profile& profile() const { return registers_.profile; }

  [[nodiscard]] const AxisStatus& status() const { return status_; }

 private:
  double distance_ = 0.0;
  DriveState state_{};
  DriveRegisters registers_;
  BlockState block_{};
  AxisStatus status_{};
  TickTiming timing_{};
  Drive axis_{state_, registers_, block_, 0, status_, timing_};
};

constexpr double kDay = 86'400.0;

TEST(Uptime, AMoveAcrossTheWholeRangeIsExactAfter24And49Days) {
  // 2³² - 1 units at 999 units/s last 4299266 s, 49.76 days: more than 2³² ticks of 1 ms.
  LongRunningDrive drive;
  drive.write("profile_velocity", 999);
  drive.write("profile_acc", 999);
  drive.write("profile_dec", 999);
  drive.write("ds402_controlword", 0x0F);
  drive.set_demand_position(kLowestRegister);
  drive.write("position_user_target_value", 2147483647);
  drive.write("ds402_controlword", 0x1F);
  drive.tick();
  const double start = drive.profile().at(0.0).position;
  ASSERT_GT(drive.profile().duration(), 49.75 * kDay);
  for (const double border : {2147483648.0, 4294967296.0}) {
    // The segment in force at that time is the second: 999 units/s.
    drive.go_to(border - 50.0, 1);
    for (int i = 1; i <= 100; ++i) {
      drive.tick();
      // After a ramp of 1 s and 499.5 units: x = x0 + 499.5 + 999 (t - 1).
      const double seconds = (border - 50.0 + i) * 1.0e-3;
      const double position = start + 499.5 + 999.0 * (seconds - 1.0);
      ASSERT_NEAR(drive.demand_position(), position, 1.0e-5) << border << " + " << i - 50;
      ASSERT_EQ(drive.status().velocity_demand_value, 999);
      ASSERT_EQ(drive.status().ds402_statusword, 0x1237);
    }
  }
  // It ends exactly on its target.
  drive.go_to(std::floor(drive.profile().duration() * 1'000.0) - 5.0, 2);
  drive.tick(10);
  EXPECT_EQ(drive.demand_position(), start + kWholeRange);
  EXPECT_EQ(drive.status().velocity_demand_value, 0);
}

TEST(Uptime, TickCountersSaturate) {
  // At rest for 49.7 days: the time in the window, the time in the state, the time of the following
  // error.
  for (const std::uint32_t ticks : {0x7FFFFFFFU, 0xFFFFFFFFU}) {
    LongRunningDrive drive;
    drive.write("ds402_controlword", 0x0F);
    drive.tick(100);
    ASSERT_EQ(drive.status().ds402_statusword, 0x0637);
    drive.state().window.dwell = ticks - 5;
    drive.state().power.ticks_in_state = ticks - 5;
    for (int i = 0; i < 20; ++i) {
      drive.tick();
      ASSERT_EQ(drive.status().ds402_statusword, 0x0637) << i;
    }
    EXPECT_GE(drive.state().window.dwell, ticks);
    EXPECT_GE(drive.state().power.ticks_in_state, ticks);
    // From here on it behaves like a new axis.
    drive.write("position_user_target_value", 0);
    drive.write("ds402_controlword", 0x1F);
    drive.tick();
    EXPECT_EQ(drive.status().ds402_statusword, 0x1237);
    drive.tick(25);
    EXPECT_EQ(drive.status().ds402_statusword, 0x1637);
    drive.write("ds402_controlword", 0x02);
    drive.tick();
    EXPECT_EQ(drive.status().ds402_statusword & 0x6F, 0x07);
    drive.tick();
    EXPECT_EQ(drive.status().ds402_statusword, 0x0250);
  }
}

TEST(Uptime, AFollowingErrorWarningLastsFor49Days) {
  for (const std::uint32_t ticks : {0x7FFFFFFFU, 0xFFFFFFFFU}) {
    LongRunningDrive drive;
    drive.only_warn();
    drive.write("ds402_controlword", 0x0F);
    drive.write("following_error_window", 5);
    drive.write("following_error_time_out", 0);
    drive.push_away(10.0);
    drive.tick(10);
    drive.state().following_error.count = ticks - 5;
    for (int i = 0; i < 20; ++i) {
      drive.tick();
      ASSERT_EQ(drive.status().ds402_statusword & 0x2000, 0x2000) << i;
    }
    drive.push_away(0.0);
    drive.tick(2);
    EXPECT_EQ(drive.status().ds402_statusword & 0x2000, 0);
  }
}

TEST(Uptime, PositionsStayExactOverYearsOfOneDirection) {
  // 2⁴⁰ units are 93 days at 136533 units/s; there the frame is shifted back by whole turns of 2³².
  LongRunningDrive drive;
  drive.write("ds402_controlword", 0x0F);
  drive.write("positioning_option_code", 1);
  drive.tick();
  drive.set_demand_position(1099511627776.0 + 12'345.0);
  drive.tick(2);
  EXPECT_EQ(drive.demand_position(), 12'345.0) << "2⁴⁰ is a whole number of turns";
  EXPECT_EQ(drive.status().position_demand_value, 12'345);
}

}  // namespace
}  // namespace vdrive
