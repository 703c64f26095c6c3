// SPDX-License-Identifier: Apache-2.0
#include "bench_link.hpp"

#include "messages.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace vdrive::ros2 {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using namespace vdrive::literals;

constexpr milliseconds kPatience{10};
constexpr milliseconds kRetry{200};
constexpr std::chrono::seconds kLimitsPeriod{2};

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

std::shared_ptr<const Sight> BenchLink::sight() const {
  const std::scoped_lock lock(mutex_);
  return sight_;
}

std::shared_ptr<const std::vector<JointLimits>> BenchLink::limits() const {
  const std::scoped_lock lock(mutex_);
  return limits_;
}

void BenchLink::want_control(bool wanted) {
  wants_control_ = wanted;
}

std::uint64_t BenchLink::ask_limits() {
  return ++limits_asked_;
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
    if (limits_asked_ != limits_read_ || Clock::now() >= limits_due_) read_limits();
    if (wants_control_ && Clock::now() >= control_due_) take_control();
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
  show(std::move(*now));
  return true;
}

/// Takes what has arrived; the newest counts.
void BenchLink::follow() {
  auto seen = follower_->next(kPatience);
  while (seen) {
    auto next = follower_->next(milliseconds(0));
    if (!next) {
      show(std::move(*seen));
      seen = std::move(next);
      break;
    }
    seen = std::move(next);
  }
  if (seen.outcome().kind() == client::OutcomeKind::timed_out) return;
  follower_.reset();  // the service fell silent, or is another run
  {
    const std::scoped_lock lock(mutex_);
    sight_.reset();
  }
  notify_();
}

void BenchLink::show(client::Observation&& observation) {
  {
    const std::scoped_lock lock(mutex_);
    sight_ = std::make_shared<const Sight>(
        Sight{.tick = observation.tick, .axes = std::move(observation.axes)});
  }
  notify_();
}

bool BenchLink::is_held(const Sight& sight) const {
  return std::ranges::all_of(sight.axes, [this](const client::AxisSnapshot& axis) {
    return axis.owner_session == session_.id();
  });
}

void BenchLink::take_control() {
  const auto seen = sight();
  if (!seen || is_held(*seen)) return;
  control_due_ = Clock::now() + kRetry;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (seen->axes[i].owner_session == session_.id()) continue;
    if (const client::Outcome taken = axes_[i].acquire(); !taken) {
      reports_.tell(Severity::warning, "joint " + joints_[i].name,
                    "cannot be controlled: " + taken.message());
      return;
    }
  }
  if (auto now = session_.observe(ids_)) show(std::move(*now));
}

void BenchLink::read_limits() {
  const std::uint64_t asked = limits_asked_;
  limits_due_ = Clock::now() + kLimitsPeriod;
  auto limits = std::make_shared<std::vector<JointLimits>>();
  limits->reserve(axes_.size());
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto read = limits_of(axes_[i], joints_[i]);
    if (!read) return;  // asked again after the period
    limits->push_back(*read);
  }
  {
    const std::scoped_lock lock(mutex_);
    limits_ = std::move(limits);
  }
  limits_read_ = asked;
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
  if (real(limit_switch) != 0.0 && real(lower) < real(upper)) {
    limits.lower = real(lower) * unit;
    limits.upper = real(upper) * unit;
  }
  limits.effort_per_mille = bridge::effort_per_mille(
      joint.unit, {.motor_rated_torque = readings->objects[rated_torque].value,
                   .gear_ratio_numerator = readings->objects[gear_numerator].value,
                   .gear_ratio_denominator = readings->objects[gear_denominator].value});
  limits.effort = real(max_torque) * limits.effort_per_mille;
  return limits;
}

}  // namespace vdrive::ros2
