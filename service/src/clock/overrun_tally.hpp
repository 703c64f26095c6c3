// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

namespace vdrive::service {

/// Reports late ticks, which end after their deadline, in few events: the first one immediately,
/// later ones as a count at the end of a span. On a machine that is too slow, ticks are late all
/// the time. So the span doubles as long as late ticks continue, and is short again once no tick
/// has been late for twice its length. The caller passes the monotonic time.
class OverrunTally {
 public:
  static constexpr std::chrono::seconds kShortestSpan{1};
  static constexpr std::chrono::seconds kLongestSpan{64};

  /// Notes a tick. Call it after each tick.
  /// @param late by how much the tick ended after its deadline; above 0 = too late
  /// @return the overruns to report now, if any
  std::optional<Overruns> note(std::chrono::nanoseconds now,
                               std::chrono::nanoseconds late) noexcept;

  /// Call it when ticks pause. @return the unreported overruns, if any
  std::optional<Overruns> flush(std::chrono::nanoseconds now) noexcept {
    end_ = std::min(end_, now);
    return note(now, std::chrono::nanoseconds::zero());
  }

 private:
  Overruns overruns_;                  ///< not reported yet, without their span
  std::chrono::nanoseconds first_{0};  ///< when the first of these ticks ended
  std::chrono::nanoseconds span_{0};   ///< length of the present span
  std::chrono::nanoseconds end_{0};    ///< of the present span
};

}  // namespace vdrive::service
