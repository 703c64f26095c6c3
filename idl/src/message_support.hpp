// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace vdrive::wire {

inline constexpr std::size_t kKeyHashSize = 16;

/// The key members of a sample as DDS compares them: each with its highest byte first, aligned as
/// in CDR with 0 between them.
struct MessageKey {
  std::array<std::byte, kKeyHashSize> bytes{};
  std::size_t size = 0;

  friend auto operator<=>(const MessageKey&, const MessageKey&) = default;
};

/// What the wire does with the messages of a topic, where their type is known by its number only.
struct MessageSupport {
  std::size_t largest_sample;  ///< with every sequence and text at its bound [bytes]
  /// @return the size of the sample; only as much of it as fits is written.
  std::size_t (*encode)(const void* message, std::span<std::byte> output) noexcept;
  Decoding (*decode)(std::span<const std::byte> sample, void* message);
  /// @return the key of a sample; all 0 for one that is too short.
  MessageKey (*key)(std::span<const std::byte> sample) noexcept;
};

/// @return what the rows of topics.hpp give for the topic.
[[nodiscard]] const MessageSupport& support_of(TopicId topic) noexcept;

[[nodiscard]] Decoding decoding_of(const CdrReader& reader) noexcept;

}  // namespace vdrive::wire
