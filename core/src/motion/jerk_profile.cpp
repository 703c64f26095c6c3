// SPDX-License-Identifier: Apache-2.0
//
// Symbols: v, a velocity and acceleration; V, A, D the limits of velocity, acceleration and
// deceleration; J the limit of the jerk: MotionJerk::acceleration where v and a have the same sign,
// otherwise MotionJerk::deceleration; w = a²/2.
//
// 1. Change of velocity. While a > 0 the velocity grows, and dw/dv = a·da/dv = da/dt: the jerk is
//    the slope of w over v. All limits are lines in this plane. On the way to the velocity u the
//    acceleration is bounded by w <= D²/2 where v < 0 (slowing down), by w <= A²/2 where v > 0
//    (speeding up) and by both at v = 0; and it must be back at 0 at u: w <= J·(u - v). The fastest
//    change has the largest w(v) within these bounds whose slope is at most J: it rises, stays at
//    its cap and falls, once for v < 0 and once for v > 0. A w(v) that is larger everywhere takes
//    less time, because dt = dv/√(2w).
//   If a < 0 at the start, a first returns to 0 with the full jerk, which takes v to the "settled"
//   velocity v - a²/2J. If u is above it, the change continues as described above, otherwise
//   mirrored. This also covers a start whose acceleration forces v beyond V: its settled velocity
//   is above u = V, so v first reaches the settled velocity, and then the mirrored change brings it
//   back to V. From a start above its cap, w falls with the full jerk down to the cap, so the cap
//   is exceeded no longer than J makes necessary.
//
// 2. Move. `stop` is the change to u = 0; it ends at P(v, a), measured from where it begins. If the
//    target is beyond the end of a stop that begins now, the axis first heads for u = +V and stops
//    later, otherwise for u = -V. So a move follows the change to ±V until the instant τ, then a
//    stop. With one jerk the change to +V is never behind any other motion from this start, and, by
//    the same argument with time reversed, no motion that comes to rest at the end of the stop can
//    cover the last part faster than the stop. So no motion arrives earlier.
//   With two jerks, and where the axis does not have to turn, this holds among the motions that do
//   not turn: the same jerk bounds the acceleration of all of them, and a lower peak only costs
//   time. A motion that turns can be faster: while it moves backward, the acceleration for the way
//   forward builds up with the jerk of the deceleration; and after a larger overshoot the braking
//   ends with the jerk of the acceleration. Such motions are not used: a different jerk for slowing
//   down is not a request to start in the wrong direction.
//   The end of the stop, x + P(v, a), moves forward with τ. During a stop it stays where it is:
//   v + dP/dt = 0. The change differs from the stop only in its jerk, j instead of j', so during
//   the change the end moves at the rate ∂P/∂a·(j - j'). With more acceleration the axis stops
//   farther ahead (∂P/∂a >= 0), and j >= j', since both jerks have the same bounds there and the
//   change takes the highest. Where j = j' (the fall to u, the return into limits) τ does not
//   matter. So the instant is the root of a monotonic function, found piece by piece and, within a
//   piece, by the secant of its bracket.
//   If a < 0 at the start and the target is just beyond the end of a stop, the change to +V is left
//   before a is back at 0: the axis brakes, brakes less, and brakes harder again. An overshoot
//   forced by J is a stop that ends beyond the target: u = -V.
//
// 3. At most twelve segments. A change has at most two pieces for the return of a to 0 (the jerk
//    may change at v = 0), and at most five for the rises, caps and falls on both sides of v = 0:
//    for D > A, a falls to A at v = 0 and does not rise afterwards; for D < A it does not fall
//    before v = 0; for D = A it neither falls before nor rises after v = 0. Where a change begins
//    above a cap, its first piece is a fall instead of the rise. A stop has two pieces plus three,
//    but only three if it begins at (±V, 0) or if a already brakes.
//   With a cruise there are 2 + 5 + 1 + 3 = 11 pieces. Without one, the stop begins within a piece
//   of the change:
//   - in the return of a to 0: at most 2 pieces of the change, and 3 of the stop, because a already
//     brakes; 5 in all;
//   - on the first side of v = 0: at most 2 + 2, and 2 + 3 of the stop; 9 in all;
//   - on the second side: at most 2 + 4, and 1 + 3 of the stop, because v and a have the same sign,
//     so that a returns in one piece; 10 in all.
//   One more is needed where the stop holds its velocity because no floating-point number equals
//   the exact leaving time. The twelfth is for rounding: where the fall to u begins at v = 0 and a
//   is A to the last bit, a rise or a cap of almost no length may precede the fall.
#include "vdrive/motion/jerk_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace vdrive {
namespace {

/// A piece of constant jerk and the state at its start.
struct Piece {
  double duration = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
  double jerk = 0.0;
};

/// @return the distance covered in the first `time` of `piece`.
double way_of(const Piece& piece, double time) {
  constexpr double kSixth = 1.0 / 6.0;
  return (piece.velocity + (0.5 * piece.acceleration + kSixth * piece.jerk * time) * time) * time;
}

double velocity_after(const Piece& piece, double time) {
  return piece.velocity + (piece.acceleration + 0.5 * piece.jerk * time) * time;
}

double acceleration_after(const Piece& piece, double time) {
  return piece.acceleration + piece.jerk * time;
}

/// A sequence of pieces.
struct Ramp {
  static constexpr std::size_t kMaximumPieces = 8;

