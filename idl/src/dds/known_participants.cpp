// SPDX-License-Identifier: Apache-2.0
#include "dds/known_participants.hpp"

#include "dds/entities.hpp"

#include <algorithm>

namespace vdrive::wire {

std::vector<OtherParticipant> KnownParticipants::named(std::string_view beginning) const {
  std::vector<OtherParticipant> named;
  const std::scoped_lock lock(mutex_);
  for (const auto& [prefix, other] : known_) {
    if (other.name.starts_with(beginning)) named.push_back(other);
  }
  return named;
}

bool KnownParticipants::has_server() const {
  const auto is_server = [](const auto& known) {
    return ReturnedServers::is_server(known.second.source.participant);
  };
  const std::scoped_lock lock(mutex_);
  return std::ranges::any_of(known_, is_server);
}

void KnownParticipants::find(const rtps::GUID_t& guid, const std::string& name,
                             const std::vector<rtps::octet>& user_data) {
  const Source source = source_of(rtps::InstanceHandle_t(guid));
  // The library creates readers for it after this call.
  const bool is_closed = guard_ != nullptr && guard_->found(source.participant);
  const std::scoped_lock lock(mutex_);
  known_[guid.guidPrefix] = {.name = name,
                             .source = source,
                             .is_closed = is_closed,
                             .place = {user_data.begin(), user_data.end()}};
}

void KnownParticipants::lose(const rtps::GUID_t& guid) {
  const std::scoped_lock lock(mutex_);
  known_.erase(guid.guidPrefix);
  // The library no longer has readers for it.
  if (guard_ != nullptr) guard_->lost(source_of(rtps::InstanceHandle_t(guid)).participant);
}

}  // namespace vdrive::wire
