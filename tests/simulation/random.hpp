// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/support/random_cases.hpp"

#include <cstdint>
#include <span>

namespace vdrive::simulation {

/// Numbers from a seed, the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : numbers_(seed) {}

  std::uint64_t next() { return numbers_.bits(); }

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
  test::Random numbers_;
};

}  // namespace vdrive::simulation