  std::array<Piece, kMaximumPieces> pieces{};
  std::size_t count = 0;
};

double way_of(const Ramp& ramp) {
  double way = 0.0;
  for (std::size_t i = 0; i < ramp.count; ++i) {
    way += way_of(ramp.pieces[i], ramp.pieces[i].duration);
  }
  return way;
}

double half_square(double a) {
  return 0.5 * a * a;
}

/// @return the time in which the acceleration changes linearly from `from` to `to` (both >= 0)
///         while the velocity changes by `span`. This form avoids the cancellation in the
///         difference of two close accelerations.
double time_over(double span, double from, double to) {
  const double sum = from + to;
  return sum > 0.0 ? 2.0 * span / sum : 0.0;
}

/// @return the velocity that is reached when the acceleration returns to 0 with the full jerk,
///         starting now.
double settled_velocity(double velocity, double acceleration, const MotionJerk& jerk) {
  const double direction = acceleration < 0.0 ? -1.0 : 1.0;
  const double along = direction * velocity;
  const double w = half_square(acceleration);
  if (along >= 0.0) return velocity + direction * (w / jerk.acceleration);
  const double until_rest = -along * jerk.deceleration;
  if (w <= until_rest) return velocity + direction * (w / jerk.deceleration);
  return direction * ((w - until_rest) / jerk.acceleration);
}

/// One side of v = 0 during the change to a higher velocity.
struct Side {
  double end_velocity = 0.0;
  double end_acceleration = 0.0;  // >= 0, the highest allowed there, at most the cap
  double cap = 0.0;               // highest acceleration
  double jerk = 0.0;
};

/// Builds the change to a higher velocity; `sign` mirrors it.
class RampBuilder {
 public:
  RampBuilder(double sign, double velocity, double acceleration)
      : sign_(sign), velocity_(sign * velocity), acceleration_(sign * acceleration) {}

  /// Returns a negative acceleration to 0.
  void settle(const MotionJerk& jerk) {
    if (acceleration_ >= 0.0) return;
    double w = half_square(acceleration_);
    if (velocity_ > 0.0) {
      const double until_rest = velocity_ * jerk.deceleration;
      if (w <= until_rest) {
        add(-acceleration_ / jerk.deceleration, jerk.deceleration);
        reach(velocity_ - w / jerk.deceleration, 0.0);
        return;
      }
      w -= until_rest;
      const double at_rest = std::sqrt(2.0 * w);
      add(time_over(velocity_, -acceleration_, at_rest), jerk.deceleration);
      reach(0.0, -at_rest);
    }
    add(-acceleration_ / jerk.acceleration, jerk.acceleration);
    reach(velocity_ - w / jerk.acceleration, 0.0);
  }

