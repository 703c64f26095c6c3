// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <array>
#include <cstddef>
#include <cstdint>
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

/// @return room for the largest sample of a reader [bytes]. Readers drop what is larger without a
///         report. A message that exceeds a bound of the type by less than its size gets an answer
///         with the reason.
template <typename Message>
std::uint32_t largest_sample() {
  constexpr std::size_t kSubmessageAlignment = 4;
  const std::size_t padded = Message::getMaxCdrSerializedSize() + kSubmessageAlignment - 1;
  return static_cast<std::uint32_t>(2 * (kEncapsulation + padded - padded % kSubmessageAlignment));
}

/// @return the bytes that the key of a topic takes in a sample, behind the encapsulation.
constexpr std::size_t size_of_key(TopicKey key) noexcept {
  switch (key) {
    case TopicKey::bench:
      return 4;
    case TopicKey::bench_and_number:
      return 6;
    case TopicKey::bench_and_session:
      return 16;  // four bytes align the second member
    default:
      return 0;
  }
}

inline constexpr std::size_t kKeyHashSize = 16;

/// @return the key hash of DDS: the key members of a sample, each with its highest byte first, and
///         0 for the bytes between them. All 0 for a sample that is too short.
[[nodiscard]] std::array<std::byte, kKeyHashSize> key_of(std::span<const std::byte> sample,
                                                         TopicKey key) noexcept;

/// What the wire does with the messages of a topic, where their type is known by its number only.
struct MessageSupport {
  std::uint32_t (*largest_sample)();  ///< that a reader takes [bytes]
  std::size_t (*encoded_size)(const void* message);
  std::size_t (*encode)(const void* message, std::span<std::byte> output) noexcept;
  bool (*read)(std::span<const std::byte> sample, void* message) noexcept;
  bool (*within_bounds)(const void* message) noexcept;
};

/// @return what the rows of topics.hpp give for the topic.
[[nodiscard]] const MessageSupport& support_of(TopicId topic) noexcept;

}  // namespace vdrive::wire
