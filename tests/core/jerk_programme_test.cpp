// SPDX-License-Identifier: Apache-2.0
// Checks the duration of plans with limited jerk by linear programmes: how far can an axis get in
// the duration of a plan and be at rest at its end? While the sign of the velocity is known, each
// limit is linear in position, velocity, acceleration and jerk. So for each pattern of signs, and
// the instants at which they change, finding the farthest motion whose jerk is constant in each
// step of a grid is a linear programme.
//
// An axis at rest can wait, so the farthest end grows with the time, and a plan is the fastest one
// if no motion gets farther than its target in its duration.
//
// The motions of a programme keep every limit, also between the instants of the grid. So the plan
// is wrong if one of them gets farther than the target. The grid contains the instants of the plan,
// so the plan itself is one of them. This is exact.
//
// The rows of the programme say α·v + β·a <= b at an instant t. With their prices y >= 0, weak
// duality also bounds motions that do not fit the grid. For any motion x with jerk j(t),
//   d·x(T) <= Σ y·b + ∫ j(t)·p(t) dt <= Σ y·b + ∫ J·|p(t)| dt,
//   p(t) = d·(T - t)²/2 - Σ over t_k > t of y_k·(α_k·(t_k - t) + β_k).
// Such a motion may violate one kind of row: v + a·h/2, which bounds the velocity within a step, by
// at most J·h²/8, because v(t + h/2) >= v + a·h/2 - J·h²/8 and the limit holds there. So y·J·h²/8
// is added for these rows. The sum, MotionProgramme::reach_of_any, is not an estimate: no motion of
// this pattern and these instants gets farther. Its excess over the target falls with h².
#include "core/support/linear_programme.hpp"
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
#include <vector>

namespace vdrive {
namespace {

using test::LinearProgramme;
using test::Random;

/// A part of a motion in which the velocity keeps its sign.
struct Stretch {
  double direction = 1.0;  ///< of the velocity, 1 or -1
  double ramp = 0.0;       ///< 1 speeds up, -1 slows down, 0 allows both
  double jerk = 1.0;
  std::vector<double> steps;  ///< [s]
};

/// velocity·v + acceleration·a <= most at an instant of the grid.
struct GridBound {
  std::size_t instant = 0;
  double velocity = 0.0;
  double acceleration = 0.0;
  double most = 0.0;
  double broken_between = 0.0;  ///< by how much a motion that keeps every limit may exceed it
};

/// @return the integral over `length` of |p|, p quadratic with these values at begin, middle, end.
double integral_of_absolute(double begin, double middle, double end, double length) {
  const double square = 2.0 * (begin - 2.0 * middle + end);
  const double slope = end - begin - square;
  const auto integral_to = [&](double s) {
    return ((square / 3.0 * s + slope / 2.0) * s + begin) * s;
  };
  std::array<double, 4> borders{0.0, 0.0, 0.0, 1.0};
  const double discriminant = slope * slope - 4.0 * square * begin;
  if (discriminant >= 0.0) {
    // This form avoids a difference of almost equal numbers; an infinite root is cut off.
    const double q = -0.5 * (slope + (slope < 0.0 ? -1.0 : 1.0) * std::sqrt(discriminant));
    const auto inside = [](double root) {
      return root > 0.0 && root < 1.0 ? root : 0.0;
    };
    borders[1] = square != 0.0 ? inside(q / square) : 0.0;
    borders[2] = q != 0.0 ? inside(begin / q) : 0.0;
    if (borders[1] > borders[2]) std::swap(borders[1], borders[2]);
  }
  double sum = 0.0;
  for (std::size_t i = 1; i < borders.size(); ++i) {
    sum += std::abs(integral_to(borders[i]) - integral_to(borders[i - 1]));
  }
  return sum * length;
}

/// The farthest motion to rest over given stretches. The variable of a step is its share of the
/// jerk of its stretch, from -1 to 1.
class MotionProgramme {
 public:
  /// @param direction in which distance counts, 1 or -1
  MotionProgramme(const MotionSample& start, const MotionLimits& limits,
                  const std::vector<Stretch>& stretches, double direction)
      : start_(start), limits_(limits), direction_(direction) {
    lay_grid(stretches);
    add_bounds(stretches);
    solve();
  }