  /// Continues to the end of `side` with the largest acceleration allowed.
  void cover(const Side& side) {
    const double span = std::max(side.end_velocity - velocity_, 0.0);
    const double most = side.jerk * span;
    const double w = half_square(acceleration_);
    const double w_end = half_square(side.end_acceleration);
    if (w - w_end >= most) {
      fall_all_the_way(side, span, w - most);
    } else if (w_end - w >= most) {
      const double end = std::sqrt(2.0 * (w + most));
      add(time_over(span, acceleration_, end), side.jerk);
      reach(side.end_velocity, end);
    } else {
      go_to_peak(side, most + (w_end - w));
      fall_to_end(side, w_end);
    }
  }

  [[nodiscard]] double velocity() const { return velocity_; }

  [[nodiscard]] const Ramp& ramp() const { return ramp_; }

 private:
  void fall_all_the_way(const Side& side, double span, double w_left) {
    // If a must end at 0, the remaining w is rounding error, and its square root would not be
    // small.
    const bool ends = side.end_acceleration == 0.0;
    const double end = ends ? 0.0 : std::sqrt(2.0 * w_left);
    add(ends ? acceleration_ / side.jerk : time_over(span, acceleration_, end), -side.jerk);
    reach(side.end_velocity, end);
  }

  /// From below the cap up to it or to a lower peak; from above it down to the cap.
  /// @param twice_gain twice the gain of w without a cap
  void go_to_peak(const Side& side, double twice_gain) {
    const double w = half_square(acceleration_);
    const double w_cap = half_square(side.cap);
    if (w > w_cap) {
      add((acceleration_ - side.cap) / side.jerk, -side.jerk);
      reach(velocity_ + (w - w_cap) / side.jerk, side.cap);
      return;
    }
    const double free_gain = 0.5 * twice_gain;
    const bool is_capped = free_gain >= w_cap - w;
    const double gain = is_capped ? w_cap - w : free_gain;
    const double peak = is_capped ? side.cap : std::sqrt(2.0 * (w + gain));
    add(time_over(gain / side.jerk, acceleration_, peak), side.jerk);
    reach(velocity_ + gain / side.jerk, peak);
  }

  /// Holds the peak if there is room, then falls.
  void fall_to_end(const Side& side, double w_end) {
    const double lost = std::max(half_square(acceleration_) - w_end, 0.0) / side.jerk;
    if (acceleration_ == side.cap) {
      const double begin = side.end_velocity - lost;
      add((begin - velocity_) / side.cap, 0.0);
      reach(begin, side.cap);
    }
    add(time_over(lost, acceleration_, side.end_acceleration), -side.jerk);
    reach(side.end_velocity, side.end_acceleration);
  }

  void add(double duration, double jerk) {
    if (!(duration > 0.0)) return;
    ensure(ramp_.count < Ramp::kMaximumPieces, "a change of the velocity has eight pieces at most");
    ramp_.pieces[ramp_.count] = {.duration = duration,
                                 .velocity = sign_ * velocity_,
                                 .acceleration = sign_ * acceleration_,
                                 .jerk = sign_ * jerk};
    ++ramp_.count;
  }

  void reach(double velocity, double acceleration) {
    velocity_ = velocity;
    acceleration_ = acceleration;
  }

  double sign_;
  double velocity_;
  double acceleration_;
  Ramp ramp_;
};

/// The limits of a motion.
struct Rules {
  MotionLimits limits;
  MotionJerk jerk;
};

/// @return the fastest change of velocity to `target`, ending with zero acceleration.
Ramp change_velocity(double velocity, double acceleration, double target, const Rules& rules) {
  const auto& [limits, jerk] = rules;
  const double sign = target >= settled_velocity(velocity, acceleration, jerk) ? 1.0 : -1.0;
  RampBuilder builder(sign, velocity, acceleration);
  builder.settle(jerk);
  const double goal = sign * target;
  if (goal <= 0.0) {
    builder.cover({.end_velocity = goal, .cap = limits.deceleration, .jerk = jerk.deceleration});
    return builder.ramp();
  }
  if (builder.velocity() < 0.0) {
    const double steady = std::min(limits.acceleration, limits.deceleration);
    builder.cover({.end_velocity = 0.0,
                   .end_acceleration = std::min(steady, std::sqrt(2.0 * jerk.acceleration * goal)),
                   .cap = limits.deceleration,
                   .jerk = jerk.deceleration});
  }
  builder.cover({.end_velocity = goal, .cap = limits.acceleration, .jerk = jerk.acceleration});
  return builder.ramp();
}

/// @return the stop that begins `time` into `piece`.
Ramp stop_after(const Piece& piece, double time, const Rules& rules) {
  return change_velocity(velocity_after(piece, time), acceleration_after(piece, time), 0.0, rules);
}

/// Narrows an interval around the root of an increasing function by its secant. An end that does
/// not move has its value halved (Illinois method); if three successive steps do not halve the
/// interval, the next one bisects it.
class Bracket {
 public:
  /// @param length of the interval, which starts at 0
  /// @param below value of the function at 0, < 0
  /// @param above its value at `length`, > 0
  Bracket(double length, double below, double above)
      : high_(length), below_(below), above_(above) {}

