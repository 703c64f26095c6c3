// SPDX-License-Identifier: Apache-2.0
#include "engine/snapshots.hpp"

#include "base/event_codes.hpp"

#include <algorithm>

namespace vdrive::service {

Snapshots::Snapshots(BenchAxes& axes, const BenchClock& clock, const Masters& masters,
                     FrameSchedule& schedule, BenchOutput& output, BenchEvents& events,
                     Counters& counters)
    : axes_(axes),
      clock_(clock),
      masters_(masters),
      schedule_(schedule),
      output_(output),
      events_(events),
      counters_(counters) {
  kept_.reserve(kMost);
}

Reason Snapshots::take(const msg::Request& request, msg::Reply& reply) {
  if (kept_.size() == kMost) return msg::Reason::too_many_snapshots;
  kept_.push_back({.number = ++last_number_,
                   .tick = clock_.tick(),
                   .state = std::make_shared<const AxisBank::Snapshot>(axes_.bank().snapshot())});
  reply.snapshot = last_number_;
  report(request, SnapshotCode::kTaken, last_number_);
  return msg::Reason::none;
}

Reason Snapshots::restore(const msg::Request& request, msg::Reply& reply) {
  const auto kept = std::ranges::find(kept_, request.snapshot, &Kept::number);
  if (kept == kept_.end()) return msg::Reason::unknown_snapshot;
  if (const auto reason = check_owners(request, reply); reason != msg::Reason::none) return reason;
  schedule_.cancel_all();
  axes_.restore(kept->state, clock_.tick());
  output_.queue_status(false);
  report(request, SnapshotCode::kRestored, request.snapshot);
  return msg::Reason::none;
}

Reason Snapshots::check_owners(const msg::Request& request, msg::Reply& reply) const {
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
    const std::uint64_t owner = masters_.owner(axis).session;
    if (owner != 0 && owner != request.session) {
      masters_.name_refused(axes_.number_of(axis), reply);
      return AbortCode::refused_local_control;
    }
  }
  return msg::Reason::none;
}

Reason Snapshots::drop(const msg::Request& request, msg::Reply& /*reply*/) {
  const std::size_t dropped = std::erase_if(kept_, [&](const Kept& kept) {
    return kept.number == request.snapshot;
  });
  if (dropped == 0) return msg::Reason::unknown_snapshot;
  report(request, SnapshotCode::kDropped, request.snapshot);
  return msg::Reason::none;
}

Reason Snapshots::show_next(const msg::Request& request, msg::Reply& reply) const {
  const auto next = std::ranges::upper_bound(kept_, request.snapshot, {}, &Kept::number);
  if (next == kept_.end()) return msg::Reason::none;
  reply.snapshot = next->number;
  reply.tick = next->tick;
  return msg::Reason::none;
}

void Snapshots::report(const msg::Request& request, std::uint32_t code, std::uint64_t number) {
  counters_.snapshots.set(kept_.size());
  events_.report({.kind = msg::EventKind::snapshot,
                  .session = request.session,
                  .code = code,
                  .detail = Label{number}});
}

}  // namespace vdrive::service