  /// @return whether a motion was found; otherwise see is_impossible.
  [[nodiscard]] bool is_solved() const {
    return is_possible_ && solution_.end == LinearProgramme::End::optimal;
  }

  /// @return whether it is proven that no motion keeps these bounds.
  [[nodiscard]] bool is_impossible() const {
    if (!is_possible_) return true;
    return solution_.end == LinearProgramme::End::infeasible &&
           programme_.proof_of_none(solution_.prices) < 0.0;
  }

  /// @return the distance of the motion that was found. @pre is_solved(), also for all below
  [[nodiscard]] double reach() const {
    return at_no_jerk() + programme_.value(solution_.variables);
  }

  /// @return by how much that motion violates a bound; rounding only.
  [[nodiscard]] double breach() const { return programme_.breach(solution_.variables); }

  /// @return a distance that no motion on this grid exceeds.
  [[nodiscard]] double ceiling() const {
    return at_no_jerk() + programme_.ceiling(solution_.prices);
  }

  /// @return a distance that no motion over these stretches exceeds, whatever its jerk in a step.
  [[nodiscard]] double reach_of_any() const {
    double sum = at_no_jerk();
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      const GridBound& bound = bounds_[i];
      sum += solution_.prices[i] * (bound.most - value_at_no_jerk(bound) + bound.broken_between);
    }
    // p(t) = direction·(T - t)²/2 - (moment - weight·t), whose coefficients change at the instants.
    double weight = 0.0;
    double moment = 0.0;
    for (std::size_t step = jerks_.size(); step-- > 0;) {
      for (std::size_t i = 0; i < bounds_.size(); ++i) {
        if (bounds_[i].instant != step + 1) continue;
        const double velocity = solution_.prices[i] * bounds_[i].velocity;
        weight += velocity;
        moment += velocity * instants_[step + 1] + solution_.prices[i] * bounds_[i].acceleration;
      }
      const auto p = [&](double time) {
        const double left = instants_.back() - time;
        return direction_ * left * left / 2.0 - (moment - weight * time);
      };
      const double begin = instants_[step];
      const double end = instants_[step + 1];
      sum += jerks_[step] *
             integral_of_absolute(p(begin), p((begin + end) / 2.0), p(end), end - begin);
    }
    return sum;
  }

 private:
  void solve() {
    if (!is_possible_) return;
    programme_ = LinearProgramme(objective());
    for (const GridBound& bound : bounds_) {
      programme_.add(row_of(bound), bound.most - value_at_no_jerk(bound));
    }
    solution_ = programme_.solve();
  }

  void lay_grid(const std::vector<Stretch>& stretches) {
    instants_.push_back(0.0);
    for (const Stretch& stretch : stretches) {
      for (const double step : stretch.steps) {
        instants_.push_back(instants_.back() + step);
        jerks_.push_back(stretch.jerk);
      }
    }
  }

  /// Where two stretches meet, the bounds of both hold. If their directions differ, the velocity is
  /// 0 there, and the acceleration is at most the smaller one of both ramps. If only their ramps
  /// differ, the acceleration is 0.
  void add_bounds(const std::vector<Stretch>& stretches) {
    std::size_t instant = 0;
    for (const Stretch& stretch : stretches) {
      for (const double step : stretch.steps) {
        add_state(stretch, instant);
        // The velocity within a step lies between the smallest and the largest of three values:
        // at its two ends, and v + a·step/2, which is bounded here.
        const double side = stretch.direction;
        const double broken = stretch.jerk * step * step / 8.0;
        add({instant, side, side * step / 2.0, limits_.velocity, broken});
        add({instant, -side, -side * step / 2.0, 0.0, broken});
        ++instant;
      }
      add_state(stretch, instant);
    }
    for (const double side : {1.0, -1.0}) {
      add({instant, side, 0.0, 0.0, 0.0});
      add({instant, 0.0, side, 0.0, 0.0});
    }
  }

