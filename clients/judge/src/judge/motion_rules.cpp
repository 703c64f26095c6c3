// SPDX-License-Identifier: Apache-2.0
#include "judge/motion_rules.hpp"

#include "judge/words.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kStepsOfAJump = 20;  // a jump is this many times the longest step
constexpr std::uint32_t kStepsToKnow = 10;
constexpr Time kStandingTarget = 1s;      // an older target is not streamed
constexpr std::int64_t kCertainStep = 4;  // [user units]: a shorter step may mean a standing axis
constexpr double kGap = 1.5;              // [periods]
constexpr double kPause = 20;             // [periods]: the stream has ended, and another one starts
constexpr double kSpeedTolerance = 1.05;
constexpr std::uint32_t kStepsOfAStretch = 8;
constexpr Time kSaturated = 500ms;

double seconds_of(Time time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

void MotionRules::forget() {
  *this = {};
}

void MotionRules::take(const Write& write, const Context& context) {
  if (write.fate == Fate::late) {
    ++late_;
    context.report(Rule::motion_set_point_late, [&] {
      return counted(late_, "late write", "late writes") + ", the last one was " +
             object_name(write.object) + " = " + std::to_string(write.value);
    });
  }
  if (!is_taken(write)) return;
  const AxisTrack& track = context.track;
  if (write.object == objects::kControlword) {
    const auto word = static_cast<std::uint16_t>(write.value);
    const bool rises = (word & Controlword::kNewSetPoint) != 0 &&
                       !track.commands(Controlword::kNewSetPoint) && track.has_controlword;
    const bool is_absolute = (word & Controlword::kRelative) == 0;
    if (rises && track.is_enabled() && track.is_in(OperatingMode::profile_position)) {
      take_edge(context);
      if (is_absolute && track.target) check_limits(*track.target, context);
    }
  } else if (write.object == objects::kTarget && is_following_) {
    take_streamed(static_cast<std::int32_t>(write.value), context);
  }
}

void MotionRules::take_edge(const Context& context) {
  const AxisTrack& track = context.track;
  const auto limit = track.values.find(objects::kSpeedLimit);
  const auto speed = track.values.find(objects::kProfileVelocity);
  if (!limit || !speed || *limit == 0 || *speed <= *limit) return;
  context.report(Rule::motion_speed_beyond_limit, [&] {
    return "6081h = " + std::to_string(*speed) +
           " at a set-point, and 607Fh = " + std::to_string(*limit);
  });
}

void MotionRules::check_limits(std::int64_t target, const Context& context) {
  const AxisTrack& track = context.track;
  const auto lower = track.values.find(objects::kLowerLimit);
  const auto upper = track.values.find(objects::kUpperLimit);
  const bool was_beyond = std::exchange(is_beyond_, false);
  if (!lower || !upper || *lower >= *upper || (target >= *lower && target <= *upper)) return;
  is_beyond_ = track.is_cyclic();
  if (was_beyond) return;
  context.report(Rule::motion_target_beyond_limits, [&] {
    return "607Ah = " + std::to_string(target) + ", and 607Dh is " + std::to_string(*lower) +
           " to " + std::to_string(*upper);
  });
}

void MotionRules::begin_stream(const Context& context) {
  const AxisTrack& track = context.track;
  distances_.reset();
  last_target_.reset();
  last_step_ = 0;
  step_before_repeat_ = 0;
  corner_count_ = 0;
  steps_ = 0;
  if (!saw_not_following_) {  // the stream started before the source
    awaits_first_ = false;
    return;
  }
  awaits_first_ = true;
  const bool is_streamed =
      track.target && context.now() - track.target_time < kStandingTarget &&
      track.mode_wanted == static_cast<std::int8_t>(OperatingMode::cyclic_synchronous_position) &&
      track.target_time >= track.mode_wanted_time;
  if (is_streamed) note_first(*track.target, context);
}

void MotionRules::note_first(std::int64_t target, const Context& context) {
  awaits_first_ = false;
  const AxisTrack& track = context.track;
  last_target_ = target;
  last_time_ = context.now();
  if (!track.position || context.now() - track.position_time > kFreshPosition) return;
  first_ = FirstTarget{.target = target, .actual = *track.position};
  judge_first(false, context);
}

/// @param is_over no further step follows
void MotionRules::judge_first(bool is_over, const Context& context) {
  if (!first_) return;
  const std::int64_t jump = std::abs(first_->target - first_->actual);
  const auto window = context.track.values.find(objects::kFollowingWindow);
  const bool is_certain = window && *window > 0 && jump > *window;
  if (jump > kSmallJump && !is_certain && !is_over && first_->steps < kStepsToKnow) return;
  const FirstTarget first = *first_;
  first_.reset();
  const bool has_steps = is_certain || first.steps > 0;
  if (jump <= kSmallJump || !has_steps ||
      (!is_certain && jump <= kStepsOfAJump * first.longest_step)) {
    was_homed_ = false;
    return;
  }
  const bool is_origin = was_homed_ && had_target_;
  was_homed_ = false;
  context.report(is_origin ? Rule::motion_origin_moved : Rule::motion_first_target, [&] {
    return "the stream began at 607Ah = " + std::to_string(first.target) + " while 6064h was " +
           std::to_string(first.actual) +
           (first.steps == 0
                ? std::string()
                : "; its next steps are " + std::to_string(first.longest_step) + " at most") +
           (is_origin ? "; homing had changed the origin before that" : "");
  });
}

void MotionRules::take_streamed(std::int64_t target, const Context& context) {
  check_limits(target, context);
  if (awaits_first_) return note_first(target, context);
  if (!last_target_) {
    last_target_ = target;
    last_time_ = context.now();
    return;
  }
  const Time distance = context.now() - last_time_;
  const std::int64_t step = target - *last_target_;
  if (distance <= Time{0}) {  // it replaces the previous one
    last_target_ = target;
    return;
  }
  if (first_) {
    ++first_->steps;
    first_->longest_step = std::max(first_->longest_step, std::abs(step));
    judge_first(false, context);
  }
  judge_step(step, distance, context);
  judge_repeat(step, context);
  judge_acceleration(target, context);
  last_target_ = target;
  last_time_ = context.now();
  last_step_ = step;
}

void MotionRules::judge_step(std::int64_t step, Time distance, const Context& context) {
  const auto periods = distances_.put(distance);
  if (!periods) return;
  const bool moves = std::abs(last_step_) >= kCertainStep && std::abs(step) >= kCertainStep;
  if (moves && *periods > kGap && *periods < kPause) {
    context.report(Rule::motion_set_point_missing, [&] {
      return "no target for " + duration_text(distance) +
             " in a moving stream; distances: " + distances_.text();
    });
  }
  auto limit = context.track.values.find(objects::kSpeedLimit);
  if (!limit || *limit <= 0 || (context.track.facts & Fact::kSpeedUnit) == 0) return;
  const auto of_motor = context.track.values.find(objects::kMotorSpeedLimit);
  const bool is_of_motor = of_motor && *of_motor > 0 && *of_motor < *limit;
  if (is_of_motor) limit = of_motor;
  // Rounding may add one unit at each end.
  const double longest = kSpeedTolerance * static_cast<double>(*limit) *
                             seconds_of(std::max(distance, *distances_.period())) +
                         2;
  if (static_cast<double>(std::abs(step)) <= longest) return;
  context.report(Rule::motion_step_too_long, [&] {
    return "a step of " + std::to_string(step) + " within " + duration_text(distance) +
           (is_of_motor ? "; 6080h, in user units " : "; 607Fh = ") + std::to_string(*limit) +
           ", allows " + std::to_string(static_cast<std::int64_t>(longest));
  });
}

/// Targets are integers, so an acceleration computed from one cycle to the next would be
/// meaningless.
void MotionRules::judge_acceleration(std::int64_t target, const Context& context) {
  const auto limit = context.track.values.find(objects::kAccelerationLimit);
  if (!limit || *limit <= 0 || (context.track.facts & Fact::kSpeedUnit) == 0) return;
  if (corner_count_ > 0 && ++steps_ < kStepsOfAStretch) return;
  steps_ = 0;
  const Corner now{.target = target, .time = context.now()};
  if (corner_count_ < corners_.size()) {
    corners_[corner_count_++] = now;
    return;
  }
  const Corner first = corners_[0];
  const Corner middle = corners_[1];
  const double before = seconds_of(middle.time - first.time);
  const double after = seconds_of(now.time - middle.time);
  const auto way_before = static_cast<double>(middle.target - first.target);
  const auto way_after = static_cast<double>(now.target - middle.target);
  const double acceleration =
      std::abs(way_after / after - way_before / before) * 2 / (before + after);
  const double shorter = std::min(before, after);
  const double rounding = 4 / (shorter * shorter);  // one unit at each corner
  const bool is_regular = std::max(before, after) < kGap * shorter;
  corners_ = {middle, now};
  if (!is_regular || acceleration <= kSpeedTolerance * static_cast<double>(*limit) + rounding) {
    return;
  }
  context.report(Rule::motion_acceleration_beyond_limit, [&] {
    return "targets of " + duration_text(now.time - first.time) + " change their speed by " +
           std::to_string(static_cast<std::int64_t>(acceleration)) +
           " a second squared; 60C5h = " + std::to_string(*limit);
  });
}

void MotionRules::judge_repeat(std::int64_t step, const Context& context) {
  const bool goes_on = step_before_repeat_ != 0 && (step > 0) == (step_before_repeat_ > 0) &&
                       2 * std::abs(step) >= std::abs(step_before_repeat_);
  if (goes_on) {
    ++repeats_;
    context.report(Rule::motion_set_point_repeated, [&] {
      return std::to_string(repeats_) + " of " + std::to_string(distances_.count()) +
             " targets repeated the one before; the last steps were " +
             std::to_string(step_before_repeat_) + ", 0, " + std::to_string(step);
    });
  }
  const bool repeats = step == 0 && std::abs(last_step_) >= kCertainStep;
  step_before_repeat_ = repeats ? last_step_ : 0;
}

void MotionRules::take(const Shown& shown, const Context& context) {
  const AxisTrack& track = context.track;
  if (shown.has(ShownMember::kFollowingError)) watch_error(context);
  if (shown.has(ShownMember::kTorque)) watch_torque(context);
  if (!shown.has(ShownMember::kStatusword) && !shown.has(ShownMember::kMode)) return;
  const bool is_homing = track.is_enabled() && track.is_in(OperatingMode::homing);
  const bool is_attained = is_homing && track.shows(Statusword::kHomingAttained);
  if (is_attained && !is_homing_attained_) {
    was_homed_ = true;
    had_target_ = track.target.has_value();
  }
  is_homing_attained_ = is_attained;
  watch_following(context);
}

void MotionRules::watch_following(const Context& context) {
  const AxisTrack& track = context.track;
  const bool is_following =
      track.is_enabled() && track.is_in(OperatingMode::cyclic_synchronous_position);
  if (is_following && !is_following_) {
    is_following_ = true;
    begin_stream(context);
  } else if (!is_following) {
    saw_not_following_ =
        saw_not_following_ ||
        (track.has_status && (!track.is_enabled() || track.mode_in_force().has_value()));
    if (!is_following_) return;
    is_following_ = false;
    judge_first(true, context);
  }
}

void MotionRules::watch_error(const Context& context) {
  const AxisTrack& track = context.track;
  const std::int64_t error = std::abs(std::int64_t{*track.following_error});
  if (error <= largest_error_) return;  // most samples end here: finding the window takes longer
  const std::int64_t window = track.values.find(objects::kFollowingWindow).value_or(0);
  if (window <= 0 || window >= std::numeric_limits<std::uint32_t>::max()) return;
  if (2 * error <= window) return;
  const bool is_position_mode = track.is_in(OperatingMode::profile_position) ||
                                track.is_in(OperatingMode::interpolated_position) ||
                                track.is_in(OperatingMode::cyclic_synchronous_position);
  if (!track.is_enabled() || !is_position_mode) return;
  largest_error_ = error;
  context.report(Rule::motion_following_error, [&] {
    return "60F4h reached " + std::to_string(error) + ", and 6065h is " + std::to_string(window);
  });
}

void MotionRules::watch_torque(const Context& context) {
  const AxisTrack& track = context.track;
  const std::int64_t limit = track.values.find(objects::kMaxTorque).value_or(0);
  if (limit <= 0 || std::abs(std::int64_t{*track.torque}) < limit) {
    saturated_since_.reset();
    is_saturation_reported_ = false;
    return;
  }
  const bool presses = track.is_in(OperatingMode::profile_torque) ||
                       track.is_in(OperatingMode::cyclic_synchronous_torque) ||
                       track.is_in(OperatingMode::homing);
  if (!track.is_enabled() || presses) return saturated_since_.reset();
  if (!saturated_since_) saturated_since_ = context.now();
  if (is_saturation_reported_ || context.now() - *saturated_since_ < kSaturated) return;
  is_saturation_reported_ = true;
  context.report(Rule::motion_torque_saturated, [&] {
    return "6077h has been " + std::to_string(*track.torque) + " for " + duration_text(kSaturated) +
           ", and 6072h is " + std::to_string(limit);
  });
}

}  // namespace vdrive::judge
