// SPDX-License-Identifier: Apache-2.0
#include "bench_link.hpp"

#include "joint_limits.hpp"

#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace vdrive::ros2 {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// How long a wish for control or for limits waits while the bench sends nothing.
constexpr milliseconds kLongestWait{10};

// The stream reaches a reader from some milliseconds after it was opened on. A step that ends
// within this time is asked for: in lock-step no other tick would follow it.
constexpr std::chrono::seconds kOpening{2};
constexpr milliseconds kAskAgain{100};

// Other programs change the limits of a drive, and no event tells.
constexpr std::chrono::seconds kReadAgainAfter{2};

}  // namespace

BenchLink::BenchLink(client::Session& session, Bench& bench, bridge::Reports& reports,
                     std::function<void()> notify)
    : session_(session),
      bench_(bench),
      notify_(std::move(notify)),
      follower_([this] {
        return begin();
      }),
      keeper_(session.id(), control_calls(reports)) {
  ids_.reserve(bench.joints().size());
  for (const ServedJoint& joint : bench.joints()) ids_.push_back(joint.axis);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
}

void BenchLink::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!follower_.is_open() && !follower_.open(Clock::now())) {
      bridge::rest(bridge::BenchFollower::kRetry, stop);
      continue;
    }
    const Bench::Wishes wishes = bench_.take_wishes();
    const bool are_wanted = wishes.limits != bench_.seen().limits_read;
    if (are_wanted || Clock::now() >= limits_due_) read_limits(wishes.limits);
    keep_control(wishes.control);
    follow();
  }
}

client::Result<bridge::BenchFollower::Next> BenchLink::begin() {
  auto axes = session_.axes(bench_.info().number);
  // The stream before the state: no tick is missing between them.
  auto next = bridge::follow_axes(session_, ids_)();
  auto now = session_.observe(ids_);
  if (!axes) return axes.outcome();
  if (!now) return now.outcome();
  if (axes->size() != ids_.size()) return client::Outcome::failed("the bench has other axes");
  // Begins to listen: a session that stands in the way later has a name at once.
  (void)session_.known_name(bench_.info().number, 0);
  axes_ = std::move(*axes);
  opened_ = Clock::now();
  ask_due_ = opened_ + kAskAgain;
  // The limits before the state: with the state the joints can be commanded. A request that waits
  // still waits: its number is not known here.
  read_limits(bench_.seen().limits_read);
  set_state(std::move(*now));
  return next;
}

/// Takes the samples that have arrived, and keeps the newest.
void BenchLink::follow() {
  auto newest = follower_.newest(kLongestWait);
  if (!newest) newest = ask_again();
  if (newest) set_state(std::move(*newest));
  if (follower_.is_open()) return;
  bench_.set_state(nullptr);
  notify_();
}

/// @return a state that the stream did not show while it was opened; none when it is not newer.
std::optional<client::Observation> BenchLink::ask_again() {
  const Clock::time_point now = Clock::now();
  if (bench_.info().clock_mode != client::ClockMode::lockstep) return std::nullopt;
  if (!follower_.is_open() || now < ask_due_ || now >= opened_ + kOpening) return std::nullopt;
  ask_due_ = now + kAskAgain;
  auto seen = session_.observe(ids_);
  const Bench::State shown = bench_.seen().state;
  if (!seen || (shown && seen->tick <= shown->tick)) return std::nullopt;
  return std::move(*seen);
}

/// Without waiting: a name that comes late is there with a later state.
void BenchLink::learn_names(std::span<const client::AxisSnapshot> axes) {
  const std::uint64_t own = session_.id();
  std::uint64_t last = 0;  // most axes have the same owner
  for (const client::AxisSnapshot& axis : axes) {
    const std::uint64_t owner = axis.owner_session;
    if (owner == 0 || owner == own || owner == std::exchange(last, owner)) continue;
    const auto known = bench_.seen().names;
    if (known && known->contains(owner)) continue;
    if (auto name = session_.known_name(bench_.info().number, owner)) {
      bench_.add_name(owner, std::move(*name));
    }
  }
}

void BenchLink::set_state(client::Observation&& observation) {
  learn_names(observation.axes);
  bench_.set_state(std::make_shared<const client::Observation>(std::move(observation)));
  notify_();
}

bridge::ControlKeeper::Calls BenchLink::control_calls(bridge::Reports& reports) {
  return {
      .acquire =
          [this] {
            return session_.acquire(ids_);
          },
      .observe = [this]() -> std::optional<client::Observation> {
        auto now = session_.observe(ids_);
        if (!now) return std::nullopt;
        return std::move(*now);
      },
      .report =
          [&reports, label = bench_.label()](bridge::Severity severity, const std::string& text) {
            reports.report(severity, label, text);
          },
      .name_of =
          [this](std::uint64_t session) {
            return client::owner_text(session, session_.find_name(bench_.info().number, session));
          },
      .remedy = "publish true on enable to take it again",
      .fault_remedy = "publish true on the topic enable to reset them"};
}

void BenchLink::keep_control(std::optional<ControlWish> wish) {
  if (wish) keeper_.want(*wish == ControlWish::take);
  if (const auto newest = bench_.seen().state) {
    if (auto held = keeper_.keep(newest->axes, Clock::now())) set_state(std::move(*held));
  }
  if (wish == ControlWish::give_back) (void)session_.release(bench_.info().number);
}

/// @param request that the values answer; one that comes meanwhile has them read once more
void BenchLink::read_limits(std::uint64_t request) {
  limits_due_ = Clock::now() + kReadAgainAfter;
  auto limits = ros2::read_limits(axes_, bench_.joints());
  if (!limits) return;
  bench_.set_limits(std::make_shared<const std::vector<JointLimits>>(std::move(*limits)), request);
  notify_();
}

}  // namespace vdrive::ros2
