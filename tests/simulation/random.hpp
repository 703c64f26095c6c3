// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::simulation {

/// Numbers from a seed, the same on every machine (splitmix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }

  /// @return a number below `bound`, which is above 0.
  std::uint64_t below(std::uint64_t bound) { return next() % bound; }

  std::int64_t between(std::int64_t lowest, std::int64_t highest) {
    return lowest +
           static_cast<std::int64_t>(below(static_cast<std::uint64_t>(highest - lowest) + 1));
  }

  /// @return true `count` times in a thousand.
  bool per_mille(std::uint64_t count) { return below(1'000) < count; }

  template <typename Value>
  const Value& pick(std::span<const Value> values) {
    return values[below(values.size())];
  }

 private:
  std::uint64_t state_;
};

}  // namespace vdrive::simulation
