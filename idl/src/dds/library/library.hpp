// SPDX-License-Identifier: Apache-2.0
// The differences between Fast DDS 2 and 3: names, and classes derived from those of the library.
// The rest of the wire library names neither version. fast_dds_2 and fast_dds_3 define the same
// interface; CMake compiles the source for the version that it has found.
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

/// Timing of a reliable writer.
struct WriterTimes {
  LibraryDuration first_heartbeat;
  LibraryDuration heartbeat_period;
  LibraryDuration nack_response;
};

void set_times(dds::DataWriterQos& qos, const WriterTimes& times);

/// Timing of a reliable reader.
struct ReaderTimes {
  LibraryDuration first_acknack;
  LibraryDuration heartbeat_response;
};

void set_times(dds::DataReaderQos& qos, const ReaderTimes& times);

/// Makes a participant a client of a discovery server.
void add_discovery_server(const rtps::Locator_t& server, dds::DomainParticipantQos& qos);

/// Rejects announcements larger than `largest` [bytes]. Call after add_discovery_server().
void limit_announcements(dds::DomainParticipantQos& qos, std::uint32_t largest);

/// Keeps descriptions of types off the wire.
void announce_no_types(dds::DomainParticipantQos& qos);

/// Makes samples within a process go through the transport; call before the first participant. By
/// default 2.9 and 3.1 run a listener in the writing thread.
void deliver_through_the_transport();

/// @return whether the library has accepted the sample.
[[nodiscard]] bool write_to(dds::DataWriter& writer, void* sample);

}  // namespace vdrive::wire
