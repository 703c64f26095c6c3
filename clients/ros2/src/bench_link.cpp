// SPDX-License-Identifier: Apache-2.0
#include "bench_link.hpp"

#include "joint_values.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

namespace vdrive::ros2 {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using namespace vdrive::literals;

constexpr milliseconds kLongestWait{10};
constexpr milliseconds kRetry{200};
constexpr milliseconds kLongestRetry{2000};
constexpr std::chrono::seconds kLimitsPeriod{2};

// What 607Ah can count to [UU].
constexpr double kLowestPosition = std::numeric_limits<std::int32_t>::min();
constexpr double kHighestPosition = std::numeric_limits<std::int32_t>::max();

constexpr std::array kLimitObjects{
    vdrive::describe("app_speed_limit"_object).address,
    vdrive::describe("motor_max_speed_rpm"_object).address,
    vdrive::describe("app_position_limit_switch"_object).address,
    vdrive::describe("user_position_lower_limit"_object).address,
    vdrive::describe("user_position_upper_limit"_object).address,
    vdrive::describe("app_acc_limit"_object).address,
    vdrive::describe("app_dec_limit"_object).address,
    vdrive::describe("profile_acc"_object).address,
    vdrive::describe("profile_dec"_object).address,
    vdrive::describe("max_torque"_object).address,
    vdrive::describe("motor_rated_torque"_object).address,
    vdrive::describe("gear_ratio_numerator"_object).address,
    vdrive::describe("gear_ratio_denominator"_object).address,
};

enum LimitObject : std::size_t {
  speed,
  motor_speed_rpm,
  limit_switch,
  lower,
  upper,
  acceleration,
  deceleration,
  profile_acceleration,
  profile_deceleration,
  max_torque,
  rated_torque,
  gear_numerator,
  gear_denominator,
};

}  // namespace

std::optional<std::uint64_t> other_owner(const BenchState& state, std::uint64_t own) {
  const auto other = std::ranges::find_if(state.axes, [own](const client::AxisSnapshot& axis) {
    return axis.owner_session != 0 && axis.owner_session != own;
  });
  if (other == state.axes.end()) return std::nullopt;
  return other->owner_session;
}

BenchLink::BenchLink(client::Session& session, client::BenchInfo info, std::vector<Joint> joints,
                     Reports& reports, std::function<void()> notify)
    : session_(session),
      info_(std::move(info)),
      joints_(std::move(joints)),
      reports_(reports),
      notify_(std::move(notify)),
      rate_(info_.clock_mode == client::ClockMode::realtime ? info_.rate : 1.0) {
  ids_.reserve(joints_.size());
  for (const Joint& joint : joints_) ids_.push_back(joint.axis);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
}

BenchLink::~BenchLink() {
  thread_.request_stop();
  woken_.notify_all();
}

double BenchLink::period() const noexcept {
  return std::chrono::duration<double>(info_.period).count();
}

std::shared_ptr<const BenchState> BenchLink::state() const {
  const std::scoped_lock lock(mutex_);
  return state_;
}

std::shared_ptr<const std::vector<JointLimits>> BenchLink::limits() const {
  const std::scoped_lock lock(mutex_);
  return limits_;
}

void BenchLink::want_control(bool wanted) {
  if (wanted && !wants_control_.exchange(wanted)) is_control_new_ = true;
  wants_control_ = wanted;
}

void BenchLink::give_back() {
  want_control(false);
  gives_back_ = true;
}

std::uint64_t BenchLink::request_limits() {
  return ++limits_requested_;
}

void BenchLink::rest(milliseconds duration, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  woken_.wait_for(lock, stop, duration, [] {
    return false;
  });
}

void BenchLink::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!follower_ && !open_follower()) {
      rest(kRetry, stop);
      continue;
    }
    if (limits_requested_ != limits_read_ || Clock::now() >= limits_due_) read_limits();
    if (wants_control_ && Clock::now() >= control_due_) take_control();
    if (gives_back_.exchange(false) && !wants_control_) (void)session_.release(info_.number);
    follow();
  }
}

bool BenchLink::open_follower() {
  auto axes = session_.axes(info_.number);
  auto follower = session_.follow(ids_, client::Pace::observe);
  auto now = session_.observe(ids_);
  if (!axes || !follower || !now || axes->size() != joints_.size()) return false;
  axes_ = std::move(*axes);
  follower_.emplace(std::move(*follower));
  limits_due_ = {};
  read_limits();
  set_state(std::move(*now));
  return true;
}

/// Takes the samples that have arrived, and keeps the newest.
void BenchLink::follow() {
  auto newest = follower_->next(kLongestWait);
  while (newest) {
    auto next = follower_->next(milliseconds(0));
    if (!next) {
      set_state(std::move(*newest));
      newest = std::move(next);
      break;
    }
    newest = std::move(next);
  }
  if (newest.outcome().kind() == client::OutcomeKind::timed_out) return;
  follower_.reset();  // the service sends nothing, or was restarted
  {
    const std::scoped_lock lock(mutex_);
    state_.reset();
  }
  notify_();
}

