// SPDX-License-Identifier: Apache-2.0
#include "vdrive/motion/profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdrive {

/// Appends segments. Where a `direction` is passed, velocities are magnitudes along it.
class ProfileBuilder {
 public:
  explicit ProfileBuilder(double start_position) noexcept
      : profile_(start_position), position_(start_position) {}

  /// Travels from velocity `from` (>= 0, along `direction` = +1 or -1) until it has changed by
  /// `change`, at constant acceleration. The change is passed rather than the end, because the
  /// difference of two close speeds would lose digits, and so would the time and position of the
  /// end.
  void ramp(double direction, double from, double change, double acceleration) noexcept {
    const double duration = std::abs(change) / acceleration;
    append(duration, direction * from, direction * (change > 0.0 ? acceleration : -acceleration));
    position_ += direction * (from + 0.5 * change) * duration;
  }

  void cruise(double direction, double velocity, double distance) noexcept {
    append(distance / velocity, direction * velocity, 0.0);
    position_ += direction * distance;
  }

  /// Travels for `duration` from velocity `from` at constant `acceleration`, both signed.
  void piece(double duration, double from, double acceleration) noexcept {
    append(duration, from, acceleration);
    position_ += (from + 0.5 * acceleration * duration) * duration;
  }

  /// Slows at constant `acceleration` (signed) for `duration` to rest exactly at `target`.
  void end_at(double target, double duration, double acceleration) noexcept {
    append(duration, 0.0, acceleration);
    if (duration > 0.0) {
      Segment& last = profile_.segments_[profile_.count_ - 1U];
      last.reference_time = last.end_time;
      last.position = target;
    }
    position_ = target;
  }

  /// Continues at `velocity` forever.
  void run(double direction, double velocity) noexcept {
    append(std::numeric_limits<double>::infinity(), direction * velocity, 0.0);
  }

  /// Slows from velocity `from` to rest exactly at `target`: the reference of the segment is its
  /// end.
  void arrive(double direction, double from, double target, double deceleration) noexcept {
    end_at(target, from / deceleration, -direction * deceleration);
  }

  [[nodiscard]] double position() const noexcept { return position_; }

  [[nodiscard]] Profile finish(bool reaches_target) noexcept {
    profile_.end_position_ = position_;
    profile_.reaches_target_ = reaches_target;
    return profile_;
  }

 private:
  void append(double duration, double velocity, double acceleration) noexcept {
    if (!(duration > 0.0)) return;
    profile_.segments_[profile_.count_] = {.end_time = time_ + duration,
                                           .reference_time = time_,
                                           .position = position_,
                                           .velocity = velocity,
                                           .acceleration = acceleration};
    ++profile_.count_;
    time_ += duration;
  }

  Profile profile_;
  double position_;
  double time_ = 0.0;
};

namespace {

double stopping_distance(double velocity, double deceleration) {
  return 0.5 * velocity * velocity / deceleration;
}

/// Approaches a target at or beyond the stopping distance, from `velocity` >= 0 along `direction`.
void approach(ProfileBuilder& builder, double direction, double velocity, double target,
              const MotionLimits& limits) {
  const double distance = direction * (target - builder.position());
  if (velocity > limits.velocity) {
    const double cruise = distance - stopping_distance(velocity, limits.deceleration);
    builder.ramp(direction, velocity, limits.velocity - velocity, limits.deceleration);
    builder.cruise(direction, limits.velocity, std::max(cruise, 0.0));
    builder.arrive(direction, limits.velocity, target, limits.deceleration);
    return;
  }
  const double a = limits.acceleration;
  const double d = limits.deceleration;
  // v_p² - v² = 2ad(D - s)/(a + d): only the distance beyond the stopping distance adds speed.
  const double beyond = std::max(distance - stopping_distance(velocity, d), 0.0);
  const double gained_squared = 2.0 * a * d * beyond / (a + d);
  const double free_peak = std::sqrt(velocity * velocity + gained_squared);
  const double free_gain = free_peak > 0.0 ? gained_squared / (free_peak + velocity) : 0.0;
  const double highest_gain = limits.velocity - velocity;
  const bool capped = free_gain >= highest_gain;
  const double gain = capped ? highest_gain : free_gain;
  const double peak = capped ? limits.velocity : velocity + gain;
  builder.ramp(direction, velocity, gain, a);
  if (capped) {
    const double ramps = (velocity + 0.5 * gain) * (gain / a) + stopping_distance(peak, d);
    builder.cruise(direction, peak, std::max(distance - ramps, 0.0));
  }
  builder.arrive(direction, peak, target, d);
}

}  // namespace

