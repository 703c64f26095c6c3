// SPDX-License-Identifier: Apache-2.0
#include "dds/library/library.hpp"
#include "guard/rtps.hpp"

#include <fastdds/LibrarySettings.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/rtps/common/LocatorList.hpp>
#include <fastdds/rtps/transport/SenderResource.hpp>

#include <mutex>
#include <string>

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

/// For a client of a discovery server there is no limit: it copies each announcement into its
/// history (SerializedPayload_t::reserve), and with the preallocated pool that a limit needs, 3.1.2
/// would reallocate memory of that pool and crash.
void limit_announcements(dds::DomainParticipantQos& qos, std::uint32_t largest) {
  auto& builtin = qos.wire_protocol().builtin;
  if (!builtin.discovery_config.m_DiscoveryServers.empty()) return;
  builtin.readerHistoryMemoryPolicy = rtps::PREALLOCATED_MEMORY_MODE;
  builtin.readerPayloadSize = largest;
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

/// The library passes a datagram in pieces: headers, samples, and finally a piece into which its
/// transport writes statistics, identified by its size (is_statistics_buffer). They stay separate
/// pieces. The shared memory transport of 3.1.2 writes nothing there but sends the piece anyway,
/// with whatever the memory contained, and the guard of the receiver would refuse it. So that piece
/// is left out.
bool ObservingTransport::send(rtps::SenderResource* low,
                              const std::vector<rtps::NetworkBuffer>& pieces, std::uint32_t size,
                              rtps::LocatorsIterator* first, rtps::LocatorsIterator* last,
                              const std::chrono::steady_clock::time_point& timeout) {
  constexpr std::uint32_t kStatisticsPiece = kSubmessageHeaderSize + kStatisticsSize;
  const bool is_unset =
      low->kind() == LOCATOR_KIND_SHM && !pieces.empty() && pieces.back().size == kStatisticsPiece;
  if (is_unset) size -= kStatisticsPiece;
  thread_local std::vector<std::uint8_t> datagram;  // keeps its capacity
  datagram.clear();
  for (const rtps::NetworkBuffer& piece : pieces) {
    const auto* const bytes = static_cast<const std::uint8_t*>(piece.buffer);
    datagram.insert(datagram.end(), bytes, bytes + piece.size);
  }
  datagram.resize(size);
  std::vector<std::uint8_t> changed;
  const auto leaving = sends(datagram, changed);
  const bool is_changed = leaving.data() != datagram.data();
  std::vector<rtps::Locator_t> rest;
  const bool is_split = sends_directly(*low, leaving, *first, *last, rest);
  eprosima::fastdds::rtps::Locators rest_begin(rest.cbegin());
  eprosima::fastdds::rtps::Locators rest_end(rest.cend());
  if (is_split) {
    first = &rest_begin;
    last = &rest_end;
  }
  if (!is_changed && !is_unset) return low->send(pieces, size, first, last, timeout);
  std::vector<rtps::NetworkBuffer> leaving_pieces(pieces.begin(),
                                                  pieces.end() - (is_unset ? 1 : 0));
  if (is_changed) {
    const std::uint8_t* next = leaving.data();
    for (rtps::NetworkBuffer& piece : leaving_pieces) {
      piece = rtps::NetworkBuffer(next, piece.size);
      next += piece.size;
    }
  }
  return low->send(leaving_pieces, size, first, last, timeout);
}

}  // namespace vdrive::wire
