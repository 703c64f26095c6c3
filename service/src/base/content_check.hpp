// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace vdrive::service {

/// @return FNV-1a over words of 64 bits, the last one padded with zeros. Each step is invertible,
///         so a change within one word always changes the result.
[[nodiscard]] inline std::uint64_t check_of(std::span<const std::byte> bytes) {
  std::uint64_t check = 14695981039346656037ULL;
  for (std::size_t position = 0; position < bytes.size(); position += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + position, std::min(sizeof(word), bytes.size() - position));
    check = (check ^ word) * 1099511628211ULL;
  }
  return check;
}

}  // namespace vdrive::service
