// SPDX-License-Identifier: Apache-2.0
#include "receive_coalescing.hpp"

#include <algorithm>

namespace vdrive::wire {

std::chrono::microseconds ReceiveCoalescing::pause_after(std::size_t bytes,
                                                         Clock::time_point arrived) noexcept {
  if (longest_.count() == 0) return {};
  bytes_ += bytes;
  if (arrived - resumed_ <= kIdle) return {};
  // At the same rate, kMostOfPause bytes arrive in this time.
  const auto room = pause_ * static_cast<std::int64_t>(kMostOfPause) /
                    static_cast<std::int64_t>(std::max<std::size_t>(bytes_, 1));
  pause_ = std::clamp<std::chrono::microseconds>(room, std::chrono::microseconds(1), longest_);
  bytes_ = 0;
  return pause_;
}

}  // namespace vdrive::wire
