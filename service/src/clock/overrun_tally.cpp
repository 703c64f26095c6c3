// SPDX-License-Identifier: Apache-2.0
#include "clock/overrun_tally.hpp"

#include <algorithm>

namespace vdrive::service {

std::optional<Overruns> OverrunTally::note(std::chrono::nanoseconds now,
                                           std::chrono::nanoseconds late) noexcept {
  using std::chrono::microseconds;
  if (late > std::chrono::nanoseconds::zero()) {
    if (overruns_.count == 0) first_ = now;
    ++overruns_.count;
    overruns_.worst = std::max(overruns_.worst, std::chrono::duration_cast<microseconds>(late));
  }
  if (overruns_.count == 0 || now < end_) return std::nullopt;
  Overruns report = overruns_;
  report.span = std::chrono::duration_cast<std::chrono::milliseconds>(now - first_);
  overruns_ = {};
  const bool continues = span_.count() != 0 && now - end_ <= span_;
  span_ = continues ? std::min<std::chrono::nanoseconds>(2 * span_, kLongestSpan) : kShortestSpan;
  end_ = now + span_;
  return report;
}

}  // namespace vdrive::service
