// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

namespace vdrive::service {

/// Ticks that ended too late, told as few events: the first one at once, those after it as a count
/// at the end of a span. A machine that is too slow has some in each second; so the span doubles
/// while they continue, and is short again once twice its length has passed without any. Monotonic
/// time is an argument.
class OverrunTally {
 public:
  static constexpr std::chrono::seconds kShortestSpan{1};
  static constexpr std::chrono::seconds kLongestSpan{64};

  /// After each tick.
  /// @param late how far it ended past its deadline, above 0 = too late
  /// @return what is to be reported now, if anything.
  std::optional<Overruns> note(std::chrono::nanoseconds now,
                               std::chrono::nanoseconds late) noexcept;

  /// Ticks pause. @return what has not been reported yet.
  std::optional<Overruns> flush(std::chrono::nanoseconds now) noexcept {
    end_ = std::min(end_, now);
    return note(now, std::chrono::nanoseconds::zero());
  }

 private:
  Overruns overruns_;                  ///< not reported yet, without their span
  std::chrono::nanoseconds first_{0};  ///< when the first of them ended
  std::chrono::nanoseconds span_{0};   ///< without a report
  std::chrono::nanoseconds end_{0};    ///< of the span
};

}  // namespace vdrive::service
