// SPDX-License-Identifier: Apache-2.0
// Snapshots of the whole bench by request: the state of the axes goes back, time does not.
#include "bench_engine.hpp"

#include <algorithm>

namespace vdrive::service {

bool BenchEngine::time_stands() const noexcept {
  return clock_ == ClockMode::lockstep || (clock_ == ClockMode::realtime && rate_ == 0.0);
}

/// Allocates, which only this request may: no tick is due while time stands.
std::uint32_t BenchEngine::take_snapshot(const msg::Request& request, msg::Reply& reply) {
  if (!time_stands()) return msg::REASON_TIME_PASSES;
  if (snapshots_.size() == kMostSnapshots) return msg::REASON_QUEUE_FULL;
  snapshots_.push_back({.number = ++last_snapshot_,
                        .state = std::make_shared<const AxisBank::Snapshot>(bank_.snapshot())});
  reply.snapshot(last_snapshot_);
  tell_snapshot(request, SnapshotNews::kTaken, last_snapshot_);
  return msg::REASON_NONE;
}

std::uint32_t BenchEngine::restore_snapshot(const msg::Request& request, msg::Reply& reply) {
  if (!time_stands()) return msg::REASON_TIME_PASSES;
  const auto kept = std::ranges::find_if(snapshots_, [&](const auto& snapshot) {
    return snapshot.number == request.snapshot();
  });
  if (kept == snapshots_.end()) return msg::REASON_UNKNOWN_SNAPSHOT;
  for (std::size_t axis = 0; axis < numbers_.size(); ++axis) {
    const std::uint64_t owner = control_.owner(axis).session;
    if (owner != 0 && owner != request.session()) {
      refuse_axis(numbers_[axis], reply);
      return wire_code(AbortCode::refused_local_control);
    }
  }
  pending_.drop_if(
      [](const auto&) {
        return true;
      },
      [&](const auto& frame) {
        refuse_frame(frame, msg::REASON_CANCELLED);
      });
  counters_.pending_frames.set(pending_.size());
  bank_.restore(*kept->state, AxisBank::Memory::kept);  // what is stored is on a disk
  if (journal_ != nullptr) journal_->record_restore(kept->state, tick_);
  for (std::size_t axis = 0; axis < numbers_.size(); ++axis) mark_changed(axis);
  post_status();
  tell_snapshot(request, SnapshotNews::kRestored, request.snapshot());
  return msg::REASON_NONE;
}

std::uint32_t BenchEngine::drop_snapshot(const msg::Request& request) {
  if (!time_stands()) return msg::REASON_TIME_PASSES;
  const std::size_t dropped = std::erase_if(snapshots_, [&](const auto& snapshot) {
    return snapshot.number == request.snapshot();
  });
  if (dropped == 0) return msg::REASON_UNKNOWN_SNAPSHOT;
  tell_snapshot(request, SnapshotNews::kDropped, request.snapshot());
  return msg::REASON_NONE;
}

void BenchEngine::tell_snapshot(const msg::Request& request, std::uint32_t code,
                                std::uint64_t number) {
  counters_.snapshots.set(snapshots_.size());
  report({.kind = msg::EVENT_SNAPSHOT,
          .session = request.session(),
          .code = code,
          .detail = Label{number}});
}

}  // namespace vdrive::service
