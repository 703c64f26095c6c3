// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace vdrive::wire {

inline constexpr std::size_t kKeyHashSize = 16;

/// The key members of a sample in the form that DDS compares: each with its most significant byte
/// first, aligned as in CDR with zeros as padding.
struct MessageKey {
  std::array<std::byte, kKeyHashSize> bytes{};
  std::size_t size = 0;

  friend auto operator<=>(const MessageKey&, const MessageKey&) = default;
};

/// Functions for the messages of a topic, for code that knows the type only by its number.
struct MessageSupport {
  std::size_t largest_sample;  ///< with every sequence and text at its bound [bytes]
  /// @return the size of the sample; only as much of it as fits is written.
  std::size_t (*encode)(const void* message, std::span<std::byte> output) noexcept;
  Decoding (*decode)(std::span<const std::byte> sample, void* message);
  /// @return the key of a sample; all 0 for one that is too short.
  MessageKey (*key)(std::span<const std::byte> sample) noexcept;
};

/// @return the functions for the topic, from the rows of topics.hpp.
[[nodiscard]] const MessageSupport& support_of(TopicId topic) noexcept;

[[nodiscard]] Decoding decoding_of(const CdrReader& reader) noexcept;

}  // namespace vdrive::wire
