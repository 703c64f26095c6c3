// SPDX-License-Identifier: Apache-2.0
#include "bench_link.hpp"

#include "vdrive/client/axis.hpp"

#include <utility>

namespace vdrive::ros2 {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kLongestWait{10};

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

void BenchLink::give_back() {
  want_control(false);
  gives_back_ = true;
}

void BenchLink::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!follower_.is_open() && !follower_.open(Clock::now())) {
      bridge::rest(bridge::BenchFollower::kRetry, stop);
      continue;
    }
    if (limits_.is_due(Clock::now())) read_limits();
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
  if (limits_.read(axes_, joints_, Clock::now())) notify_();
}

}  // namespace vdrive::ros2
