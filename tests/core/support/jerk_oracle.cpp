// SPDX-License-Identifier: Apache-2.0
//
// With w = a²/2 the jerk is the slope of w over v while a > 0, and dt = dv/√(2w), so a larger w
// everywhere means a shorter time. On one side of v = 0 four lines bound w: R rises from the
// beginning with the jerk; E falls with the jerk to the value allowed at the end; C is the cap; F
// falls from the beginning, and no jerk can bring w below it. So w = max(F, min(R, E, C)).
#include "core/support/jerk_oracle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdrive::test {
namespace {

using Real = long double;

constexpr Real kEpsilon = std::numeric_limits<Real>::epsilon();

Real half_square_of(Real a) {
  return a * a / 2;
}

Real exact(double value) {
  return static_cast<Real>(value);
}

/// One side of v = 0 on the way to a higher velocity.
struct BoundedSide {
  Real begin = 0.0L;    // velocity
  Real end = 0.0L;      // velocity, >= begin
  Real w_begin = 0.0L;  // w with which the motion starts
  Real w_end = 0.0L;    // w allowed at the end
  Real w_cap = 0.0L;
  Real jerk = 0.0L;

  /// @return w at a velocity. A w that differs from the cap only by rounding (such as the rounding
  ///         error of the velocity times the jerk) counts as the cap.
  [[nodiscard]] Real w(Real velocity) const {
    const Real change = jerk * (velocity - begin);
    const Real most = std::min({w_begin + change, w_end + jerk * (end - velocity), w_cap});
    const Real w = std::max({w_begin - change, most, 0.0L});
    const Real rounding = 4 * kEpsilon * jerk * std::max(std::abs(begin), std::abs(end));
    return std::abs(w - w_cap) <= rounding + 64 * kEpsilon * w_cap ? w_cap : w;
  }

  /// The velocities at which two of the lines meet, in order from begin to end.
  [[nodiscard]] std::array<Real, 6> corners() const {
    const Real span = jerk * (end - begin);
    std::array<Real, 6> all{
        begin,
        begin + (w_end - w_begin + span) / (2 * jerk),  // R and E
        begin + (w_cap - w_begin) / jerk,               // R and C
        begin + (w_begin - w_cap) / jerk,               // F and C
        end - (w_cap - w_end) / jerk,                   // C and E
        end,
    };
    for (Real& velocity : all) velocity = std::min(std::max(velocity, begin), end);
    std::sort(all.begin(), all.end());
    return all;
  }
};

/// Follows the largest w along one side. @return w at its end.
Real follow(ExactPath& path, const BoundedSide& side, Real sign) {
  const std::array<Real, 6> corners = side.corners();
  Real w = side.w_begin;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Real span = corners[i] - corners[i - 1];
    if (!(span > 0)) continue;
    const Real next = side.w(corners[i]);
    const Real from = std::sqrt(2 * w);
    const Real to = std::sqrt(2 * next);
    if (from + to > 0) {  // else the span is below one digit of the velocity
      const Real time = 2 * span / (from + to);
      path.add(time, sign * (to - from) / time);
    }
    path.settle_at(sign * corners[i], sign * to);
    w = next;
  }
  return w;
}

/// Takes an acceleration against the direction `sign` back to 0, with the jerk of each side of
/// v = 0.
void settle(ExactPath& path, Real sign, const MotionJerk& jerk) {
  const ExactState& now = path.end();
  if (sign * now.acceleration >= 0) return;
  const Real goal = settled_velocity(now, jerk);
  const Real speed = sign * now.velocity;
  if (speed > 0) {
    const Real w_at_rest = half_square_of(now.acceleration) - speed * exact(jerk.deceleration);
    const Real left = w_at_rest > 0 ? std::sqrt(2 * w_at_rest) : 0.0L;
    path.add((std::abs(now.acceleration) - left) / exact(jerk.deceleration),
             sign * exact(jerk.deceleration));
    path.settle_at(left > 0 ? 0.0L : goal, -sign * left);
    if (!(left > 0)) return;
  }
  path.add(std::abs(path.end().acceleration) / exact(jerk.acceleration),
           sign * exact(jerk.acceleration));
  path.settle_at(goal, 0.0L);
}

}  // namespace

ExactState ExactPhase::after(Real time) const {
  return {begin.way + time * (begin.velocity + time * (begin.acceleration / 2 + time * jerk / 6)),
          begin.velocity + time * (begin.acceleration + time * jerk / 2),
          begin.acceleration + time * jerk};
}

void ExactPath::add(Real duration, Real jerk) {
  if (!(duration > 0)) return;
  ExactPhase& phase = phases_.at(count_);
  phase = {.begin = end_, .duration = duration, .jerk = jerk};
  ++count_;
  duration_ += duration;
  end_ = phase.after(duration);
}