  /// @return the next point to try; an end of the interval if there is no number left inside it.
  [[nodiscard]] double next() const {
    const double width = high_ - low_;
    const double secant = high_ - width * (above_ / (above_ - below_));
    const bool trusts = slow_steps_ < kSlow && secant > low_ && secant < high_;
    return trusts ? secant : low_ + 0.5 * width;
  }

  [[nodiscard]] bool has_inside(double time) const { return time > low_ && time < high_; }

  [[nodiscard]] double low() const { return low_; }

  /// @param error value of the function at `time`
  void narrow(double time, double error) {
    const double width = high_ - low_;
    if (error < 0.0) {
      low_ = time;
      below_ = error;
      above_ *= stayed_ == End::high ? 0.5 : 1.0;
      stayed_ = End::high;
    } else {
      high_ = time;
      above_ = error;
      below_ *= stayed_ == End::low ? 0.5 : 1.0;
      stayed_ = End::low;
    }
    const bool was_halved = slow_steps_ == kSlow;
    const bool is_slow = high_ - low_ > 0.5 * width;
    slow_steps_ = is_slow && !was_halved ? slow_steps_ + 1 : 0;
  }

 private:
  enum class End : std::uint8_t { none, low, high };

  static constexpr int kSlow = 3;

  double low_ = 0.0;
  double high_;
  double below_;
  double above_;
  int slow_steps_ = 0;
  End stayed_ = End::none;
};

/// When to leave a piece, and how far before the target the stop from there ends.
struct Leave {
  double time = 0.0;
  double missing = 0.0;  // >= 0; 0 within the rounding of the distance
};

/// Searches the instant at which to leave a change of velocity for the stop.
class LeaveSearch {
 public:
  /// @param direction of the change, +1 or -1
  /// @param distance to the target
  LeaveSearch(const Rules& rules, double direction, double distance)
      : rules_(rules), direction_(direction), distance_(distance) {}

  /// @param begin distance to the start of `piece`
  /// @return how far beyond the target, in the direction of the change, the axis stops if it leaves
  ///         `piece` after `time`.
  [[nodiscard]] double beyond(const Piece& piece, double begin, double time) const {
    const double way = way_of(piece, time) + way_of(stop_after(piece, time, rules_));
    return direction_ * ((begin + way) - distance_);
  }

  /// @param below `beyond` at the start of the piece, < 0
  /// @param above `beyond` at its end
  [[nodiscard]] Leave solve(const Piece& piece, double begin, double below, double above) const {
    constexpr int kMaximumSteps = 256;  // four for each bit of the time; about eight are usual
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    const double enough = kEpsilon * (std::abs(distance_) + std::abs(begin));
    if (!(above > enough)) return {.time = piece.duration};
    Bracket bracket(piece.duration, below, above);
    double missing = -below;
    for (int step = 0; step < kMaximumSteps; ++step) {
      const double time = bracket.next();
      if (!bracket.has_inside(time)) break;
      const double error = beyond(piece, begin, time);
      if (std::abs(error) <= enough) return {.time = time};
      if (error < 0.0) missing = -error;
      bracket.narrow(time, error);
    }
    return {.time = bracket.low(), .missing = missing};
  }

  [[nodiscard]] double direction() const { return direction_; }

 private:
  const Rules& rules_;
  double direction_;
  double distance_;
};

}  // namespace

/// Appends pieces; see JerkProfile.
class JerkProfileBuilder {
 public:
  explicit JerkProfileBuilder(double start_position) noexcept
      : profile_(start_position), position_(start_position) {}

