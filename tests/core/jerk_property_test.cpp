// SPDX-License-Identifier: Apache-2.0
// Random plans with limited jerk, checked against the limits alone, against the durations of an
// oracle in long double, and against motions made of other sequences of jerks.
#include "core/support/allocation_guard.hpp"
#include "core/support/jerk_oracle.hpp"
#include "support/random_cases.hpp"
#include "vdrive/motion/jerk_profile.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iomanip>
#include <limits>
#include <ostream>
#include <utility>

namespace vdrive {
namespace {

using test::ExactPath;
using test::ExactState;
using test::fastest_change;
using test::number_if_optimised;
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

/// @return the start, with positions measured from there.
ExactState exact_start(const JerkCase& c) {
  return {.velocity = static_cast<long double>(c.start.velocity),
          .acceleration = static_cast<long double>(c.start.acceleration)};
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
  // Far away, nearby, and around the end of the stop.
  const double base = random.one_in(3)
                          ? plan_jerk_stop(c.start, c.limits.deceleration, c.jerk).end_position()
                          : c.start.position;
  c.target = base + signed_unit(random) * log_uniform(random, 1.0e-2, 1.0e7);
  return c;
}

/// The errors that rounding may cause.
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
  double duration = 0.0;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    position = std::max(position, std::abs(profile.segment(i).position));
    velocity = std::max(velocity, std::abs(profile.segment(i).velocity));
    acceleration = std::max(acceleration, std::abs(profile.segment(i).acceleration));
    if (std::isfinite(profile.segment(i).end_time)) duration = profile.segment(i).end_time;
  }
  const double jerk = std::max(c.jerk.acceleration, c.jerk.deceleration);
  const double instant = 16.0 * kUlp * duration;
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
    if (std::isfinite(time)) before = sample(segment, time);
  }
}

void expect_rest_at(const JerkCase& c, const JerkProfile& profile, double position) {
  ASSERT_TRUE(profile.reaches_target()) << c;
  ASSERT_EQ(profile.end_position(), position) << c;
  if (profile.segment_count() == 0) return;
  const JerkSegment& last = profile.segment(profile.segment_count() - 1);
  const MotionSample end = sample(last, last.end_time);
  ASSERT_EQ(end.position, position) << c;
  ASSERT_EQ(end.velocity, 0.0) << c;
  ASSERT_EQ(end.acceleration, 0.0) << c;
}

/// @return the velocity in `direction` once an acceleration >= 0 in it has been reduced to 0.
double settled_speed(const MotionSample& state, const MotionJerk& jerk, double direction) {
  const double v = direction * state.velocity;
  const double w = 0.5 * state.acceleration * state.acceleration;
  if (v >= 0.0) return v + w / jerk.acceleration;
  const double until_rest = -v * jerk.deceleration;
  return w <= until_rest ? v + w / jerk.deceleration : (w - until_rest) / jerk.acceleration;
}

/// @return the highest velocity that a plan may have in `direction`: the limit, or more if the
///         start forces it.
double forced_speed(const JerkCase& c, double direction) {
  const bool grows = direction * c.start.acceleration > 0.0;
  const double settled =
      grows ? settled_speed(c.start, c.jerk, direction) : direction * c.start.velocity;
  return std::max(settled, c.limits.velocity);
}

/// @return the direction, 1 or -1, that the motion must keep: the start does not go backwards, its
///         acceleration ends before the motion would turn, and the target lies beyond the fastest
///         stop. 0 if there is no such direction.
double kept_direction(const JerkCase& c, const JerkTolerance& slack) {
  const ExactPath stop = fastest_change(exact_start(c), 0.0L, c.limits, c.jerk);
  const double rest = c.start.position + static_cast<double>(stop.end().way);
  if (std::abs(c.target - rest) <= slack.position) return 0.0;
  const double direction = c.target > rest ? 1.0 : -1.0;
  const double speed = direction * c.start.velocity;
  const double w = 0.5 * c.start.acceleration * c.start.acceleration;
  const bool brakes = direction * c.start.acceleration < 0.0;
  return speed < 0.0 || (brakes && w > speed * c.jerk.deceleration) ? 0.0 : direction;
}

