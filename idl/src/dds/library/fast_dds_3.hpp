// SPDX-License-Identifier: Apache-2.0
// Fast DDS 3.1.
#pragma once

#include <fastdds/config.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.hpp>
#include <fastdds/rtps/transport/ChainingTransport.hpp>
#include <fastdds/rtps/transport/TransportReceiverInterface.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.hpp>
#include <fastdds/utils/IPFinder.hpp>
#include <fastdds/utils/IPLocator.hpp>
#include <fastdds/utils/md5.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace vdrive::wire {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastdds::rtps;

using LibraryDuration = dds::Duration_t;
using LibraryMd5 = eprosima::fastdds::MD5;

inline constexpr const char* kLibraryVersion = FASTDDS_VERSION_STR;

/// Whether a closed participant accepts an unencrypted announcement that a member has left. It does
/// not: PDPListener::on_new_cache_change_added requires a matched writer, and a member is matched
/// only by its encrypted announcements (PDPSimple::notifyAboveRemoteEndpoints). Only the library
/// can detect, by the lease, that a member has ended without announcing it.
inline constexpr bool kMembersMayLeaveInClear = false;

inline bool is_ok(dds::ReturnCode_t code) {
  return code == dds::RETCODE_OK;
}

/// A type whose samples are bytes.
class LibraryType : public dds::TopicDataType {
 public:
  bool serialize(const void* data, rtps::SerializedPayload_t& payload,
                 dds::DataRepresentationId_t /*representation*/) override {
    return encode(data, payload);
  }

  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override {
    return decode(payload, data);
  }

  std::uint32_t calculate_serialized_size(const void* data,
                                          dds::DataRepresentationId_t /*representation*/) override {
    return static_cast<std::uint32_t>(bytes_of(data).size());
  }

  void* create_data() override { return make(); }

  void delete_data(void* data) override { drop(data); }

  bool compute_key(rtps::SerializedPayload_t& payload, rtps::InstanceHandle_t& handle,
                   bool force_md5) override {
    // NOLINTNEXTLINE(*-reinterpret-cast): the library has octets
    return put_key({reinterpret_cast<const std::byte*>(payload.data), payload.length}, handle,
                   force_md5);
  }

  bool compute_key(const void* data, rtps::InstanceHandle_t& handle, bool force_md5) override {
    return put_key(bytes_of(data), handle, force_md5);
  }

 protected:
  LibraryType(const std::string& name, std::size_t largest, bool has_key) {
    set_name(name);
    max_serialized_type_size = static_cast<std::uint32_t>(largest);
    is_compute_key_provided = has_key;
  }

  [[nodiscard]] virtual std::span<const std::byte> bytes_of(const void* data) const noexcept = 0;
  virtual bool encode(const void* data, rtps::SerializedPayload_t& payload) = 0;
  virtual bool decode(const rtps::SerializedPayload_t& payload, void* data) = 0;
  virtual bool put_key(std::span<const std::byte> sample, rtps::InstanceHandle_t& handle,
                       bool force_md5) = 0;
  virtual void* make() = 0;
  virtual void drop(void* data) = 0;
};

/// Learns which other participants exist.
class ParticipantListener : public dds::DomainParticipantListener {
 public:
  void on_participant_discovery(dds::DomainParticipant* /*participant*/,
                                rtps::ParticipantDiscoveryStatus status,
                                const dds::ParticipantBuiltinTopicData& info,
                                bool& /*should_be_ignored*/) override {
    using Status = rtps::ParticipantDiscoveryStatus;
    if (status == Status::DISCOVERED_PARTICIPANT || status == Status::CHANGED_QOS_PARTICIPANT) {
      find(info.guid, info.participant_name.to_string(), info.user_data.getValue());
    } else {
      lose(info.guid);
    }
  }

 protected:
  /// Also called when the announcement of a participant has changed.
  virtual void find(const rtps::GUID_t& guid, const std::string& name,
                    const std::vector<rtps::octet>& user_data) = 0;
  virtual void lose(const rtps::GUID_t& guid) = 0;
};

/// Wraps another transport and sees each datagram before that transport sends it.
class ObservingTransport : public rtps::ChainingTransport {
 public:
  using ChainingTransport::ChainingTransport;

  bool send(rtps::SenderResource* low, const std::vector<rtps::NetworkBuffer>& pieces,
            std::uint32_t size, rtps::LocatorsIterator* first, rtps::LocatorsIterator* last,
            const std::chrono::steady_clock::time_point& timeout) override;

 protected:
  /// @param changed holds a modified copy of the same size, if one is needed
  /// @return the bytes to send.
  virtual std::span<const std::uint8_t> sends(std::span<const std::uint8_t> datagram,
                                              std::vector<std::uint8_t>& changed) = 0;
  /// Sends a datagram itself to those of [first, last) to which the library must not send:
  /// stand-ins for host names, and addresses that the library has not announced to its transport.
  /// Called for each socket of the library.
  /// @return whether it has consumed `first`; the library then sends to `rest`.
  virtual bool sends_directly(const rtps::SenderResource& low,
                              std::span<const std::uint8_t> datagram, rtps::LocatorsIterator& first,
                              const rtps::LocatorsIterator& last,
                              std::vector<rtps::Locator_t>& rest) = 0;
};

}  // namespace vdrive::wire