void ExactPath::settle_at(Real velocity, Real acceleration) {
  end_.velocity = velocity;
  end_.acceleration = acceleration;
}

Real settled_velocity(const ExactState& state, const MotionJerk& jerk) {
  const Real w = half_square_of(state.acceleration);
  const Real sign = state.acceleration < 0 ? -1 : 1;
  const Real speed = sign * state.velocity;
  if (speed >= 0) return sign * (speed + w / exact(jerk.acceleration));
  const Real left = w + speed * exact(jerk.deceleration);  // at v = 0
  return sign * left / exact(left > 0 ? jerk.acceleration : jerk.deceleration);
}

ExactPath fastest_change(const ExactState& start, Real target, const MotionLimits& limits,
                         const MotionJerk& jerk) {
  const Real sign = target >= settled_velocity(start, jerk) ? 1 : -1;
  const Real goal = sign * target;
  const Real w_up = half_square_of(exact(limits.acceleration));
  const Real w_down = half_square_of(exact(limits.deceleration));
  ExactPath path(start);
  settle(path, sign, jerk);
  Real velocity = sign * path.end().velocity;
  Real w = half_square_of(path.end().acceleration);
  if (velocity < 0) {
    BoundedSide slowing{.begin = velocity,
                        .end = std::min(goal, 0.0L),
                        .w_begin = w,
                        .w_end = 0.0L,
                        .w_cap = w_down,
                        .jerk = exact(jerk.deceleration)};
    if (goal > 0) slowing.w_end = std::min({w_up, w_down, goal * exact(jerk.acceleration)});
    w = follow(path, slowing, sign);
    velocity = slowing.end;
  }
  if (goal > 0) {
    follow(path,
           {.begin = velocity,
            .end = std::max(goal, velocity),
            .w_begin = w,
            .w_end = 0.0L,
            .w_cap = w_up,
            .jerk = exact(jerk.acceleration)},
           sign);
  }
  path.settle_at(target, 0.0L);
  return path;
}

namespace {

/// A motion that leaves a phase in order to stop.
class PushAndStop {
 public:
  PushAndStop(const ExactPhase& phase, Real distance, const MotionLimits& limits,
              const MotionJerk& jerk)
      : phase_(phase), distance_(distance), limits_(limits), jerk_(jerk) {}

  /// @return the shortest time from the beginning of the phase over the distance; infinite if there
  ///         is none.
  [[nodiscard]] Real shortest() const {
    constexpr int kPoints = 8;  // enough to find a second root as well
    Real best = std::numeric_limits<Real>::infinity();
    for (int k = 0; k < kPoints; ++k) {
      const Real from = phase_.duration * k / kPoints;
      const Real to = phase_.duration * (k + 1) / kPoints;
      if (is_beyond(from) != is_beyond(to)) best = std::min(best, time_between(from, to));
    }
    return best;
  }

 private:
  [[nodiscard]] ExactPath stop(Real time) const {
    return fastest_change(phase_.after(time), 0.0L, limits_, jerk_);
  }

  [[nodiscard]] bool is_beyond(Real time) const { return stop(time).end().way > distance_; }

  [[nodiscard]] Real time_between(Real low, Real high) const {
    constexpr int kHalvings = 64;  // down to the last digit of a time
    const bool was_beyond = is_beyond(low);
    for (int halving = 0; halving < kHalvings; ++halving) {
      const Real middle = (low + high) / 2;
      (is_beyond(middle) == was_beyond ? low : high) = middle;
    }
    return low + stop(low).duration();
  }

  const ExactPhase& phase_;
  Real distance_;
  const MotionLimits& limits_;
  const MotionJerk& jerk_;
};

}  // namespace

Real fastest_move(const ExactState& start, Real distance, const MotionLimits& limits,
                  const MotionJerk& jerk) {
  Real best = std::numeric_limits<Real>::infinity();
  for (const Real side : {1.0L, -1.0L}) {
    const Real highest = side * exact(limits.velocity);
    const ExactPath change = fastest_change(start, highest, limits, jerk);
    Real spent = 0.0L;
    for (std::size_t i = 0; i < change.size(); ++i) {
      const PushAndStop push(change.phase(i), distance, limits, jerk);
      best = std::min(best, spent + push.shortest());
      spent += change.phase(i).duration;
    }
    const ExactPath brake = fastest_change({.velocity = highest}, 0.0L, limits, jerk);
    const Real cruise = side * (distance - change.end().way - brake.end().way);
    if (cruise >= 0) {
      best = std::min(best, change.duration() + cruise / exact(limits.velocity) + brake.duration());
    }
  }
  return best;
}

}  // namespace vdrive::test
