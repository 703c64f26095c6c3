// SPDX-License-Identifier: Apache-2.0
#include "dds/library/library.hpp"

#include <fastdds/rtps/attributes/ServerAttributes.h>
#include <fastdds/rtps/common/LocatorList.hpp>
#include <fastdds/rtps/network/SenderResource.h>
#include <fastrtps/attributes/LibrarySettingsAttributes.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>

#include <mutex>

namespace vdrive::wire {

void set_times(dds::DataWriterQos& qos, const WriterTimes& times) {
  auto& set = qos.reliable_writer_qos().times;
  set.initialHeartbeatDelay = times.first_heartbeat;
  set.heartbeatPeriod = times.heartbeat_period;
  set.nackResponseDelay = times.nack_response;
}

void set_times(dds::DataReaderQos& qos, const ReaderTimes& times) {
  auto& set = qos.reliable_reader_qos().times;
  set.initialAcknackDelay = times.first_acknack;
  set.heartbeatResponseDelay = times.heartbeat_response;
}

void add_discovery_server(const rtps::Locator_t& server, dds::DomainParticipantQos& qos) {
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.discoveryProtocol = rtps::DiscoveryProtocol_t::CLIENT;
  eprosima::fastdds::rtps::RemoteServerAttributes remote;
  remote.metatrafficUnicastLocatorList.push_back(server);
  // The servers of a client are numbered from 0.
  eprosima::fastdds::rtps::get_server_client_default_guidPrefix(
      static_cast<int>(discovery.m_DiscoveryServers.size()), remote.guidPrefix);
  discovery.m_DiscoveryServers.push_back(remote);
}

void limit_announcements(dds::DomainParticipantQos& qos, std::uint32_t largest) {
  auto& builtin = qos.wire_protocol().builtin;
  builtin.readerHistoryMemoryPolicy = rtps::PREALLOCATED_MEMORY_MODE;
  builtin.readerPayloadSize = largest;
}

void announce_no_types(dds::DomainParticipantQos& /*qos*/) {
  // Nothing to do: a LibraryType has no type description that could be announced.
}

void deliver_through_the_transport() {
  static std::once_flag once;
  std::call_once(once, [] {
    auto settings = eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings();
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
  });
}

bool write_to(dds::DataWriter& writer, void* sample) {
  return writer.write(sample);
}

bool ObservingTransport::send(rtps::SenderResource* low, const std::uint8_t* bytes,
                              std::uint32_t size, rtps::LocatorsIterator* first,
                              rtps::LocatorsIterator* last,
                              const std::chrono::steady_clock::time_point& timeout) {
  std::vector<std::uint8_t> changed;
  const auto leaving = sends({bytes, size}, changed);
  std::vector<rtps::Locator_t> rest;
  if (!sends_directly(*low, leaving, *first, *last, rest)) {
    return low->send(leaving.data(), size, first, last, timeout);
  }
  eprosima::fastdds::rtps::Locators rest_begin(rest.cbegin());
  eprosima::fastdds::rtps::Locators rest_end(rest.cend());
  return low->send(leaving.data(), size, &rest_begin, &rest_end, timeout);
}

}  // namespace vdrive::wire