  void add(const Piece& piece) noexcept {
    if (!(piece.duration > 0.0)) return;
    append(piece);
    position_ += way_of(piece, piece.duration);
  }

  void add(const Ramp& ramp) noexcept {
    for (std::size_t i = 0; i < ramp.count; ++i) add(ramp.pieces[i]);
  }

  [[nodiscard]] double position() const noexcept { return position_; }

  /// Ends at rest, exactly at `position`, because the reference of the last piece is its end.
  [[nodiscard]] JerkProfile finish_at(double position, bool reaches_target) noexcept {
    if (profile_.count_ > 0) {
      JerkSegment& last = profile_.segments_[profile_.count_ - 1U];
      last.reference_time = last.end_time;
      last.position = position;
      last.velocity = 0.0;
      last.acceleration = 0.0;
    }
    profile_.end_position_ = position;
    profile_.reaches_target_ = reaches_target;
    return profile_;
  }

  /// Continues at `velocity` forever.
  [[nodiscard]] JerkProfile finish_running(double velocity) noexcept {
    append(Piece{.duration = std::numeric_limits<double>::infinity(), .velocity = velocity});
    profile_.end_position_ = position_;
    return profile_;
  }

 private:
  /// Merges successive pieces of the same jerk into one segment, so that the ticks cross fewer
  /// borders.
  void append(const Piece& piece) noexcept {
    const bool goes_on = profile_.count_ > 0 && piece.jerk != 0.0 &&
                         profile_.segments_[profile_.count_ - 1U].jerk == piece.jerk;
    if (!goes_on) {
      ensure(profile_.count_ < JerkProfile::kMaximumSegments, "a plan has twelve segments at most");
      profile_.segments_[profile_.count_] = {.reference_time = time_,
                                             .position = position_,
                                             .velocity = piece.velocity,
                                             .acceleration = piece.acceleration,
                                             .jerk = piece.jerk};
      ++profile_.count_;
    }
    time_ += piece.duration;
    profile_.segments_[profile_.count_ - 1U].end_time = time_;
  }

  JerkProfile profile_;
  double position_;
  double time_ = 0.0;
};

namespace {

/// Adds a stop lengthened by `missing`. If a stop takes long to end its acceleration, two
/// neighbouring floating-point leaving times give ends that differ by more than rounding. To make
/// up the difference, the stop holds its velocity once the acceleration has become 0, but only if
/// this takes less time than the next piece. At almost zero velocity it would take longer and is
/// left out: there the ends differ only by rounding.
void add_longer(JerkProfileBuilder& builder, const Ramp& stop, double direction, double missing) {
  for (std::size_t i = 0; i < stop.count; ++i) {
    const Piece& piece = stop.pieces[i];
    const double speed = direction * piece.velocity;
    if (missing > 0.0 && piece.acceleration == 0.0 && missing < speed * piece.duration) {
      builder.add(Piece{.duration = missing / speed, .velocity = piece.velocity});
      missing = 0.0;
    }
    builder.add(piece);
  }
}

/// Adds the pieces of `change` up to the instant at which the stop must begin, then the stop.
/// @param below LeaveSearch::beyond at the start of the change, < 0
void leave_in_time(JerkProfileBuilder& builder, const Ramp& change, const LeaveSearch& search,
                   double below, const Rules& rules) {
  double begin = 0.0;
  for (std::size_t i = 0; i < change.count; ++i) {
    const Piece& piece = change.pieces[i];
    const double above = search.beyond(piece, begin, piece.duration);
    if (above < 0.0 && i + 1 < change.count) {
      builder.add(piece);
      begin += way_of(piece, piece.duration);
      below = above;
      continue;
    }
    const Leave leave = search.solve(piece, begin, below, above);
    Piece first = piece;
    first.duration = leave.time;
    builder.add(first);
    add_longer(builder, stop_after(piece, leave.time, rules), search.direction(), leave.missing);
    return;
  }
}

}  // namespace

JerkSegment JerkProfile::segment_at(double time) const noexcept {
  if (time >= duration()) {
    return {.end_time = std::numeric_limits<double>::infinity(), .position = end_position_};
  }
  std::size_t i = 0;
  while (time >= segments_[i].end_time) ++i;
  return segments_[i];
}