  void add_state(const Stretch& stretch, std::size_t instant) {
    const double side = stretch.direction;
    add({instant, side, 0.0, limits_.velocity, 0.0});
    add({instant, -side, 0.0, 0.0, 0.0});
    add({instant, 0.0, side, stretch.ramp < 0.0 ? 0.0 : limits_.acceleration, 0.0});
    add({instant, 0.0, -side, stretch.ramp > 0.0 ? 0.0 : limits_.deceleration, 0.0});
  }

  /// No variable changes the start: a bound either holds there or it does not.
  void add(const GridBound& bound) {
    constexpr double kRounding = 1.0e-12;
    if (bound.instant > 0) {
      bounds_.push_back(bound);
    } else if (value_at_no_jerk(bound) > bound.most + kRounding) {
      is_possible_ = false;
    }
  }

  [[nodiscard]] double at_no_jerk() const {
    const double end = instants_.back();
    return direction_ * (start_.velocity + start_.acceleration / 2.0 * end) * end;
  }

  [[nodiscard]] double value_at_no_jerk(const GridBound& bound) const {
    const double velocity = start_.velocity + start_.acceleration * instants_[bound.instant];
    return bound.velocity * velocity + bound.acceleration * start_.acceleration;
  }

  /// A jerk in [t, t + h] adds h to each later acceleration, h·(time since the middle) to each
  /// later velocity, and the integral of (T - t)²/2 to the end.
  [[nodiscard]] std::vector<double> objective() const {
    std::vector<double> factors(jerks_.size());
    for (std::size_t step = 0; step < factors.size(); ++step) {
      const double length = instants_[step + 1] - instants_[step];
      const double left = instants_.back() - (instants_[step] + length / 2.0);
      factors[step] =
          direction_ * jerks_[step] * length / 2.0 * (left * left + length * length / 12.0);
    }
    return factors;
  }

  [[nodiscard]] std::vector<double> row_of(const GridBound& bound) const {
    std::vector<double> factors(jerks_.size(), 0.0);
    for (std::size_t step = 0; step < bound.instant; ++step) {
      const double length = instants_[step + 1] - instants_[step];
      const double since = instants_[bound.instant] - (instants_[step] + length / 2.0);
      factors[step] = jerks_[step] * length * (bound.velocity * since + bound.acceleration);
    }
    return factors;
  }

