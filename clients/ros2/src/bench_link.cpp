// SPDX-License-Identifier: Apache-2.0
#include "bench_link.hpp"

#include "joint_values.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"

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

BenchLink::BenchLink(client::Session& session, client::BenchInfo info, std::vector<Joint> joints,
                     bridge::Reports& reports, std::function<void()> notify)
    : session_(session),
      info_(std::move(info)),
      joints_(std::move(joints)),
      notify_(std::move(notify)),
      follower_([this] {
        return begin();
      }),
      keeper_(session.id(), control_calls(reports)),
      rate_(info_.clock_mode == client::ClockMode::realtime ? info_.rate : 1.0) {
  ids_.reserve(joints_.size());
  for (const Joint& joint : joints_) ids_.push_back(joint.axis);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
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

void BenchLink::give_back() {
  want_control(false);
  gives_back_ = true;
}

std::uint64_t BenchLink::request_limits() {
  return ++limits_requested_;
}

void BenchLink::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!follower_.is_open() && !follower_.open(Clock::now())) {
      bridge::rest(bridge::BenchFollower::kRetry, stop);
      continue;
    }
    if (limits_requested_ != limits_read_ || Clock::now() >= limits_due_) read_limits();
    keep_control();
    if (gives_back_.exchange(false) && !keeper_.is_wanted()) (void)session_.release(info_.number);
    follow();
  }
}

client::Result<bridge::BenchFollower::Next> BenchLink::begin() {
  auto axes = session_.axes(info_.number);
  auto next = bridge::follow_axes(session_, ids_)();
  auto now = session_.observe(ids_);
  if (!axes) return axes.outcome();
  if (!now) return now.outcome();
  if (axes->size() != joints_.size()) return client::Outcome::failed("the bench has other axes");
  axes_ = std::move(*axes);
  limits_due_ = {};
  read_limits();
  set_state(std::move(*now));
  return next;
}

/// Takes the samples that have arrived, and keeps the newest.
void BenchLink::follow() {
  auto newest = follower_.newest(kLongestWait);
  if (newest) set_state(std::move(*newest));
  if (follower_.is_open()) return;
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

bridge::ControlKeeper::Calls BenchLink::control_calls(bridge::Reports& reports) {
  return {.acquire =
              [this] {
                return session_.acquire(ids_);
              },
          .observe = [this]() -> std::optional<client::Observation> {
            auto now = session_.observe(ids_);
            if (!now) return std::nullopt;
            return std::move(*now);
          },
          .report =
              [&reports, name = name()](bridge::Severity severity, const std::string& text) {
                reports.report(severity, name, text);
              },
          .remedy = "publish true on enable to take it again",
          .fault_remedy = "publish true on the topic enable to reset them"};
}

void BenchLink::keep_control() {
  const auto newest = state();
  if (!newest) return;
  if (auto held = keeper_.keep(newest->axes, Clock::now())) set_state(std::move(*held));
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
