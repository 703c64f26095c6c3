// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive {

/// Bitwise comparison: sets of parameters are shared, and ticks skipped, only if not a single bit
/// would differ.
template <typename Numbers>
bool alike(const Numbers& a, const Numbers& b) {
  using Words = std::array<std::uint64_t, sizeof(Numbers) / sizeof(std::uint64_t)>;
  return std::bit_cast<Words>(a) == std::bit_cast<Words>(b);
}

/// Parameters of the blocks of one kind. Most axes of a bank are alike, so equal blocks share one
/// set until one of their axes changes; this keeps the sets in the L1 cache.
template <typename Parameters>
struct ParameterPool {
  std::vector<Parameters> sets;       // initial sets, then one slot per block of this kind
  std::vector<std::uint32_t> in_use;  // by block of this kind
  std::vector<std::uint32_t> own;     // by block of this kind

  void add_block(const Parameters& initial) {
    const auto same = std::ranges::find_if(sets, [&initial](const Parameters& set) {
      return alike(set, initial);
    });
    in_use.push_back(static_cast<std::uint32_t>(same - sets.begin()));
    if (same == sets.end()) sets.push_back(initial);
  }

  void finish() {
    own.resize(in_use.size());
    for (std::uint32_t& place : own) {
      place = static_cast<std::uint32_t>(sets.size());
      sets.emplace_back();
    }
  }

  [[nodiscard]] const Parameters& get(std::size_t block) const {
    ensure(block < in_use.size() && in_use[block] < sets.size(), "a block has its parameters");
    return sets[in_use[block]];
  }

  [[nodiscard]] Parameters& change(std::size_t block) {
    if (in_use[block] != own[block]) {
      sets[own[block]] = sets[in_use[block]];
      in_use[block] = own[block];
    }
    return sets[own[block]];
  }
};

}  // namespace vdrive
