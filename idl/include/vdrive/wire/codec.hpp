// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/topics.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Messages as bytes: the four bytes of the RTPS encapsulation and then plain CDR (XCDR version 1),
/// as in a DDS sample.
namespace vdrive::wire {

/// Result of decoding a sample.
enum class Decoding : std::uint8_t {
  good,
  malformed,      ///< it is truncated or not plain CDR: nothing in it can be trusted
  beyond_bounds,  ///< a sequence is longer than the IDL allows: only what precedes it was read
};

/// Untyped versions of the functions below; `message` points to the message type of `topic`.
[[nodiscard]] std::size_t encoded_size(TopicId topic, const void* message) noexcept;
std::size_t encode(TopicId topic, const void* message, std::span<std::byte> output) noexcept;
[[nodiscard]] Decoding decode(TopicId topic, std::span<const std::byte> sample, void* message);

/// @return the size that `encode` needs [bytes]. For every message type of topics.hpp.
template <typename Message>
[[nodiscard]] std::size_t encoded_size(const Message& message) noexcept {
  return encoded_size(Topic<Message>::kId, &message);
}

/// Writes the sample of `message` in the byte order of this machine. Does not allocate.
/// @return the number of bytes written; 0 if `output` is shorter than `encoded_size`.
template <typename Message>
std::size_t encode(const Message& message, std::span<std::byte> output) noexcept {
  return encode(Topic<Message>::kId, &message, output);
}

/// Reads a sample of a message type of topics.hpp. Strings longer than their bound are truncated.
/// Does not allocate once `message` has had its largest size, except for sequences in sequences.
template <typename Message>
[[nodiscard]] Decoding decode_checked(std::span<const std::byte> sample, Message& message) {
  return decode(Topic<Message>::kId, sample, &message);
}

/// The same. @return whether decoding succeeded.
template <typename Message>
[[nodiscard]] bool decode(std::span<const std::byte> sample, Message& message) {
  return decode_checked(sample, message) == Decoding::good;
}

/// Reads the messages that clients send. Checks every length before using it, throws nothing, and
/// does not allocate once each message has had its largest size.
class CommandDecoder {
 public:
  /// @param spare number of commands whose room for objects is allocated from the start; further
  ///        ones allocate theirs when first needed
  explicit CommandDecoder(std::size_t spare = 0);

  /// After the first call `frame` has room for the largest message.
  /// @return beyond_bounds if a sequence is too long; `too_long` then identifies it
  [[nodiscard]] Decoding decode(std::span<const std::byte> sample, msg::CommandFrame& frame);
  [[nodiscard]] Decoding decode(std::span<const std::byte> sample, msg::Request& request);

  /// @return which sequence of the last sample was beyond its bound: too_many_axes or
  ///         too_many_objects; none if every sequence was within its bound.
  [[nodiscard]] msg::Reason too_long() const noexcept { return too_long_; }

 private:
  void resize(std::vector<msg::AxisCommand>& axes, std::size_t count);
  Decoding result_of(const CdrReader& reader) noexcept;

  /// Commands that are not in use, kept for the capacity of their sequences.
  std::vector<msg::AxisCommand> spare_;
  msg::Reason too_long_{};
};

}  // namespace vdrive::wire
