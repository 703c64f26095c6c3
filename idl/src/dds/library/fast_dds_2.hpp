// SPDX-License-Identifier: Apache-2.0
// Fast DDS 2.9.
#pragma once

#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/config.h>
#include <fastrtps/utils/IPFinder.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/utils/md5.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::wire {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

using LibraryDuration = eprosima::fastrtps::Duration_t;
using LibraryMd5 = MD5;

inline constexpr const char* kLibraryVersion = FASTRTPS_VERSION_STR;

/// Whether a closed participant accepts an unencrypted announcement that a member has left.
inline constexpr bool kMembersMayLeaveInClear = true;

inline bool is_ok(const eprosima::fastrtps::types::ReturnCode_t& code) {
  return code == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
}

/// A type whose samples are bytes.
class LibraryType : public dds::TopicDataType {
 public:
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    return encode(data, *payload);
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    return decode(*payload, data);
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [size = bytes_of(data).size()] {
      return static_cast<std::uint32_t>(size);
    };
  }

  void* createData() override { return make(); }

  void deleteData(void* data) override { drop(data); }

  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5) override {
    return put_key(bytes_of(data), *handle, force_md5);
  }

 protected:
  LibraryType(const std::string& name, std::size_t largest, bool has_key) {
    setName(name.c_str());
    m_typeSize = static_cast<std::uint32_t>(largest);
    m_isGetKeyDefined = has_key;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
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
                                // NOLINTNEXTLINE(*-rvalue-reference-param-not-moved)
                                rtps::ParticipantDiscoveryInfo&& info) override {
    using Info = rtps::ParticipantDiscoveryInfo;
    if (info.status == Info::REMOVED_PARTICIPANT || info.status == Info::DROPPED_PARTICIPANT) {
      lose(info.info.m_guid);
    } else {
      find(info.info.m_guid, info.info.m_participantName.to_string(),
           info.info.m_userData.getValue());
    }
  }

 protected:
  /// Also called when the announcement of a participant has changed.
  virtual void find(const rtps::GUID_t& guid, const std::string& name,
                    const std::vector<rtps::octet>& user_data) = 0;
  virtual void lose(const rtps::GUID_t& guid) = 0;
};

/// Wraps another transport and sees each datagram before that transport sends it.
class ObservingTransport : public eprosima::fastdds::rtps::ChainingTransport {
 public:
  using ChainingTransport::ChainingTransport;

  bool send(rtps::SenderResource* low, const std::uint8_t* bytes, std::uint32_t size,
            rtps::LocatorsIterator* first, rtps::LocatorsIterator* last,
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
