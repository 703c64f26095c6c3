// SPDX-License-Identifier: Apache-2.0
#include "engine/control_table.hpp"

#include <algorithm>

namespace vdrive::service {

ControlTable::ControlTable(std::size_t axes) : owners_(axes) {
  sessions_.reserve(kMaxSessions);
}

SessionRecord* ControlTable::find(std::uint64_t session) noexcept {
  const auto found = std::ranges::find(sessions_, session, &SessionRecord::session);
  return found == sessions_.end() ? nullptr : &*found;
}

const SessionRecord* ControlTable::find(std::uint64_t session) const noexcept {
  const auto found = std::ranges::find(sessions_, session, &SessionRecord::session);
  return found == sessions_.end() ? nullptr : &*found;
}

SessionRecord* ControlTable::find_or_add(std::uint64_t session, std::uint64_t tick) noexcept {
  if (SessionRecord* const known = find(session); known != nullptr) return known;
  if (sessions_.size() < kMaxSessions) {
    return &sessions_.emplace_back(SessionRecord{.session = session, .last_message_tick = tick});
  }
  SessionRecord* oldest = nullptr;
  for (auto& record : sessions_) {
    if (record.owned_axes == 0 &&
        (oldest == nullptr || record.last_message_tick < oldest->last_message_tick)) {
      oldest = &record;
    }
  }
  if (oldest != nullptr) *oldest = {.session = session, .last_message_tick = tick};
  return oldest;
}

void ControlTable::give(std::size_t axis, SessionRecord& owner) noexcept {
  ensure(axis < owners_.size(), "the axis is one of the bench's");
  if (owners_[axis].session == owner.session) return;
  take(axis);
  owners_[axis] = {.session = owner.session, .epoch = owner.epoch};
  ++owner.owned_axes;
}

void ControlTable::take(std::size_t axis) noexcept {
  ensure(axis < owners_.size(), "the axis is one of the bench's");
  if (owners_[axis].session == 0) return;
  if (SessionRecord* const loser = find(owners_[axis].session); loser != nullptr) {
    ensure(loser->owned_axes > 0, "the owner of an axis is counted as such");
    --loser->owned_axes;
  }
  owners_[axis] = {};
}

void ControlTable::renew_epoch(SessionRecord& record) noexcept {
  record.epoch = record.owned_axes == 0 ? 0 : ++last_epoch_;
  for (auto& owner : owners_) {
    if (owner.session == record.session) owner.epoch = record.epoch;
  }
}

}  // namespace vdrive::service