  MotionSample start_;
  MotionLimits limits_;
  double direction_;
  bool is_possible_ = true;
  std::vector<double> instants_;
  std::vector<double> jerks_;
  std::vector<GridBound> bounds_;
  LinearProgramme programme_{std::vector<double>{}};
  LinearProgramme::Solution solution_;
};

// ---- the checker -------------------------------------------------------------------------------

TEST(LinearProgramme, FindsTheCornerThatIsWorkedByHand) {
  // x + 2y with x + y <= 1 and 2y - 2x <= 1: the lines meet at x = 0.25, y = 0.75, which gives
  // 1.75. The prices solve p - 2q = 1, p + 2q = 2.
  LinearProgramme sut({1.0, 2.0});
  sut.add({1.0, 1.0}, 1.0);
  sut.add({-2.0, 2.0}, 1.0);
  const LinearProgramme::Solution solution = sut.solve();
  ASSERT_EQ(solution.end, LinearProgramme::End::optimal);
  EXPECT_NEAR(solution.variables[0], 0.25, 1.0e-12);
  EXPECT_NEAR(solution.variables[1], 0.75, 1.0e-12);
  EXPECT_NEAR(solution.prices[0], 1.5, 1.0e-12);
  EXPECT_NEAR(solution.prices[1], 0.25, 1.0e-12);
  EXPECT_NEAR(sut.ceiling(solution.prices), 1.75, 1.0e-12);
  EXPECT_LE(sut.breach(solution.variables), 1.0e-12);
}

TEST(LinearProgramme, ProvesThatNoPointKeepsBoundsWhichContradictEachOther) {
  LinearProgramme sut({1.0, 1.0});
  sut.add({1.0, 1.0}, -0.5);
  sut.add({-1.0, -1.0}, 0.25);
  const LinearProgramme::Solution solution = sut.solve();
  ASSERT_EQ(solution.end, LinearProgramme::End::infeasible);
  EXPECT_NEAR(sut.proof_of_none(solution.prices), -0.25, 1.0e-12);
}

/// One stretch of equal steps.
std::vector<Stretch> forward_in(double time, std::size_t steps) {
  Stretch stretch;
  stretch.steps.assign(steps, time / static_cast<double>(steps));
  return {stretch};
}

TEST(MotionProgramme, FindsTheTextbookMove) {
  // By the jerk alone, 1 unit/s³ for 4 s: 2·J·1³ = 2 units. With 0.5 units/s² and 0.75 units/s: two
  // ramps of 0.75/0.5 + 0.5 = 2 s and 0.75 units each. The instants lie on the grid.
  const MotionLimits wide{.velocity = 9.0, .acceleration = 9.0, .deceleration = 9.0};
  const MotionProgramme by_jerk({}, wide, forward_in(4.0, 16), 1.0);
  ASSERT_TRUE(by_jerk.is_solved());
  EXPECT_NEAR(by_jerk.reach(), 2.0, 1.0e-9);
  EXPECT_NEAR(by_jerk.ceiling(), 2.0, 1.0e-9);

  const MotionLimits limits{.velocity = 0.75, .acceleration = 0.5, .deceleration = 0.5};
  const MotionProgramme limited({}, limits, forward_in(4.0, 16), 1.0);
  ASSERT_TRUE(limited.is_solved());
  EXPECT_NEAR(limited.reach(), 1.5, 1.0e-9);

  // 1 % more time makes a difference: 2·1.01³ units.
  const MotionProgramme longer({}, wide, forward_in(4.04, 16), 1.0);
  ASSERT_TRUE(longer.is_solved());
  EXPECT_NEAR(longer.reach(), 2.060602, 1.0e-9);
}

TEST(MotionProgramme, BoundsMotionsOffTheGridToo) {
  // With three steps the jerk cannot change after a quarter of the time. The distance that no
  // motion exceeds is still 2 units.
  const MotionLimits wide{.velocity = 9.0, .acceleration = 9.0, .deceleration = 9.0};
  const MotionProgramme coarse({}, wide, forward_in(4.0, 3), 1.0);
  ASSERT_TRUE(coarse.is_solved());
  EXPECT_LT(coarse.reach(), 1.99);
  EXPECT_GE(coarse.reach_of_any(), 2.0 - 1.0e-9);
  // The excess falls at least with the square of the step.
  const MotionProgramme finer({}, wide, forward_in(4.0, 18), 1.0);
  const MotionProgramme finest({}, wide, forward_in(4.0, 54), 1.0);
  EXPECT_LT(finest.reach_of_any() - 2.0, (finer.reach_of_any() - 2.0) / 4.0);
}

TEST(MotionProgramme, KnowsThatAnAxisCannotStopAtOnce) {
  const MotionLimits limits{.velocity = 1.0, .acceleration = 0.5, .deceleration = 0.5};
  const MotionProgramme sut({0.0, 1.0, 0.0}, limits, forward_in(1.0, 8), 1.0);
  EXPECT_FALSE(sut.is_solved());
  EXPECT_TRUE(sut.is_impossible());
}

// ---- plans --------------------------------------------------------------------------------------

/// A move from position 0 with about 1 unit/s³, whose ramps take a few seconds.
struct JudgedMove {
  MotionSample start;
  MotionLimits limits;
  MotionJerk jerk;
  double target = 0.0;
  double direction = 1.0;  ///< from the end of the fastest stop to the target
  JerkProfile plan;
};

std::ostream& operator<<(std::ostream& out, const JudgedMove& m) {
  return out << std::setprecision(17) << "start {0, " << m.start.velocity << ", "
             << m.start.acceleration << "}, target " << m.target << ", limits {"
             << m.limits.velocity << ", " << m.limits.acceleration << ", " << m.limits.deceleration
             << "}, jerk {" << m.jerk.acceleration << ", " << m.jerk.deceleration << "}, planned "
             << m.plan.duration();
}

double between(Random& random, double low, double high) {
  return low * std::pow(high / low, random.unit());
}

/// @return the velocity once the acceleration of the start has been reduced to 0, for a start that
///         does not turn before that.
double velocity_without_acceleration(const JudgedMove& m) {
  const double jerk =
      m.start.velocity * m.start.acceleration < 0.0 ? m.jerk.deceleration : m.jerk.acceleration;
  const double change = m.start.acceleration * m.start.acceleration / (2.0 * jerk);
  return m.start.velocity + (m.start.acceleration < 0.0 ? -change : change);
}

/// @return a move of at most 4 s whose start is within its limits and does not lead out of them.
JudgedMove random_move(Random& random, bool has_two_jerks) {
  constexpr double kLongest = 4.0;
  for (;;) {
    JudgedMove m;
    m.limits.velocity = between(random, 0.05, 1.0);
    m.limits.acceleration = between(random, 0.2, 1.0);
    m.limits.deceleration = random.one_in(3) ? m.limits.acceleration : between(random, 0.2, 1.0);
    m.jerk = {1.0, has_two_jerks ? between(random, 0.4, 2.5) : 1.0};
    const double lower = std::min(m.limits.acceleration, m.limits.deceleration);
    if (!random.one_in(3)) m.start.velocity = (2.0 * random.unit() - 1.0) * m.limits.velocity;
    if (!random.one_in(3)) m.start.acceleration = (2.0 * random.unit() - 1.0) * lower;
    if (std::abs(velocity_without_acceleration(m)) > m.limits.velocity) continue;
    const double rest = plan_jerk_velocity(m.start, 0.0, m.limits, m.jerk).end_position();
    m.direction = random.one_in(2) ? 1.0 : -1.0;
    m.target = rest + m.direction * between(random, 1.0e-3, 2.0);
    m.plan = plan_jerk_move(m.start, m.target, m.limits, m.jerk);
    if (m.plan.duration() <= kLongest) return m;
  }
}

/// The instants of a grid. An instant is added only if none is closer than the given share of the
/// total time.
class Instants {
 public:
  explicit Instants(double end) : end_(end), times_{0.0, end} {}

