// SPDX-License-Identifier: Apache-2.0
#include "followed_bench.hpp"

#include "joint_limits.hpp"

#include <memory>
#include <utility>

namespace vdrive::ros2 {
namespace {

using Clock = std::chrono::steady_clock;

// Other programs may change the limits of a drive, without any event.
constexpr std::chrono::seconds kReadAgainAfter{2};

}  // namespace

FollowedBench::FollowedBench(client::Session& session, Bench& bench, bridge::Reports& reports,
                             std::function<void()> notify)
    : session_(session),
      bench_(bench),
      notify_(std::move(notify)),
      link_(*this, session, reports, bench.info(),
            {.label = bench.label(),
             .remedies = {.loss = "publish true on enable to take it again",
                          .faults = "publish true on the topic enable to reset them"}}) {}

void FollowedBench::on_open(const client::BenchInfo& /*info*/,
                            const std::vector<client::Axis>& axes) {
  axes_ = axes;
  // The limits are read before the state, because the joints can be commanded once there is a
  // state. This read does not answer a new request, so limits_read stays the same: if a request is
  // waiting, before_turn() reads the limits again for it.
  read_limits(bench_.seen().limits_read);
}

void FollowedBench::on_state(const State& state) {
  learn_names(*state);
  bench_.set_state(state);
  notify_();
}

void FollowedBench::on_lost() {
  bench_.set_state(nullptr);
  notify_();
}

void FollowedBench::before_turn(bridge::BenchLink& link) {
  const Bench::Wishes wishes = bench_.take_wishes();
  const bool are_wanted = wishes.limits != bench_.seen().limits_read;
  if (are_wanted || Clock::now() >= limits_due_) read_limits(wishes.limits);
  if (wishes.control) link.want_control(*wishes.control == ControlWish::take);
  if (wishes.control == ControlWish::give_back) (void)session_.release(bench_.info().number);
}

/// Does not wait: a name that arrives late is shown with a later state.
void FollowedBench::learn_names(const client::Observation& observation) {
  const std::uint64_t own = session_.id();
  std::uint64_t last = 0;  // most axes have the same owner
  for (const client::AxisSnapshot& axis : observation.axes) {
    const std::uint64_t owner = axis.owner_session;
    if (owner == 0 || owner == own || owner == std::exchange(last, owner)) continue;
    const auto known = bench_.seen().names;
    if (known && known->contains(owner)) continue;
    if (auto name = session_.known_name(bench_.info().number, owner)) {
      bench_.add_name(owner, std::move(*name));
    }
  }
}

/// @param request number of the request that these values answer; a later request needs another
///        read
void FollowedBench::read_limits(std::uint64_t request) {
  limits_due_ = Clock::now() + kReadAgainAfter;
  auto limits = ros2::read_limits(axes_, bench_.joints());
  if (!limits) return;
  bench_.set_limits(std::make_shared<const std::vector<JointLimits>>(std::move(*limits)), request);
  notify_();
}

}  // namespace vdrive::ros2
