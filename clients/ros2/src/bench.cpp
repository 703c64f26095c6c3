// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

#include "vdrive/assert.hpp"

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

namespace vdrive::ros2 {
namespace {

constexpr std::size_t kMostNames = 256;  // as many as a bench stores

}  // namespace

std::string owner_text(std::uint64_t session, const Bench::Names* names) {
  const bool is_known = names != nullptr && names->contains(session);
  return client::owner_text(session, is_known ? std::optional(names->at(session)) : std::nullopt);
}

Bench::Bench(client::BenchInfo info, std::vector<ServedJoint> joints)
    : info_(std::move(info)), joints_(std::move(joints)) {
  if (info_.clock_mode == client::ClockMode::realtime) seen_.rate = info_.rate;
}

Bench::Seen Bench::seen() const {
  const std::scoped_lock lock(mutex_);
  return seen_;
}

void Bench::set_state(State state) {
  const std::scoped_lock lock(mutex_);
  seen_.state = std::move(state);
}

void Bench::set_rate(double rate) {
  const std::scoped_lock lock(mutex_);
  seen_.rate = rate;
}

void Bench::add_name(std::uint64_t session, client::SessionName name) {
  const std::scoped_lock lock(mutex_);
  auto names = seen_.names ? *seen_.names : Names();
  // Sessions come and go. The names of those that still hold axes are learned again.
  if (names.size() >= kMostNames) names.clear();
  names.insert_or_assign(session, std::move(name));
  seen_.names = std::make_shared<const Names>(std::move(names));
}

void Bench::set_limits(Limits limits, std::uint64_t request) {
  // Both under one lock, so that a reader of the number gets the limits that belong to it.
  const std::scoped_lock lock(mutex_);
  seen_.limits = std::move(limits);
  seen_.limits_read = request;
}

void Bench::wish(ControlWish wish) {
  const std::scoped_lock lock(mutex_);
  wishes_.control = wish;
}

std::uint64_t Bench::request_limits() {
  const std::scoped_lock lock(mutex_);
  return ++wishes_.limits;
}

Bench::Wishes Bench::take_wishes() {
  const std::scoped_lock lock(mutex_);
  return {.control = std::exchange(wishes_.control, std::nullopt), .limits = wishes_.limits};
}

JointMotion JointCycle::demand() const noexcept {
  return {axis.status.position_demand_value * joint.si_per_user_unit,
          axis.status.velocity_demand_value * joint.si_per_user_unit, 0.0};
}

std::int32_t JointCycle::user_units(double value) const noexcept {
  return static_cast<std::int32_t>(std::llround(value / joint.si_per_user_unit));
}

JointCycle BenchCycle::joint(std::size_t place) const {
  ensure(seen.state && seen.limits, "a joint that is commanded has a state and limits");
  return {.joint = bench.joints()[place],
          .axis = seen.state->axes[place],
          .limits = (*seen.limits)[place],
          .tick = tick(),
          .period = bench.period()};
}

}  // namespace vdrive::ros2