Segment Profile::segment_at(double time) const noexcept {
  if (time >= duration()) {
    return {.end_time = std::numeric_limits<double>::infinity(), .position = end_position_};
  }
  std::size_t i = 0;
  while (time >= segments_[i].end_time) ++i;
  return segments_[i];
}

MotionSample Profile::at(double time) const noexcept {
  if (time >= duration()) return {end_position_, 0.0, 0.0};  // for an infinite time too
  return sample(segment_at(time), std::max(time, 0.0));
}

Profile plan_move(const MotionState& start, double target, const MotionLimits& limits) noexcept {
  ProfileBuilder builder(start.position);
  const double displacement = target - start.position;
  double direction = displacement < 0.0 ? -1.0 : 1.0;
  if (start.velocity != 0.0) direction = start.velocity < 0.0 ? -1.0 : 1.0;
  double speed = direction * start.velocity;
  const bool behind = direction * displacement < stopping_distance(speed, limits.deceleration);
  if (speed > 0.0 && (behind || limits.velocity == 0.0)) {
    builder.ramp(direction, speed, -speed, limits.deceleration);
    speed = 0.0;
    direction = target < builder.position() ? -1.0 : 1.0;
  }
  if (limits.velocity == 0.0) return builder.finish(builder.position() == target);
  approach(builder, direction, speed, target, limits);
  return builder.finish(true);
}

MotionLimits limits_of(double displacement, const MoveTimes& times) noexcept {
  const double ramps = 0.5 * (times.acceleration + times.deceleration);
  const double peak = std::abs(displacement) / (times.duration - ramps);
  return {.velocity = peak,
          .acceleration = peak / (times.acceleration - times.jerk),
          .deceleration = peak / (times.deceleration - times.jerk)};
}

Profile plan_timed_move(double start, double target, const MoveTimes& times) noexcept {
  ProfileBuilder builder(start);
  const MotionLimits limits = limits_of(target - start, times);
  const double direction = target < start ? -1.0 : 1.0;
  const double cruise = times.duration - times.acceleration - times.deceleration;
  builder.piece(times.acceleration, 0.0, direction * limits.acceleration);
  builder.piece(cruise, direction * limits.velocity, 0.0);
  builder.end_at(target, times.deceleration, -direction * limits.deceleration);
  return builder.finish(true);
}

Profile plan_velocity(const MotionState& start, double target,
                      const MotionLimits& limits) noexcept {
  ProfileBuilder builder(start.position);
  const double wanted = std::min(std::abs(target), limits.velocity);
  double direction = start.velocity < 0.0 ? -1.0 : 1.0;
  double speed = direction * start.velocity;
  if (direction * target < 0.0) {
    builder.ramp(direction, speed, -speed, limits.deceleration);
    direction = -direction;
    speed = 0.0;
  }
  const double change = wanted - speed;
  builder.ramp(direction, speed, change, change > 0.0 ? limits.acceleration : limits.deceleration);
  if (wanted > 0.0) builder.run(direction, wanted);
  return builder.finish(true);
}

Profile plan_stop(const MotionState& start, double deceleration) noexcept {
  ProfileBuilder builder(start.position);
  const double direction = start.velocity < 0.0 ? -1.0 : 1.0;
  const double speed = direction * start.velocity;
  builder.ramp(direction, speed, -speed, deceleration);
  return builder.finish(true);
}

}  // namespace vdrive
