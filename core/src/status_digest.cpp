// SPDX-License-Identifier: Apache-2.0
#include "vdrive/status_digest.hpp"

#include "scramble.hpp"
#include "status_member_table.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

namespace vdrive {
namespace {

constexpr std::uint64_t kPrime = 1099511628211ULL;  // FNV-1a, over words of 64 bits
constexpr std::uint64_t kOffset = 14695981039346656037ULL;

constexpr std::uint32_t fold(std::uint64_t value) noexcept {
  return static_cast<std::uint32_t>(value ^ (value >> 32U));
}

/// A status image as words.
using Words = std::array<std::uint64_t, (sizeof(AxisStatus) + 7) / 8>;

static_assert(std::has_unique_object_representations_v<AxisStatus>, "no padding in the check");

/// Odd factors, which cannot cancel a difference in a single word.
constexpr Words kKeys = [] {
  Words keys{};
  for (std::size_t word = 0; word < keys.size(); ++word) keys[word] = scramble(word) | 1U;
  return keys;
}();

std::uint64_t hash_of(const AxisStatus& status) noexcept {
  Words words{};
  std::memcpy(words.data(), &status, sizeof(status));
  std::uint64_t sum = 0;
  for (std::size_t word = 0; word < words.size(); ++word) sum += words[word] * kKeys[word];
  return scramble(sum);
}

constexpr std::size_t kColumns = 24;  // the members, rounded up to whole vectors

/// Every member in its own word.
using Columns = std::array<std::uint32_t, kColumns>;

/// Unrolled, so that the calls into the table become moves.
template <std::size_t... kMember>
void widen(const AxisStatus& status, Columns& columns,
           std::index_sequence<kMember...> /*members*/) noexcept {
  ((columns[kMember] = static_cast<std::uint32_t>(kStatusMemberTable[kMember].value(status))), ...);
}

}  // namespace

StatusDigest digest_of(std::span<const AxisStatus> statuses, std::size_t axes_per_row,
                       std::span<std::uint32_t> rows) noexcept {
  Columns sums{};
  std::uint64_t image = kOffset;
  std::uint64_t row = kOffset;
  std::size_t left_in_row = axes_per_row;
  std::size_t row_number = 0;
  Columns columns{};
  for (std::size_t axis = 0; axis < statuses.size(); ++axis) {
    widen(statuses[axis], columns, std::make_index_sequence<kStatusMembers>{});
    for (std::size_t column = 0; column < kColumns; ++column) {
      sums[column] = sums[column] * 31U + columns[column];  // 31 is odd: no difference is lost
    }
    const std::uint64_t axis_row = hash_of(statuses[axis]);
    image = (image ^ axis_row) * kPrime;
    row = (row ^ axis_row) * kPrime;
    --left_in_row;
    if (left_in_row == 0 || axis + 1 == statuses.size()) {
      if (row_number < rows.size()) rows[row_number] = fold(row);
      ++row_number;
      row = kOffset;
      left_in_row = axes_per_row;
    }
  }
  StatusDigest digest{.image = image};
  std::copy_n(sums.begin(), kStatusMembers, digest.members.begin());
  return digest;
}

}  // namespace vdrive
