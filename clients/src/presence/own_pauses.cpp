// SPDX-License-Identifier: Apache-2.0
#include "presence/own_pauses.hpp"

#include <algorithm>

namespace vdrive::client {

OwnPauses::Clock::duration OwnPauses::note(Clock::time_point now) {
  const Clock::duration gap = now - newest_;
  newest_ = std::max(newest_, now);  // of two threads the later one may come first
  if (gap <= kLongestGap) return {};
  const Clock::duration pause = gap - kPeriod;
  total_ += pause;
  return pause;
}

}  // namespace vdrive::client
