// SPDX-License-Identifier: Apache-2.0
#include "dds/others.hpp"

#include "dds/entities.hpp"

namespace vdrive::wire {

namespace rtps = eprosima::fastrtps::rtps;

std::vector<OtherParticipant> Others::named(std::string_view beginning) const {
  std::vector<OtherParticipant> named;
  const std::scoped_lock lock(mutex_);
  for (const auto& [prefix, other] : known_) {
    if (other.name.starts_with(beginning)) named.push_back(other);
  }
  return named;
}

void Others::on_participant_discovery(
    eprosima::fastdds::dds::DomainParticipant* /*participant*/,
    // NOLINTNEXTLINE(*-rvalue-reference-param-not-moved): the library's signature
    rtps::ParticipantDiscoveryInfo&& info) {
  using Info = rtps::ParticipantDiscoveryInfo;
  const rtps::ParticipantProxyData& data = info.info;
  const std::vector<rtps::octet>& place = data.m_userData.getValue();
  const Source source = source_of(rtps::InstanceHandle_t(data.m_guid));
  const std::scoped_lock lock(mutex_);
  if (info.status == Info::REMOVED_PARTICIPANT || info.status == Info::DROPPED_PARTICIPANT) {
    known_.erase(data.m_guid.guidPrefix);
    // The library has no readers for it any more.
    if (numbers_ != nullptr) numbers_->removed(source.participant);
  } else {
    // The library makes readers for it after this.
    if (numbers_ != nullptr) numbers_->found(source.participant);
    known_[data.m_guid.guidPrefix] = {.name = data.m_participantName.to_string(),
                                      .source = source,
                                      .is_closed = data.security_attributes_ != 0,
                                      .place = {place.begin(), place.end()}};
  }
}

}  // namespace vdrive::wire
