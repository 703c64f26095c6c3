// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/effort.hpp"

#include <cstdint>
#include <span>

namespace vdrive::test {

/// @return the number of random cases; by day, a build without optimisation runs a tenth of them.
inline std::uint64_t case_count(std::uint64_t by_day, std::uint64_t nightly) {
#ifndef __OPTIMIZE__
  by_day /= 10;
#endif
  return number_of<std::uint64_t>({.usual = by_day, .full = by_day, .nightly = nightly});
}

/// @return the number of random cases of a program compiled with optimisation, such as
///         core_jerk_test; in a build without optimisation always `unoptimised`.
template <typename Number>
[[nodiscard]] Number number_if_optimised([[maybe_unused]] const Effort<Number>& effort,
                                         [[maybe_unused]] Number unoptimised) {
#ifdef __OPTIMIZE__
  return number_of(effort);
#else
  return unoptimised;
#endif
}

/// SplitMix64: the same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }

  /// Uniform in [0, bound).
  std::uint64_t below(std::uint64_t bound) { return bits() % bound; }

  /// Uniform from `lowest` to `highest`.
  std::int64_t between(std::int64_t lowest, std::int64_t highest) {
    return lowest +
           static_cast<std::int64_t>(below(static_cast<std::uint64_t>(highest - lowest) + 1));
  }

  template <typename Value>
  const Value& pick(std::span<const Value> values) {
    return values[below(values.size())];
  }

  /// True `count` times in a thousand.
  bool per_mille(std::uint64_t count) { return below(1'000) < count; }

  /// True once in `n` times.
  bool one_in(std::uint64_t n) { return below(n) == 0; }

  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(bits() >> 11U) * 0x1.0p-53; }

  /// A 32-bit register value: extremes, powers of two and their neighbours, small numbers, any.
  std::uint32_t word() {
    switch (below(6)) {
      case 0:
        return static_cast<std::uint32_t>(below(3));
      case 1:
        return 0xFFFFFFFFU - static_cast<std::uint32_t>(below(3));
      case 2:
        return (1U << below(32)) - 1U + static_cast<std::uint32_t>(below(3));
      case 3:
        return static_cast<std::uint32_t>(bits() >> 32U) >> below(32);
      case 4:
        return 0x80000000U - 1U + static_cast<std::uint32_t>(below(3));
      default:
        return static_cast<std::uint32_t>(bits() >> 32U);
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace vdrive::test