void BenchLink::set_state(client::Observation&& observation) {
  {
    const std::scoped_lock lock(mutex_);
    state_ = std::make_shared<const BenchState>(
        BenchState{.tick = observation.tick, .axes = std::move(observation.axes)});
  }
  notify_();
}

bool BenchLink::is_held(const BenchState& state) const {
  return std::ranges::all_of(state.axes, [this](const client::AxisSnapshot& axis) {
    return axis.owner_session == session_.id();
  });
}

/// Sends a request only while the status has no other owner: a refusal is an event of the bench,
/// which all its clients receive.
void BenchLink::take_control() {
  if (is_control_new_.exchange(false)) {
    reported_owner_ = 0;
    reported_refusal_.clear();
    control_retry_ = kRetry;
  }
  const auto newest = state();
  if (!newest || is_held(*newest)) return;
  control_due_ = Clock::now() + kRetry;
  if (const auto owner = other_owner(*newest, session_.id())) {
    wait_for_owner(*newest, *owner);
    return;
  }
  if (const client::Outcome taken = session_.acquire(ids_); !taken) {
    control_due_ = Clock::now() + control_retry_;
    control_retry_ = std::min(2 * control_retry_, kLongestRetry);
    if (taken.message() == reported_refusal_) return;
    reported_refusal_ = taken.message();
    reports_.report(Severity::warning, name(), "cannot take control: " + taken.message());
    return;
  }
  control_retry_ = kRetry;
  if (auto now = session_.observe(ids_)) set_state(std::move(*now));
  if (const auto held = state()) report_control(*held);
}

void BenchLink::wait_for_owner(const BenchState& state, std::uint64_t owner) {
  if (owner == reported_owner_) return;
  reported_owner_ = owner;
  const auto count = std::ranges::count_if(state.axes, [this](const client::AxisSnapshot& axis) {
    return axis.owner_session != 0 && axis.owner_session != session_.id();
  });
  reports_.report(Severity::warning, name(),
                  "session " + session_text(owner) + " controls " + std::to_string(count) +
                      " of its " + std::to_string(state.axes.size()) +
                      " axes: this bridge takes control when all of them are free");
}

/// Reports control that follows a reported wait or refusal.
void BenchLink::report_control(const BenchState& state) {
  if (reported_owner_ == 0 && reported_refusal_.empty()) return;
  std::string text = "takes control: its axes are free";
  if (reported_owner_ != 0) text += " of session " + session_text(reported_owner_);
  const auto faults = std::ranges::count_if(state.axes, [](const client::AxisSnapshot& axis) {
    return axis.state() == PowerState::fault || axis.state() == PowerState::fault_reaction_active;
  });
  if (faults > 0) {
    text += "; " + std::to_string(faults) + " of " + std::to_string(state.axes.size()) +
            " are in a fault: publish true on the topic enable to reset them";
  }
  reported_owner_ = 0;
  reported_refusal_.clear();
  reports_.report(Severity::info, name(), text);
}

void BenchLink::read_limits() {
  const std::uint64_t requested = limits_requested_;
  limits_due_ = Clock::now() + kLimitsPeriod;
  auto limits = std::make_shared<std::vector<JointLimits>>();
  limits->reserve(axes_.size());
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto read = limits_of(axes_[i], joints_[i]);
    if (!read) return;  // read again after the period
    limits->push_back(*read);
  }
  {
    const std::scoped_lock lock(mutex_);
    limits_ = std::move(limits);
  }
  limits_read_ = requested;
  notify_();
}

std::optional<JointLimits> BenchLink::limits_of(client::Axis& axis, const Joint& joint) {
  const auto readings = axis.read(kLimitObjects);
  if (!readings) return std::nullopt;
  const auto real = [&](LimitObject object) {
    return static_cast<double>(readings->objects[object].value);
  };
  const double unit = joint.si_per_user_unit;
  JointLimits limits;
  limits.velocity =
      std::min(real(speed), real(motor_speed_rpm) * kUserUnitsPerRevolution / 60.0) * unit;
  limits.acceleration = real(acceleration) * unit;
  limits.deceleration = real(deceleration) * unit;
  limits.ramp = std::min({real(profile_acceleration) * unit, real(profile_deceleration) * unit,
                          limits.acceleration, limits.deceleration});
  const bool has_limits = real(limit_switch) != 0.0 && real(lower) < real(upper);
  limits.lower = (has_limits ? real(lower) : kLowestPosition) * unit;
  limits.upper = (has_limits ? real(upper) : kHighestPosition) * unit;
  limits.effort_per_mille = bridge::effort_per_mille(
      joint.unit, {.motor_rated_torque = readings->objects[rated_torque].value,
                   .gear_ratio_numerator = readings->objects[gear_numerator].value,
                   .gear_ratio_denominator = readings->objects[gear_denominator].value});
  limits.effort = real(max_torque) * limits.effort_per_mille;
  return limits;
}

}  // namespace vdrive::ros2
