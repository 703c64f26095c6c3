// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/record.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::judge {

/// Intervals between events that should occur once per period. The period is the median of the
/// first ones; the others are counted in a histogram.
class Distances {
 public:
  static constexpr std::size_t kLearnt = 32;

  /// @return the interval in periods, once the period is known.
  std::optional<double> put(Time distance);

  [[nodiscard]] std::optional<Time> period() const noexcept { return period_; }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

  /// @return how many differed from the period by more than a quarter of it.
  [[nodiscard]] std::uint64_t irregular() const noexcept { return irregular_; }

  /// @return the period and the histogram, such as "1 ms (0 shorter than 0.75 periods, 1250 up to
  ///         1.25, 3 up to 2, 1 up to 5, 0 longer; the longest 4 ms)"; "unknown" without a period.
  [[nodiscard]] std::string text() const;

  void reset() { *this = {}; }

 private:
  static constexpr std::array kEnds{0.75, 1.25, 2.0, 5.0};  ///< of the bins, in periods

  std::array<Time, kLearnt> first_{};
  std::optional<Time> period_;
  std::array<std::uint64_t, kEnds.size() + 1> bins_{};
  std::uint64_t count_ = 0;
  std::uint64_t irregular_ = 0;
  Time longest_{};
};

}  // namespace vdrive::judge
