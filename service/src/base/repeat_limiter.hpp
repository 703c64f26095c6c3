// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// Lets one line of a log through a second, and counts those left out.
class RepeatLimiter {
 public:
  static constexpr std::chrono::seconds kWindow{1};

  /// @return how many were left out since the last one that passed; nothing = leave this one out.
  std::optional<std::uint64_t> pass(std::chrono::steady_clock::time_point now) noexcept {
    if (now < next_) {
      ++suppressed_;
      return std::nullopt;
    }
    next_ = now + kWindow;
    const std::uint64_t suppressed = suppressed_;
    suppressed_ = 0;
    return suppressed;
  }

 private:
  std::chrono::steady_clock::time_point next_{};
  std::uint64_t suppressed_ = 0;
};

}  // namespace vdrive::service
