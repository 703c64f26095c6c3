// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "message_support.hpp"

#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace vdrive::wire {

/// Bytes of the key hash of DDS, and the most that the key of a topic has.

/// Sets the key hash of a sample: its key members, each with its highest byte first, or their MD5
/// sum.
/// @param summed bytes of `key` that the sum is made of; 0 = no sum
void set_key(eprosima::fastrtps::rtps::InstanceHandle_t& handle,
             const std::array<std::byte, kKeyHashSize>& key, std::size_t summed);

/// Sets what a type support shows to the network: name, size, key, and no type objects.
void announce_as(const TopicTraits& topic, std::uint32_t largest_sample,
                 eprosima::fastdds::dds::TopicDataType& type);

/// The DDS support of a message type, fit for a network of strangers: no type objects on the wire,
/// no exception out of a malformed payload, and a key computed without memory that threads share.
template <typename Message>
class MessageType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  MessageType() { announce_as(Topic<Message>::kRow.traits, largest_sample<Message>(), *this); }

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<std::uint32_t>(write_sample(
        message_at(data), std::as_writable_bytes(std::span(payload->data, payload->max_size))));
    return payload->length != 0;
  }

  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    return read_sample(std::as_bytes(std::span(payload->data, payload->length)), message_at(data));
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] {
      return static_cast<std::uint32_t>(kEncapsulation +
                                        Message::getCdrSerializedSize(message_at(data)));
    };
  }

  void* createData() override {
    return new Message();  // NOLINT(*-owning-memory): the library gives it back to deleteData
  }

  void deleteData(void* data) override {
    delete static_cast<Message*>(data);  // NOLINT(*-owning-memory)
  }

  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle,
              bool force_md5) override {
    using eprosima::fastcdr::Cdr;
    if (!m_isGetKeyDefined) return false;
    std::array<std::byte, kKeyHashSize> key{};
    // NOLINTNEXTLINE(*-reinterpret-cast): the library has characters
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(key.data()), key.size());
    Cdr cdr(buffer, Cdr::BIG_ENDIANNESS);
    message_at(data).serializeKey(cdr);
    set_key(*handle, key, force_md5 ? cdr.getSerializedDataLength() : 0);
    return true;
  }

 private:
  static Message& message_at(void* data) noexcept { return *static_cast<Message*>(data); }
};

/// @return the type support of the topic's messages, as the rows of topics.hpp have them.
[[nodiscard]] eprosima::fastdds::dds::TypeSupport message_type_of(TopicId topic);

}  // namespace vdrive::wire
