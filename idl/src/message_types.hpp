// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace vdrive::wire {

/// Writes the sample of a message in the byte order of this machine.
/// @return how many bytes were written; 0 when there is not enough room.
template <typename Message>
std::size_t write_sample(const Message& message, std::span<std::byte> output) noexcept {
  using eprosima::fastcdr::Cdr;
  try {
    // The buffer takes a pointer to characters and writes into the bytes of `output` only.
    eprosima::fastcdr::FastBuffer buffer(
        reinterpret_cast<char*>(output.data()),  // NOLINT(*-reinterpret-cast)
        output.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    message.serialize(cdr);
    return cdr.getSerializedDataLength();
  } catch (...) {  // not enough room
    return 0;
  }
}

/// Reads a message whose sequences may be beyond their bounds.
/// @return false when the sample ends early, has an unknown encapsulation or claims an absurd
///         length.
template <typename Message>
bool read_sample(std::span<const std::byte> sample, Message& message) noexcept {
  using eprosima::fastcdr::Cdr;
  try {
    // The buffer takes a mutable pointer; only reading functions are called.
    eprosima::fastcdr::FastBuffer buffer(
        const_cast<char*>(                                  // NOLINT(*-const-cast)
            reinterpret_cast<const char*>(sample.data())),  // NOLINT(*-reinterpret-cast)
        sample.size());
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    cdr.read_encapsulation();
    message.deserialize(cdr);
    return true;
  } catch (...) {
    return false;
  }
}

/// Bytes of the key hash of DDS, and the most that the key of a topic has.
inline constexpr std::size_t kKeyHashSize = 16;

/// Sets the key hash of a sample: its key members, each with its highest byte first, or their MD5
/// sum.
/// @param summed bytes of `key` that the sum is made of; 0 = no sum
void set_key(eprosima::fastrtps::rtps::InstanceHandle_t& handle,
             const std::array<std::byte, kKeyHashSize>& key, std::size_t summed);

/// @return room for the largest sample of a reader [bytes]. Readers drop what is larger without a
///         report. A message that exceeds a bound of the type by less than its size gets an answer
///         with the reason.
template <typename Message>
std::uint32_t largest_sample() {
  constexpr std::size_t kSubmessageAlignment = 4;
  const std::size_t padded = Message::getMaxCdrSerializedSize() + kSubmessageAlignment - 1;
  return static_cast<std::uint32_t>(2 * (kEncapsulation + padded - padded % kSubmessageAlignment));
}

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

/// What the wire does with the messages of a topic, where their type is known by its number only.
struct MessageSupport {
  eprosima::fastdds::dds::TypeSupport (*make_type)();
  std::uint32_t (*largest_sample)();  ///< that a reader takes [bytes]
  std::size_t (*encoded_size)(const void* message);
  std::size_t (*encode)(const void* message, std::span<std::byte> output) noexcept;
  bool (*read)(std::span<const std::byte> sample, void* message) noexcept;
  bool (*within_bounds)(const void* message) noexcept;
};

/// @return what the rows of topics.hpp give for the topic.
[[nodiscard]] const MessageSupport& support_of(TopicId topic) noexcept;

}  // namespace vdrive::wire
