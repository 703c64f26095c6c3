// SPDX-License-Identifier: Apache-2.0
#include "dds/library/library.hpp"

#include <fastdds/LibrarySettings.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/rtps/transport/SenderResource.hpp>

#include <mutex>

namespace vdrive::wire {

void set_times(dds::DataWriterQos& qos, const WriterTimes& times) {
  auto& set = qos.reliable_writer_qos().times;
  set.initial_heartbeat_delay = times.first_heartbeat;
  set.heartbeat_period = times.heartbeat_period;
  set.nack_response_delay = times.nack_response;
}

void set_times(dds::DataReaderQos& qos, const ReaderTimes& times) {
  auto& set = qos.reliable_reader_qos().times;
  set.initial_acknack_delay = times.first_acknack;
  set.heartbeat_response_delay = times.heartbeat_response;
}

void add_discovery_server(const rtps::Locator_t& server, dds::DomainParticipantQos& qos) {
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.discoveryProtocol = rtps::DiscoveryProtocol::CLIENT;
  discovery.m_DiscoveryServers.push_back(server);
}

void announce_no_types(dds::DomainParticipantQos& qos) {
  qos.properties().properties().emplace_back("fastdds.type_propagation", "disabled");
}

void deliver_through_the_transport() {
  static std::once_flag once;
  std::call_once(once, [] {
    auto* const factory = dds::DomainParticipantFactory::get_instance();
    eprosima::fastdds::LibrarySettings settings;
    factory->get_library_settings(settings);
    settings.intraprocess_delivery = eprosima::fastdds::INTRAPROCESS_OFF;
    factory->set_library_settings(settings);
  });
}

bool write_to(dds::DataWriter& writer, void* sample) {
  return is_ok(writer.write(sample));
}

/// The library hands over the headers of a datagram and its samples in pieces.
bool SeeingTransport::send(rtps::SenderResource* low,
                           const std::vector<rtps::NetworkBuffer>& pieces, std::uint32_t size,
                           rtps::LocatorsIterator* first, rtps::LocatorsIterator* last,
                           const std::chrono::steady_clock::time_point& timeout) {
  thread_local std::vector<std::uint8_t> datagram;  // keeps its capacity
  datagram.clear();
  for (const rtps::NetworkBuffer& piece : pieces) {
    const auto* const bytes = static_cast<const std::uint8_t*>(piece.buffer);
    datagram.insert(datagram.end(), bytes, bytes + piece.size);
  }
  std::vector<std::uint8_t> changed;
  const auto leaving = sends(datagram, changed);
  return low->send({rtps::NetworkBuffer(leaving.data(), size)}, size, first, last, timeout);
}

}  // namespace vdrive::wire
