// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>

namespace vdrive::service {

/// Limits how often something is done: so many times a second of wall time, and after a pause a
/// burst at once.
class TokenBucket {
 public:
  struct Rate {
    double per_second = 1.0;
    double burst = 1.0;  ///< at least 1
  };

  /// Begins with a whole burst.
  explicit TokenBucket(Rate rate) noexcept : rate_(rate), tokens_(rate.burst) {}

  /// Adds what has become due since the last call.
  void refill(std::chrono::steady_clock::time_point now) noexcept {
    const double seconds = std::chrono::duration<double>(now - refilled_).count();
    tokens_ = std::min(rate_.burst, tokens_ + seconds * rate_.per_second);
    refilled_ = now;
  }

  [[nodiscard]] bool is_empty() const noexcept { return tokens_ < 1.0; }

  /// Takes one token. @return false when there is none.
  bool take() noexcept {
    if (is_empty()) return false;
    tokens_ -= 1.0;
    return true;
  }

 private:
  Rate rate_;
  double tokens_;
  std::chrono::steady_clock::time_point refilled_{};
};

}  // namespace vdrive::service
