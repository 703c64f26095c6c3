// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/topics.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Messages as bytes: plain CDR (XCDR version 1) after the four bytes of the RTPS encapsulation, as
/// they stand in a DDS sample.
namespace vdrive::wire {

/// What became of a sample.
enum class Decoding : std::uint8_t {
  good,
  malformed,      ///< it ends early, or is no plain CDR: nothing in it can be trusted
  beyond_bounds,  ///< a sequence is longer than the IDL allows: only what stands in front was read
};

/// The same as the functions below, for the message of a topic by its address.
[[nodiscard]] std::size_t encoded_size(TopicId topic, const void* message) noexcept;
std::size_t encode(TopicId topic, const void* message, std::span<std::byte> output) noexcept;
[[nodiscard]] Decoding decode(TopicId topic, std::span<const std::byte> sample, void* message);

/// @return how many bytes `encode` needs. For every message type of topics.hpp.
template <typename Message>
[[nodiscard]] std::size_t encoded_size(const Message& message) noexcept {
  return encoded_size(Topic<Message>::kId, &message);
}

/// Writes the sample of `message`, in the byte order of this machine. Allocates nothing.
/// @return how many bytes were written; 0 when `output` is shorter than `encoded_size`.
template <typename Message>
std::size_t encode(const Message& message, std::span<std::byte> output) noexcept {
  return encode(Topic<Message>::kId, &message, output);
}

/// Reads the sample of a message type of topics.hpp. Texts beyond their bound are cut. Allocates
/// nothing once the message has had its largest size, but for sequences within sequences.
template <typename Message>
[[nodiscard]] Decoding decode_checked(std::span<const std::byte> sample, Message& message) {
  return decode(Topic<Message>::kId, sample, &message);
}

/// The same. @return whether the decoding was good.
template <typename Message>
[[nodiscard]] bool decode(std::span<const std::byte> sample, Message& message) {
  return decode_checked(sample, message) == Decoding::good;
}

/// Reads what clients send. Checks every length before it is used, throws nothing, and allocates
/// nothing once each message has had its largest size.
class CommandDecoder {
 public:
  /// @param spare commands whose objects have room from the beginning; further ones get theirs
  ///        when they are first needed
  explicit CommandDecoder(std::size_t spare = 0);

  /// `frame` has room for the largest message after the first call.
  /// @return with beyond_bounds: `too_long` says of which sequence
  [[nodiscard]] Decoding decode(std::span<const std::byte> sample, msg::CommandFrame& frame);
  [[nodiscard]] Decoding decode(std::span<const std::byte> sample, msg::Request& request);

  /// @return the sequence that was beyond its bound in the last sample, too_many_axes or
  ///         too_many_objects; otherwise none.
  [[nodiscard]] msg::Reason too_long() const noexcept { return too_long_; }

 private:
  void resize(std::vector<msg::AxisCommand>& axes, std::size_t count);
  Decoding result_of(const CdrReader& reader) noexcept;

  std::vector<msg::AxisCommand> spare_;  ///< keep the capacity of their sequences
  msg::Reason too_long_{};
};

}  // namespace vdrive::wire
