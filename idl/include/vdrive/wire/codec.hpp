// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/topics.hpp"
#include "vdrive_messages.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Messages as bytes: plain CDR (XCDR version 1) behind the four bytes of the RTPS encapsulation,
/// as they stand in a DDS sample.
namespace vdrive::wire {

/// Bytes of the encapsulation in front of every sample.
inline constexpr std::size_t kEncapsulation = 4;

/// The same as the functions below, for the message of a topic by its address.
[[nodiscard]] std::size_t encoded_size(TopicId topic, const void* message);
std::size_t encode(TopicId topic, const void* message, std::span<std::byte> output) noexcept;
[[nodiscard]] bool decode(TopicId topic, std::span<const std::byte> sample, void* message) noexcept;

/// @return how many bytes `encode` needs. For every message type of topics.hpp.
template <typename Message>
[[nodiscard]] std::size_t encoded_size(const Message& message) {
  return encoded_size(Topic<Message>::kId, &message);
}

/// Writes the sample of `message`, in the byte order of this machine. Allocates nothing.
/// @return how many bytes were written; 0 when `output` is shorter than `encoded_size`.
template <typename Message>
std::size_t encode(const Message& message, std::span<std::byte> output) noexcept {
  return encode(Topic<Message>::kId, &message, output);
}

/// Reads the sample of a message type of topics.hpp that is not on the path of a command.
/// @return false when the sample ends early, has another encapsulation than plain CDR, or a
///         sequence is beyond its bound.
template <typename Message>
[[nodiscard]] bool decode(std::span<const std::byte> sample, Message& message) noexcept {
  return decode(Topic<Message>::kId, sample, &message);
}

/// The result of decoding a sample that a client sent.
enum class Decoding : std::uint8_t {
  good,
  malformed,         ///< nothing in it can be trusted
  too_many_axes,     ///< above MAX_AXES_PER_FRAME: only the head of the message was read
  too_many_objects,  ///< above MAX_OBJECTS_...: likewise
};

/// Reads what clients send. Checks every length before it is used, throws nothing, and allocates
/// nothing once each message has had its largest size.
class CommandDecoder {
 public:
  /// @param spare commands whose objects have room from the beginning; further ones get theirs
  ///        when they are first needed
  explicit CommandDecoder(std::size_t spare = 0);

  /// `frame` has room for the largest message after the first call.
  [[nodiscard]] Decoding decode(std::span<const std::byte> sample, msg::CommandFrame& frame);
  [[nodiscard]] Decoding decode(std::span<const std::byte> sample, msg::Request& request);

 private:
  void resize(std::vector<msg::AxisCommand>& axes, std::size_t count);

  std::vector<msg::AxisCommand> spare_;  ///< keep the capacity of their sequences
};

}  // namespace vdrive::wire