struct VelocityRange {
  double lowest = 0.0;
  double highest = 0.0;
};

/// @return the velocities that a move may have: none against the direction that it must keep.
VelocityRange velocities_of_move(const JerkCase& c, const JerkTolerance& slack) {
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

/// A start above the velocity limit, or one that is forced over it, is back as soon as the jerk
/// allows: the acceleration ends, then the excess velocity is removed with the deceleration and its
/// jerk.
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

/// The times at which the velocity or the acceleration of a segment is 0, in order.
struct Roots {
  std::array<double, 3> times{};
  std::size_t count = 0;

  void add(double time) {
    times.at(count) = time;
    ++count;
  }
};

Roots roots_of(const JerkSegment& segment) {
  const double a = segment.acceleration;
  const double v = segment.velocity;
  const double begin = segment.reference_time;
  Roots roots;
  if (segment.jerk == 0.0) {
    if (a != 0.0) roots.add(begin - v / a);
    return roots;
  }
  roots.add(begin - a / segment.jerk);
  const double square = a * a - 2.0 * segment.jerk * v;
  if (square > 0.0) {
    // This form avoids a difference of almost equal numbers.
    const double q = -(a + (a < 0.0 ? -1.0 : 1.0) * std::sqrt(square));
    roots.add(begin + q / segment.jerk);
    roots.add(begin + 2.0 * v / q);
  }
  // Three at most, sorted by hand: gcc 12 warns that the library's sort reads beyond the array.
  for (std::size_t i = 1; i < roots.count; ++i) {
    for (std::size_t j = i; j > 0 && roots.times.at(j) < roots.times.at(j - 1); --j) {
      std::swap(roots.times.at(j), roots.times.at(j - 1));
    }
  }
  return roots;
}

/// The instants of a segment between which velocity and acceleration keep their signs: its ends and
/// the roots of both. All extrema of the velocity and of the acceleration are among them.
class Parts {
 public:
  Parts(const JerkSegment& segment, double begin, double end) : times_{begin} {
    const Roots roots = roots_of(segment);
    for (std::size_t i = 0; i < roots.count; ++i) {
      const double time = roots.times.at(i);
      if (time > times_.at(count_) && time < end) add(time);
    }
    add(end);
  }

  [[nodiscard]] std::size_t size() const { return count_; }

  [[nodiscard]] double begin(std::size_t i) const { return times_.at(i); }

  [[nodiscard]] double end(std::size_t i) const { return times_.at(i + 1); }

 private:
  void add(double time) {
    ++count_;
    times_.at(count_) = time;
  }

  std::array<double, 5> times_;
  std::size_t count_ = 0;
};

/// The bounds of a part of a segment.
struct PartBounds {
  double up = 0.0;    ///< acceleration in the direction of the motion
  double down = 0.0;  ///< the same against it
  double side = 1.0;  ///< 1 or -1, the direction of the motion
  double jerk = 0.0;  ///< 0 if the sign of the velocity or acceleration is not known
};

/// @param middle of the part. If its velocity is 0 up to rounding, its side is not known.
PartBounds bounds_of_part(const JerkCase& c, const MotionSample& middle,
                          const JerkTolerance& slack) {
  PartBounds bounds;
  const double higher = std::max(c.limits.acceleration, c.limits.deceleration);
  const bool has_side = std::abs(middle.velocity) > slack.velocity;
  bounds.up = has_side ? c.limits.acceleration : higher;
  bounds.down = has_side ? c.limits.deceleration : higher;
  bounds.side = middle.velocity < 0.0 ? -1.0 : 1.0;
  if (has_side && std::abs(middle.acceleration) > slack.acceleration) {
    const bool grows = middle.velocity * middle.acceleration > 0.0;
    bounds.jerk = grows ? c.jerk.acceleration : c.jerk.deceleration;
  }
  return bounds;
}

/// @return whether the acceleration exceeds its bounds. The instant of zero velocity is known only
///         as precisely as the velocity. d(a²/2)/dv is the jerk, so the bound of a²/2 is widened by
///         the jerk times the velocity error.
bool has_excess(const JerkCase& c, const PartBounds& bounds, double acceleration,
                const JerkTolerance& slack) {
  const double along = bounds.side * acceleration;
  const double bound = along > 0.0 ? bounds.up : bounds.down;
  const double jerk = std::max(c.jerk.acceleration, c.jerk.deceleration);
  const double rounded = std::sqrt(bound * bound + 8.0 * jerk * slack.velocity);
  return std::abs(along) > rounded * (1.0 + 1.0e-9) + 4.0 * slack.acceleration;
}

/// @return whether this is the full jerk in force; if the ramp is not known, that of either ramp.
bool is_full(const JerkCase& c, const PartBounds& bounds, double jerk) {
  return bounds.jerk > 0.0 ? jerk == bounds.jerk
                           : jerk == c.jerk.acceleration || jerk == c.jerk.deceleration;
}

/// @param may_return whether this part may still reduce the acceleration of the start
void expect_part_within_limits(const JerkCase& c, const JerkSegment& segment, double begin,
                               double end, const JerkTolerance& slack, bool may_return) {
  const MotionSample middle = sample(segment, 0.5 * (begin + end));
  const PartBounds bounds = bounds_of_part(c, middle, slack);
  const double jerk = std::abs(segment.jerk);
  if (bounds.jerk > 0.0) {
    ASSERT_LE(jerk, bounds.jerk) << c << " from " << begin;
  }
  const bool returns = may_return && middle.acceleration * c.start.acceleration > 0.0;
  for (const double time : {begin, end}) {
    const double acceleration = sample(segment, time).acceleration;
    if (!has_excess(c, bounds, acceleration, slack)) continue;
    ASSERT_TRUE(returns) << c << " at " << time << " has " << acceleration;
    ASSERT_TRUE(is_full(c, bounds, jerk)) << c << " at " << time << " returns slowly";
  }
}

void expect_within_limits(const JerkCase& c, const JerkProfile& profile, const JerkTolerance& slack,
                          const VelocityRange& range) {
  double begin = 0.0;
  // While the acceleration of the start is being reduced at the full jerk, no plan can do better.
  bool only_returns = true;
  for (std::size_t i = 0; i < profile.segment_count(); ++i) {
    const JerkSegment& segment = profile.segment(i);
    if (!std::isfinite(segment.end_time)) break;  // a velocity that is kept
    const Parts parts(segment, begin, segment.end_time);
    only_returns = only_returns && segment.jerk * c.start.acceleration < 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      for (const double time : {parts.begin(k), parts.end(k)}) {
        ASSERT_LE(sample(segment, time).velocity, range.highest) << c << " at " << time;
        ASSERT_GE(sample(segment, time).velocity, range.lowest) << c << " at " << time;
      }
      expect_part_within_limits(c, segment, parts.begin(k), parts.end(k), slack, only_returns);
    }
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

/// A part of a fastest motion is the fastest motion between its ends.
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

/// A share of the random plans, with its own random numbers: a nightly run has more plans than one
/// test may take.
class JerkPlans : public testing::TestWithParam<std::uint64_t> {
 protected:
  static constexpr std::uint64_t kShares = 16;

  /// @return the random numbers of this share. @param seed of all shares
  static Random random(std::uint64_t seed) { return Random((seed << 8U) + GetParam()); }

  static std::uint64_t share_of(const test::Effort<std::uint64_t>& effort) {
    return number_if_optimised<std::uint64_t>(effort, 5'000) / kShares;
  }
};

INSTANTIATE_TEST_SUITE_P(Share, JerkPlans, testing::Range<std::uint64_t>(0, 16));

TEST_P(JerkPlans, KeepTheirLimitsAndEndExactlyAtTheTarget) {
  const std::uint64_t cases =
      share_of({.usual = 200'000, .full = 10'000'000, .nightly = 1'000'000'000});
  Random random = JerkPlans::random(0x6A65726BU);
  for (std::uint64_t i = 0; i < cases; ++i) {
    const JerkCase c = random_jerk_case(random);
    const JerkProfile profile = plan_of(c);
    const JerkTolerance slack = tolerance_of_plan(c, profile);
    ASSERT_TRUE(std::isfinite(profile.duration())) << c;
    ASSERT_LE(profile.segment_count(), JerkProfile::kMaximumSegments) << c;
    expect_continuous(c, profile, slack);
    expect_rest_at(c, profile, c.target);
    expect_within_limits(c, profile, slack, velocities_of_move(c, slack));
    expect_back_at_its_velocity(c, profile, slack);
    if (i % 16 == 0) {
      expect_the_mirror_image(c, profile);
      expect_the_same_time_from_its_middle(c, profile, slack, random);
    }
    if (HasFatalFailure()) return;
  }
}

/// @return the velocities of a direct change: from the start to the target, extended to the
///         velocity at which the acceleration of the start has ended, if that lies outside.
VelocityRange velocities_of_change(const JerkCase& c, double target, const JerkTolerance& slack) {
  const auto settled = static_cast<double>(test::settled_velocity(exact_start(c), c.jerk));
  const auto [lowest, highest] = std::minmax({c.start.velocity, settled, target});
  return {lowest - slack.velocity, highest + slack.velocity};
}

/// @return the time that rounding may cost a change of velocity: the velocity error divided by the
///         highest acceleration of the change.
double rounding_of_change(const JerkCase& c, double target, const JerkTolerance& slack,
                          const ExactPath& expected) {
  const auto settled = static_cast<double>(test::settled_velocity(exact_start(c), c.jerk));
  const double span = std::max(std::abs(target - settled), slack.velocity);
  const double jerk = std::min(c.jerk.acceleration, c.jerk.deceleration);
  const double cap = std::min(c.limits.acceleration, c.limits.deceleration);
  return 8.0 * slack.velocity * (1.0 / std::sqrt(jerk * span) + 1.0 / cap) +
         1.0e-12 * static_cast<double>(expected.duration());
}

/// @param arrival the time at which the profile reaches the velocity `target`
void expect_the_fastest_change(const JerkCase& c, double target, const JerkProfile& profile,
                               double arrival) {
  JerkTolerance slack = tolerance_of_plan(c, profile);
  // The remainder of a²/2 at v = 0 was built up with the jerk of one side and is used up with that
  // of the other.
  slack.velocity += 256.0 * kUlp * c.start.acceleration * c.start.acceleration /
                    std::min(c.jerk.acceleration, c.jerk.deceleration);
  expect_continuous(c, profile, slack);
  expect_within_limits(c, profile, slack, velocities_of_change(c, target, slack));
  const ExactPath expected =
      fastest_change(exact_start(c), static_cast<long double>(target), c.limits, c.jerk);
  const double rounding = rounding_of_change(c, target, slack, expected);
  ASSERT_NEAR(arrival, static_cast<double>(expected.duration()), rounding)
      << c << " to the velocity " << target;
  const double fastest =
      std::max({std::abs(c.start.velocity), std::abs(target),
                std::abs(static_cast<double>(test::settled_velocity(exact_start(c), c.jerk)))});
  ASSERT_NEAR(profile.at(arrival).position,
              c.start.position + static_cast<double>(expected.end().way),
              4.0 * slack.position + fastest * rounding)
      << c << " to the velocity " << target;
}

/// @return a velocity within the limit or beyond it, 0, or one that the start has or leads to.
double random_velocity(const JerkCase& c, Random& random) {
  switch (random.below(6)) {
    case 0:
      return 0.0;
    case 1:
      return c.start.velocity;
    case 2:
      return static_cast<double>(test::settled_velocity(exact_start(c), c.jerk));
    case 3:
      return 2.0 * signed_unit(random) * c.limits.velocity;
    default:
      return signed_unit(random) * c.limits.velocity;
  }
}

TEST_P(JerkPlans, ChangeTheVelocityStraightInTheShortestTime) {
  const std::uint64_t cases =
      share_of({.usual = 100'000, .full = 1'000'000, .nightly = 100'000'000});
  Random random = JerkPlans::random(0x76656C6FU);
  for (std::uint64_t i = 0; i < cases; ++i) {
    const JerkCase c = random_jerk_case(random);
    const double wanted = random_velocity(c, random);
    const double target = std::clamp(wanted, -c.limits.velocity, c.limits.velocity);
    const JerkProfile profile = plan_jerk_velocity(c.start, wanted, c.limits, c.jerk);
    const std::size_t count = profile.segment_count();
    double arrival = profile.duration();
    if (target != 0.0) {
      ASSERT_GE(count, 1U) << c;
      const JerkSegment& last = profile.segment(count - 1);
      ASSERT_TRUE(std::isinf(last.end_time)) << c << wanted;
      ASSERT_EQ(last.velocity, target) << c << wanted;
      ASSERT_EQ(last.acceleration, 0.0) << c << wanted;
      ASSERT_EQ(last.jerk, 0.0) << c << wanted;
      arrival = count > 1 ? profile.segment(count - 2).end_time : 0.0;
    }
    expect_the_fastest_change(c, target, profile, arrival);
    if (target == 0.0) expect_rest_at(c, profile, profile.end_position());
    if (HasFatalFailure()) return;
  }
}

TEST_P(JerkPlans, StopInTheShortestTime) {
  const std::uint64_t cases =
      share_of({.usual = 100'000, .full = 1'000'000, .nightly = 100'000'000});
  Random random = JerkPlans::random(0x73746F70U);
  for (std::uint64_t i = 0; i < cases; ++i) {
    JerkCase c = random_jerk_case(random);
    c.limits.acceleration = c.limits.deceleration;
    const JerkProfile profile = plan_jerk_stop(c.start, c.limits.deceleration, c.jerk);
    expect_the_fastest_change(c, 0.0, profile, profile.duration());
    expect_rest_at(c, profile, profile.end_position());
    if (HasFatalFailure()) return;
  }
}

TEST(JerkProfileProperty, EndsExactlyWithAnyValuesOfTheRegisters) {
  Random random(0x72656773U);
  const auto cases = number_if_optimised<std::uint64_t>(
      {.usual = 50'000, .full = 1'000'000, .nightly = 10'000'000}, 5'000);
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

TEST(JerkProfileProperty, DoesNotAllocate) {
  Random random(0x616C6C6FU);
  std::uint64_t allocations = 0;
  double sum = 0.0;
  for (int i = 0; i < 1'000; ++i) {
    const JerkCase c = random_jerk_case(random);
    const MoveTimes times{.duration = 2.0, .acceleration = 0.6, .deceleration = 0.8, .jerk = 0.1};
    const test::AllocationGuard guard;
    sum += plan_of(c).at(0.1).position;
    sum += plan_jerk_velocity(c.start, c.limits.velocity, c.limits, c.jerk).at(0.1).position;
    sum += plan_jerk_stop(c.start, c.limits.deceleration, c.jerk).at(0.1).position;
    sum += plan_timed_jerk_move(c.start.position, c.target, times).at(0.1).position;
    allocations += guard.count();
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

// ---- the duration ------------------------------------------------------------------------------

TEST(JerkOracle, HasTheTimesThatAreWorkedByHand) {
  // See JerkProfile.TurnsWithTheSmallerAccelerationOfBothRamps: slowing down with 50 units/s²,
  // speeding up with 200, 1000 units/s³.
  const MotionLimits limits{.velocity = 100.0, .acceleration = 200.0, .deceleration = 50.0};
  const MotionJerk jerk{.acceleration = 1000.0, .deceleration = 1000.0};
  const ExactPath turn = fastest_change({.velocity = -100.0L}, 100.0L, limits, jerk);
  EXPECT_NEAR(static_cast<double>(turn.duration()), 0.05 + 1.975 + 0.15 + 0.30625 + 0.2, 1.0e-12);

  // 200 units/s² lead from 95 to 115 units/s in 0.2 s; going down by 15 units/s takes two phases of
  // √(15/1000) s.
  const ExactPath back =
      fastest_change({.velocity = 95.0L, .acceleration = 200.0L}, 100.0L,
                     {.velocity = 100.0, .acceleration = 200.0, .deceleration = 200.0}, jerk);
  EXPECT_NEAR(static_cast<double>(back.duration()), 0.2 + 2.0 * std::sqrt(0.015), 1.0e-12);

  // The textbook case: 0.7 s and 35 units for each ramp, 30 units at 100 units/s.
  const MotionLimits equal{.velocity = 100.0, .acceleration = 200.0, .deceleration = 200.0};
  EXPECT_NEAR(static_cast<double>(test::fastest_move({}, 100.0L, equal, jerk)), 1.7, 1.0e-12);
  // Four phases of T with 2·J·T³ = 2 units.
  EXPECT_NEAR(static_cast<double>(test::fastest_move({}, -2.0L, equal, jerk)), 0.4, 1.0e-12);
}

TEST(JerkProfileProperty, TakesTheTimeOfTheFastestPushAndStop) {
  const auto cases = number_if_optimised<std::uint64_t>(
      {.usual = 2'000, .full = 100'000, .nightly = 1'000'000}, 100);
  Random random(0x74696D65U);
  for (std::uint64_t i = 0; i < cases; ++i) {
    JerkCase c;
    c.limits.velocity = log_uniform(random, 10.0, 1.0e4);
    c.limits.acceleration = log_uniform(random, 1.0e2, 1.0e5);
    c.limits.deceleration =
        random.one_in(3) ? c.limits.acceleration : log_uniform(random, 1.0e2, 1.0e5);
    c.jerk.acceleration = log_uniform(random, 1.0e3, 1.0e6);
    c.jerk.deceleration = c.jerk.acceleration;
    // The start may be outside the limits.
    const double highest = std::max(c.limits.acceleration, c.limits.deceleration);
    c.start.velocity = signed_unit(random) * c.limits.velocity * (random.one_in(4) ? 2.0 : 1.0);
    c.start.acceleration = signed_unit(random) * highest * (random.one_in(4) ? 2.0 : 1.0);
    // No target is closer than 0.01 to the end of the stop: there a position error costs a time
    // that grows with its cube root, and the end of the stop is itself rounded.
    const ExactState start = exact_start(c);
    const ExactPath stop = fastest_change(start, 0.0L, c.limits, c.jerk);
    const double beyond = (random.one_in(2) ? 1.0 : -1.0) * log_uniform(random, 1.0e-2, 1.0e5);
    c.target = static_cast<double>(stop.end().way) + beyond;
    const auto expected = static_cast<double>(
        test::fastest_move(start, static_cast<long double>(c.target), c.limits, c.jerk));
    ASSERT_TRUE(std::isfinite(expected)) << c;
    ASSERT_NEAR(plan_of(c).duration(), expected, 1.0e-7 * expected) << c;
  }
}

/// The beginning of a detour: for some time towards some velocity, within the limits.
MotionSample after_a_detour(const JerkCase& c, const MotionSample& start, double time,
                            Random& random) {
  const double velocity = signed_unit(random) * (random.one_in(2) ? 1.0 : 2.0);
  return plan_jerk_velocity(start, velocity * c.limits.velocity, c.limits, c.jerk).at(time);
}

/// The same towards a velocity ahead in `direction`: the acceleration in that direction stays >= 0.
MotionSample after_a_hesitation(const JerkCase& c, const MotionSample& start, double direction,
                                double time, Random& random) {
  const double settled = settled_speed(start, c.jerk, direction);
  const double velocity = settled + random.unit() * (c.limits.velocity - settled);
  return plan_jerk_velocity(start, direction * velocity, c.limits, c.jerk).at(time);
}

/// The time that rounding may cost: a target that it moved by δ costs a detour of about
/// (δ/J)^(1/3).
double rounding_of_time(const JerkCase& c, const JerkProfile& direct) {
  const JerkTolerance slack = tolerance_of_plan(c, direct);
  const double jerk = std::min(c.jerk.acceleration, c.jerk.deceleration);
  return 16.0 * std::cbrt(64.0 * slack.position / jerk) +
         16.0 * std::sqrt(64.0 * slack.velocity / jerk) + 1.0e-9 * direct.duration();
}

/// Calls `turn` once or twice with the time of a detour. @return the sum of the times.
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

// Whatever an axis does first within its limits, the fastest motion from there does not reach the
// target earlier. This also holds for different ramps, and for starts outside the limits.
TEST(JerkProfileProperty, IsNotSlowerThanADetour) {
  const auto cases = number_if_optimised<std::uint64_t>(
      {.usual = 50'000, .full = 500'000, .nightly = 20'000'000}, 3'000);
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

/// @return whether the motion can keep all limits from here on: the acceleration is within its
///         bounds, also after v = 0 if it cannot be reduced before, and does not force the velocity
///         over V.
/// @param side of v = 0 on which the state is, 1 or -1
bool can_keep_its_limits(const JerkCase& c, const MotionSample& state, double side) {
  const double along = side * state.acceleration;
  const double steady = std::min(c.limits.acceleration, c.limits.deceleration);
  const double least = 0.5 * along * along - std::abs(state.velocity) * c.jerk.deceleration;
  const double direction = state.acceleration < 0.0 ? -1.0 : 1.0;
  return along <= c.limits.acceleration && -along <= c.limits.deceleration &&
         (along >= 0.0 || least <= 0.5 * steady * steady) &&
         settled_speed(state, c.jerk, direction) <= c.limits.velocity &&
         std::abs(state.velocity) <= c.limits.velocity;
}

/// @return whether a motion with this jerk keeps all limits for `time`.
bool keeps_its_limits(const JerkCase& c, const JerkSegment& segment, double time) {
  const Parts parts(segment, 0.0, time);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const MotionSample middle = sample(segment, 0.5 * (parts.begin(i) + parts.end(i)));
    const double side = middle.velocity < 0.0 ? -1.0 : 1.0;
    for (const double instant : {parts.begin(i), parts.end(i)}) {
      if (!can_keep_its_limits(c, sample(segment, instant), side)) return false;
    }
  }
  return true;
}

// Sequences of {+J, 0, -J} of any durations before a plan: none of them reaches the target earlier.
TEST(JerkProfileProperty, IsNotSlowerThanAnySequenceOfJerksBefore) {
  const auto cases = number_if_optimised<std::uint64_t>(
      {.usual = 50'000, .full = 500'000, .nightly = 20'000'000}, 3'000);
  Random random(0x73657175U);
  std::uint64_t jerks = 0;
  for (std::uint64_t i = 0; i < cases; ++i) {
    JerkCase c = random_jerk_case(random);
    c.jerk.deceleration = c.jerk.acceleration;
    const double side = c.start.velocity < 0.0 ? -1.0 : 1.0;
    if (!can_keep_its_limits(c, c.start, side)) c.start = {.position = c.start.position};
    const JerkProfile direct = plan_of(c);
    JerkCase rest = c;
    double spent = 0.0;
    for (std::uint64_t left = 1 + random.below(5); left > 0; --left) {
      const double sign = static_cast<double>(random.below(3)) - 1.0;
      const JerkSegment segment{.position = rest.start.position,
                                .velocity = rest.start.velocity,
                                .acceleration = rest.start.acceleration,
                                .jerk = sign * c.jerk.acceleration};
      double time = 0.7 * direct.duration() * random.unit() * random.unit();
      int halvings = 0;
      while (!keeps_its_limits(c, segment, time) && halvings < 12) {
        time *= 0.5;
        ++halvings;
      }
      if (halvings == 12) continue;
      rest.start = sample(segment, time);
      spent += time;
      ++jerks;
    }
    ASSERT_GE(spent + plan_of(rest).duration(), direct.duration() - rounding_of_time(c, direct))
        << c << rest;
  }
  EXPECT_GE(jerks, cases);
}

// With two jerks, a plan is the fastest only among motions that never go backwards. Others may be
// earlier: from rest, building up 1 unit/s² takes 1 s with 1 unit/s³. If speeds are reduced with
// 100 units/s³, moving backwards for 0.2 s (0.1 s down to -0.1 units/s² and as long back to 0:
// -0.01 units/s) and braking for √(2·0.01/100) s ends at rest with √(2·100·0.01) = 1.41 units/s².
TEST(JerkProfileProperty, IsNotSlowerThanAHesitationWithTwoJerks) {
  const auto cases = number_if_optimised<std::uint64_t>(
      {.usual = 50'000, .full = 500'000, .nightly = 20'000'000}, 3'000);
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
    if (direction_of(rest) != direction) continue;  // too far: the motion comes back to the target
    ++compared;
    ASSERT_GE(spent + plan_of(rest).duration(), direct.duration() - rounding_of_time(c, direct))
        << c << rest;
  }
  EXPECT_GE(compared, cases / 2);
}

}  // namespace
}  // namespace vdrive