  void add(double time, double apart) {
    const bool is_free = std::none_of(times_.begin(), times_.end(), [&](double other) {
      return std::abs(time - other) < apart * end_;
    });
    if (is_free && time > 0.0 && time < end_) times_.push_back(time);
  }

  [[nodiscard]] std::vector<double> sorted() const {
    std::vector<double> times = times_;
    std::sort(times.begin(), times.end());
    return times;
  }

 private:
  double end_;
  std::vector<double> times_;
};

/// @return the instants at which the velocity and the acceleration of the segment would be 0.
std::vector<double> zeros_of(const JerkSegment& segment) {
  std::vector<double> zeros;
  if (segment.jerk == 0.0) {
    if (segment.acceleration != 0.0) zeros.push_back(-segment.velocity / segment.acceleration);
  } else {
    const double middle = -segment.acceleration / segment.jerk;
    const double square = middle * middle - 2.0 * segment.velocity / segment.jerk;
    zeros.push_back(middle);
    if (square > 0.0) {
      zeros.push_back(middle - std::sqrt(square));
      zeros.push_back(middle + std::sqrt(square));
    }
  }
  for (double& time : zeros) time += segment.reference_time;
  return zeros;
}

/// @return a grid with the instants at which the jerk of the plan changes, and those at which its
///         velocity or acceleration is 0: in each step both keep their signs, so the plan keeps the
///         bounds within the steps, too.
std::vector<double> grid_of(const JerkProfile& plan, std::size_t steps) {
  constexpr double kSame = 1.0e-9;
  // Next to an end at rest the velocity is 0 up to rounding, so its zeros mean nothing.
  constexpr double kBesideAnEnd = 1.0e-6;
  constexpr double kUseless = 1.0e-3;
  const double end = plan.duration();
  Instants instants(end);
  for (std::size_t i = 0; i < plan.segment_count(); ++i) {
    instants.add(plan.segment(i).end_time, kSame);
  }
  double begin = 0.0;
  for (std::size_t i = 0; i < plan.segment_count(); ++i) {
    for (const double zero : zeros_of(plan.segment(i))) {
      const bool is_inside = zero > begin && zero < plan.segment(i).end_time;
      const bool is_far = zero > kBesideAnEnd * end && zero < (1.0 - kBesideAnEnd) * end;
      if (is_inside && is_far) instants.add(zero, kSame);
    }
    begin = plan.segment(i).end_time;
  }
  for (std::size_t k = 1; k < steps; ++k) {
    instants.add(end * static_cast<double>(k) / static_cast<double>(steps), kUseless);
  }
  return instants.sorted();
}

double jerk_of_ramp(const MotionJerk& jerk, double ramp) {
  return ramp < 0.0 ? jerk.deceleration : jerk.acceleration;
}

/// @return the stretches of the plan itself; with two jerks one stretch per ramp.
std::vector<Stretch> stretches_of(const JudgedMove& m, std::size_t steps) {
  const bool has_two_jerks = m.jerk.acceleration != m.jerk.deceleration;
  const std::vector<double> grid = grid_of(m.plan, steps);
  std::vector<Stretch> stretches;
  for (std::size_t k = 0; k + 1 < grid.size(); ++k) {
    const MotionSample now = m.plan.at((grid[k] + grid[k + 1]) / 2.0);
    const double direction = now.velocity < 0.0 ? -1.0 : 1.0;
    const double of_ramp = now.velocity * now.acceleration < 0.0 ? -1.0 : 1.0;
    const double ramp = has_two_jerks ? of_ramp : 0.0;
    const bool goes_on = !stretches.empty() && stretches.back().direction == direction &&
                         stretches.back().ramp == ramp;
    if (!goes_on) {
      stretches.push_back(
          {.direction = direction, .ramp = ramp, .jerk = jerk_of_ramp(m.jerk, ramp), .steps = {}});
    }
    stretches.back().steps.push_back(grid[k + 1] - grid[k]);
  }
  return stretches;
}

/// The rounding that is tolerated, as distance at full speed: 1e-7 of the time.
double rounding_of(const JudgedMove& m) {
  return 1.0e-7 * m.limits.velocity * m.plan.duration();
}

/// Totals over all moves of a test.
struct Judged {
  double hidden = 0.0;       ///< excess of the bounds over the targets, in full-speed distances
  std::size_t solved = 0;    ///< programmes of other stretches that have a motion
  std::size_t unproven = 0;  ///< those that ended without a proof either way
};

/// Expects that no motion over the stretches of the plan gets farther in the time of the plan,
/// which fits the grid.
void expect_the_farthest_of_its_pattern(const JudgedMove& m, Judged& sum) {
  constexpr std::size_t kSteps = 48;
  const MotionProgramme programme(m.start, m.limits, stretches_of(m, kSteps), m.direction);
  ASSERT_TRUE(programme.is_solved()) << m;
  const double way = m.direction * m.target;
  ASSERT_LE(programme.breach(), 1.0e-9) << m;
  ASSERT_GE(programme.reach(), way - rounding_of(m)) << m << ": the plan breaks a limit";
  ASSERT_LE(programme.ceiling(), way + rounding_of(m)) << m << ": it could be faster";
  ASSERT_GE(programme.reach_of_any(), way - rounding_of(m)) << m;
  sum.hidden += (programme.reach_of_any() - way) / (m.limits.velocity * m.plan.duration());
}

/// Signs of velocity and ramp of successive stretches.
using Pattern = std::vector<std::pair<double, double>>;

/// Up to three alternating signs of the velocity. The first is that of the start; from rest it is
/// either.
std::vector<Pattern> patterns_of_signs(const MotionSample& start) {
  std::vector<Pattern> patterns;
  for (const double first : {1.0, -1.0}) {
    if (first * start.velocity < 0.0) continue;
    patterns.push_back({{first, 0.0}});
    patterns.push_back({{first, 0.0}, {-first, 0.0}});
    patterns.push_back({{first, 0.0}, {-first, 0.0}, {first, 0.0}});
  }
  return patterns;
}

/// Up to four successive ramps without a change of direction.
std::vector<Pattern> patterns_of_ramps(const JudgedMove& m) {
  const double d = m.direction;
  std::vector<Pattern> patterns;
  if (d * m.start.acceleration >= 0.0) {
    patterns.push_back({{d, 1.0}, {d, -1.0}});
    patterns.push_back({{d, 1.0}, {d, -1.0}, {d, 1.0}, {d, -1.0}});
  }
  if (d * m.start.acceleration <= 0.0) {
    patterns.push_back({{d, -1.0}, {d, 1.0}, {d, -1.0}});
  }
  return patterns;
}

/// Shares of the time at which the stretches of a pattern meet, in increasing order within (0, 1).
using Cuts = std::vector<double>;

std::vector<Stretch> stretches_of(const JudgedMove& m, const Pattern& pattern, const Cuts& cuts) {
  constexpr double kSteps = 24.0;
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const double begin = i == 0 ? 0.0 : cuts[i - 1];
    const double end = i == cuts.size() ? 1.0 : cuts[i];
    const auto steps =
        static_cast<std::size_t>(std::max(2.0, std::nearbyint((end - begin) * kSteps)));
    const double step = (end - begin) * m.plan.duration() / static_cast<double>(steps);
    stretches.push_back({.direction = pattern[i].first,
                         .ramp = pattern[i].second,
                         .jerk = jerk_of_ramp(m.jerk, pattern[i].second),
                         .steps = std::vector<double>(steps, step)});
  }
  return stretches;
}