MotionSample JerkProfile::at(double time) const noexcept {
  if (time >= duration()) return {end_position_, 0.0, 0.0};  // for an infinite time too
  return sample(segment_at(time), std::max(time, 0.0));
}

JerkProfile plan_jerk_move(const MotionSample& start, double target, const MotionLimits& limits,
                           const MotionJerk& jerk) noexcept {
  const Rules rules{limits, jerk};
  JerkProfileBuilder builder(start.position);
  const Ramp stop = change_velocity(start.velocity, start.acceleration, 0.0, rules);
  const double distance = target - start.position;
  const double rest = way_of(stop);
  if (rest == distance) {
    builder.add(stop);
    return builder.finish_at(target, true);
  }
  if (limits.velocity == 0.0) {
    builder.add(stop);
    return builder.finish_at(builder.position(), builder.position() == target);
  }
  const double direction = distance > rest ? 1.0 : -1.0;
  const double fastest = direction * limits.velocity;
  const Ramp change = change_velocity(start.velocity, start.acceleration, fastest, rules);
  const Ramp brake = change_velocity(fastest, 0.0, 0.0, rules);
  const double cruise = direction * (distance - (way_of(change) + way_of(brake)));
  if (cruise >= 0.0) {
    builder.add(change);
    builder.add(Piece{.duration = cruise / limits.velocity, .velocity = fastest});
    builder.add(brake);
  } else {
    const LeaveSearch search(rules, direction, distance);
    leave_in_time(builder, change, search, direction * (rest - distance), rules);
  }
  return builder.finish_at(target, true);
}

MotionJerk jerk_of(const MotionLimits& limits, const MoveTimes& times) noexcept {
  if (!(times.jerk > 0.0 && limits.acceleration > 0.0)) return {};
  return {.acceleration = limits.acceleration / times.jerk,
          .deceleration = limits.deceleration / times.jerk};
}

JerkProfile plan_timed_jerk_move(double start, double target, const MoveTimes& times) noexcept {
  JerkProfileBuilder builder(start);
  const MotionLimits limits = limits_of(target - start, times);
  const MotionJerk jerk = jerk_of(limits, times);
  const double direction = target < start ? -1.0 : 1.0;
  const double peak = direction * limits.velocity;
  const double a = direction * limits.acceleration;
  const double d = direction * limits.deceleration;
  const double rounded = times.jerk;  // at both ends of both ramps
  const double gain = 0.5 * a * rounded;
  const double loss = 0.5 * d * rounded;
  builder.add(Piece{.duration = rounded, .jerk = direction * jerk.acceleration});
  builder.add(
      Piece{.duration = times.acceleration - 2.0 * rounded, .velocity = gain, .acceleration = a});
  builder.add(Piece{.duration = rounded,
                    .velocity = peak - gain,
                    .acceleration = a,
                    .jerk = -direction * jerk.acceleration});
  builder.add(Piece{.duration = times.duration - times.acceleration - times.deceleration,
                    .velocity = peak});
  builder.add(Piece{.duration = rounded, .velocity = peak, .jerk = -direction * jerk.deceleration});
  builder.add(Piece{
      .duration = times.deceleration - 2.0 * rounded, .velocity = peak - loss, .acceleration = -d});
  builder.add(Piece{.duration = rounded,
                    .velocity = loss,
                    .acceleration = -d,
                    .jerk = direction * jerk.deceleration});
  return builder.finish_at(target, true);
}

JerkProfile plan_jerk_velocity(const MotionSample& start, double target, const MotionLimits& limits,
                               const MotionJerk& jerk) noexcept {
  const double wanted = std::min(std::max(target, -limits.velocity), limits.velocity);
  JerkProfileBuilder builder(start.position);
  builder.add(change_velocity(start.velocity, start.acceleration, wanted, {limits, jerk}));
  return wanted == 0.0 ? builder.finish_at(builder.position(), true)
                       : builder.finish_running(wanted);
}

JerkProfile plan_jerk_stop(const MotionSample& start, double deceleration,
                           const MotionJerk& jerk) noexcept {
  const MotionLimits limits{
      .velocity = 0.0, .acceleration = deceleration, .deceleration = deceleration};
  return plan_jerk_velocity(start, 0.0, limits, jerk);
}

}  // namespace vdrive
