// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>

namespace vdrive::bridge {

/// Limits how often something is done: a mean rate, and bursts above it.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param rate [1/s] in the long run, above 0
  /// @param burst at once
  RateLimit(double rate, double burst) : rate_(rate), burst_(burst), left_(burst) {}

  /// @param amount of what is done now
  /// @return false when it is too much; then nothing is counted.
  [[nodiscard]] bool take(Clock::time_point now, double amount = 1.0) {
    if (last_ != Clock::time_point{}) {
      const double seconds = std::chrono::duration<double>(now - last_).count();
      left_ = std::min(burst_, left_ + std::max(seconds, 0.0) * rate_);
    }
    last_ = now;
    if (left_ < amount) return false;
    left_ -= amount;
    return true;
  }

 private:
  double rate_;
  double burst_;
  double left_;
  Clock::time_point last_{};
};

}  // namespace vdrive::bridge
