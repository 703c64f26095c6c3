// SPDX-License-Identifier: Apache-2.0
#include "judge/distances.hpp"

#include "judge/words.hpp"

#include <algorithm>

namespace vdrive::judge {

std::optional<double> Distances::put(Time distance) {
  if (!period_) {
    first_[static_cast<std::size_t>(count_++)] = distance;
    if (count_ < kLearnt) return std::nullopt;
    auto sorted = first_;
    const auto middle = sorted.begin() + kLearnt / 2;
    std::nth_element(sorted.begin(), middle, sorted.end());
    period_ = std::max(*middle, Time{1});
    return std::nullopt;
  }
  ++count_;
  longest_ = std::max(longest_, distance);
  const double periods =
      static_cast<double>(distance.count()) / static_cast<double>(period_->count());
  const auto end = std::ranges::find_if(kEnds, [periods](double bin_end) {
    return periods < bin_end;
  });
  const auto bin = static_cast<std::size_t>(end - kEnds.begin());
  ++bins_[bin];
  if (bin != 1) ++irregular_;
  return periods;
}

std::string Distances::text() const {
  if (!period_) return "unknown";
  return duration_text(*period_) + " (" + std::to_string(bins_[0]) +
         " shorter than 0.75 periods, " + std::to_string(bins_[1]) + " up to 1.25, " +
         std::to_string(bins_[2]) + " up to 2, " + std::to_string(bins_[3]) + " up to 5, " +
         std::to_string(bins_[4]) + " longer; the longest " + duration_text(longest_) + ")";
}

}  // namespace vdrive::judge