/// Searches for the farthest motion with other patterns and instants than those of the plan.
class Search {
 public:
  explicit Search(const JudgedMove& m) : move_(m) {}

  /// Tries every division of the time into `kParts`, then finer ones around the best.
  void try_pattern(const Pattern& pattern) {
    best_ = -std::numeric_limits<double>::infinity();
    std::vector<std::size_t> parts(pattern.size() - 1);
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = i + 1;
    do {
      Cuts cuts(parts.size());
      std::transform(parts.begin(), parts.end(), cuts.begin(), [](std::size_t part) {
        return static_cast<double>(part) / static_cast<double>(kParts);
      });
      try_cuts(pattern, cuts);
    } while (to_next(parts));
    if (!std::isinf(best_)) refine(pattern);
  }

  [[nodiscard]] std::size_t solved() const { return solved_; }

  [[nodiscard]] std::size_t unproven() const { return unproven_; }

 private:
  static constexpr std::size_t kParts = 10;

  /// The next choice of increasing numbers below kParts. @return false after the last one
  static bool to_next(std::vector<std::size_t>& parts) {
    for (std::size_t i = parts.size(); i-- > 0;) {
      if (parts[i] + (parts.size() - i) >= kParts) continue;
      ++parts[i];
      for (std::size_t k = i + 1; k < parts.size(); ++k) parts[k] = parts[k - 1] + 1;
      return true;
    }
    return false;
  }

