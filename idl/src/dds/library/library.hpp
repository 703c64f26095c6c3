// SPDX-License-Identifier: Apache-2.0
// Where Fast DDS 2 and 3 differ: names, and what a program derives from the library's classes. The
// rest of the room names neither. Both files define the same; CMake compiles the source of the one
// whose library it has found.
#pragma once

#if __has_include(<fastrtps/config.h>)
#include "dds/library/fast_dds_2.hpp"
#else
#include "dds/library/fast_dds_3.hpp"
#endif

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include <cstdint>

namespace vdrive::wire {

/// How fast a reliable writer repeats itself.
struct WriterTimes {
  LibraryDuration first_heartbeat;
  LibraryDuration heartbeat_period;
  LibraryDuration nack_response;
};

void set_times(dds::DataWriterQos& qos, const WriterTimes& times);

/// How fast a reliable reader answers.
struct ReaderTimes {
  LibraryDuration first_acknack;
  LibraryDuration heartbeat_response;
};

void set_times(dds::DataReaderQos& qos, const ReaderTimes& times);

/// Makes a participant a client of discovery servers.
void add_discovery_server(const rtps::Locator_t& server, dds::DomainParticipantQos& qos);

/// Takes no announcement that is larger. Call after add_discovery_server().
void limit_announcements(dds::DomainParticipantQos& qos, std::uint32_t largest);

/// Keeps descriptions of types off the wire.
void announce_no_types(dds::DomainParticipantQos& qos);

/// Lets samples within a process take the way through the transport. Before the first participant.
/// The default of 2.9 and 3.1 runs a listener in the thread of the writer.
void deliver_through_the_transport();

/// @return whether the library has taken the sample.
[[nodiscard]] bool write_to(dds::DataWriter& writer, void* sample);

}  // namespace vdrive::wire
