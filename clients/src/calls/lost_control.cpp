// SPDX-License-Identifier: Apache-2.0
#include "calls/lost_control.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

// A sample that was on its way may still show the owner before.
constexpr int kMostSamples = 5;

bool is_loss(const Outcome& outcome) {
  const bool is_for_a_loss = outcome.code() == wire::number(msg::Reason::stale_epoch) ||
                             outcome.code() == wire::number(msg::Reason::not_owner);
  return outcome.kind() == OutcomeKind::refused && is_for_a_loss && outcome.owner() == nullptr;
}

/// Adds the axes of one bench that other sessions hold.
void add_owners(SessionCore& core, const Target& target, std::span<const std::uint16_t> axes,
                std::map<AxisId, AxisOwner>& owners) {
  for (int sample = 0; sample < kMostSamples; ++sample) {
    const auto seen = core.observer.observe(target, axes);
    if (!seen) return;
    bool is_old = false;
    for (const AxisSnapshot& axis : seen->axes) {
      if (axis.owner_session == core.id) is_old = true;
      if (axis.owner_session == 0 || axis.owner_session == core.id) continue;
      owners[axis.id] = {.axis = axis.id, .session = axis.owner_session};
    }
    if (!owners.empty() || !is_old) return;
  }
}

/// @return who holds these axes now, but this session.
std::map<AxisId, AxisOwner> owners_of(SessionCore& core, std::span<const AxisId> axes) {
  std::map<std::uint32_t, std::vector<std::uint16_t>> by_bench;
  for (const AxisId& axis : axes) by_bench[axis.bench].push_back(axis.axis);
  std::map<AxisId, AxisOwner> owners;
  for (const auto& [bench, numbers] : by_bench) {
    const auto target = core.discovery.present_target(bench);
    if (!target) continue;
    std::map<AxisId, AxisOwner> some;
    add_owners(core, *target, numbers, some);
    owners.merge(some);
  }
  for (auto& [axis, owner] : owners) owner.name = core.names.find(axis.bench, owner.session);
  return owners;
}

}  // namespace

Outcome explain_loss(SessionCore& core, Outcome outcome, std::span<const AxisId> axes) {
  if (const AxisOwner* const owner = outcome.owner(); owner != nullptr && !owner->name) {
    AxisOwner known = *owner;
    known.name = core.names.find(known.axis.bench, known.session);
    return outcome.with_owner(std::move(known));
  }
  if (!is_loss(outcome)) return outcome;
  const auto owners = owners_of(core, axes);
  return owners.empty() ? outcome : outcome.with_owner(owners.begin()->second);
}

void explain_losses(SessionCore& core, std::span<Outcome> outcomes, std::span<const AxisId> axes) {
  std::vector<AxisId> lost;
  for (std::size_t place = 0; place < outcomes.size(); ++place) {
    if (is_loss(outcomes[place])) lost.push_back(axes[place]);
  }
  if (lost.empty()) return;
  const auto owners = owners_of(core, lost);
  for (std::size_t place = 0; place < outcomes.size(); ++place) {
    const auto owner = owners.find(axes[place]);
    if (owner == owners.end() || !is_loss(outcomes[place])) continue;
    outcomes[place] = outcomes[place].with_owner(owner->second);
  }
}

}  // namespace vdrive::client