  void refine(const Pattern& pattern) {
    double width = 0.5 / static_cast<double>(kParts);
    for (int halving = 0; halving < 3; ++halving) {
      for (std::size_t i = 0; i < best_cuts_.size(); ++i) {
        for (const double side : {width, -width}) {
          Cuts cuts = best_cuts_;
          cuts[i] += side;
          const double before = i == 0 ? 0.0 : cuts[i - 1];
          const double after = i + 1 == cuts.size() ? 1.0 : cuts[i + 1];
          if (cuts[i] > before && cuts[i] < after) try_cuts(pattern, cuts);
        }
      }
      width /= 2.0;
    }
  }

  void try_cuts(const Pattern& pattern, const Cuts& cuts) {
    const MotionProgramme programme(move_.start, move_.limits, stretches_of(move_, pattern, cuts),
                                    move_.direction);
    if (!programme.is_solved()) {
      if (!programme.is_impossible()) ++unproven_;
      return;
    }
    ++solved_;
    if (programme.reach() > best_) {
      best_ = programme.reach();
      best_cuts_ = cuts;
    }
    EXPECT_LE(programme.ceiling(), move_.direction * move_.target + rounding_of(move_))
        << move_ << ": it could be faster with " << pattern.size() << " stretches that meet at "
        << testing::PrintToString(cuts);
  }

  const JudgedMove& move_;
  double best_ = 0.0;
  Cuts best_cuts_;
  std::size_t solved_ = 0;
  std::size_t unproven_ = 0;
};

std::uint64_t judged_moves() {
  return test::number_if_optimised<std::uint64_t>({.usual = 20, .full = 200, .nightly = 10'000}, 3);
}

void judge(const JudgedMove& m, const std::vector<Pattern>& patterns, Judged& sum) {
  expect_the_farthest_of_its_pattern(m, sum);
  Search search(m);
  for (const Pattern& pattern : patterns) search.try_pattern(pattern);
  sum.solved += search.solved();
  sum.unproven += search.unproven();
}

void expect_judged(const Judged& sum) {
  // With 48 steps about 0.5 % of the distance at full speed is usual; the most in 50 moves was 4 %.
  EXPECT_LE(sum.hidden, 0.03 * static_cast<double>(judged_moves()));
  EXPECT_GE(sum.solved, judged_moves());
  EXPECT_LE(sum.unproven, sum.solved / 100);
}

TEST(JerkProfileProgramme, NoMotionOfAnySignsOfTheVelocityGetsFartherInTheTimeOfAPlan) {
  Random random(0x6C696E70U);
  Judged sum;
  for (std::uint64_t i = 0; i < judged_moves() && !HasFailure(); ++i) {
    const JudgedMove m = random_move(random, false);
    judge(m, patterns_of_signs(m.start), sum);
  }
  expect_judged(sum);
}

TEST(JerkProfileProgramme, NoMotionThatKeepsItsDirectionGetsFartherWithTwoJerks) {
  Random random(0x32216C70U);
  Judged sum;
  for (std::uint64_t i = 0; i < judged_moves() && !HasFailure();) {
    const JudgedMove m = random_move(random, true);
    const double settled = m.direction * velocity_without_acceleration(m);
    if (m.direction * m.start.velocity < 0.0 || settled < 0.0) continue;
    judge(m, patterns_of_ramps(m), sum);
    ++i;
  }
  expect_judged(sum);
}

}  // namespace
}  // namespace vdrive
