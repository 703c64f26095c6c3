// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

namespace vdrive {

/// Limits how often something is done: a rate in the long run, and a burst after a pause. Time is
/// passed in, so the caller chooses the clock.
class TokenBucket {
 public:
  struct Rate {
    double per_second = 1.0;  ///< [tokens/s], above 0
    double burst = 1.0;       ///< [tokens] available at the same time, at least 1
  };

  /// Starts with a full burst.
  explicit TokenBucket(Rate rate) noexcept : rate_(rate), tokens_(rate.burst) {}

  /// Adds the tokens due since the last call.
  /// @param now time since any fixed origin; a time before the last call adds nothing
  void refill(std::chrono::nanoseconds now) noexcept {
    const double seconds = std::chrono::duration<double>(now - refilled_).count();
    tokens_ = std::min(rate_.burst, tokens_ + std::max(seconds, 0.0) * rate_.per_second);
    refilled_ = now;
  }

  /// @return whether less than one token is left.
  [[nodiscard]] bool is_empty() const noexcept { return tokens_ < 1.0; }

  /// Takes `tokens`. @return false when there are fewer, in which case none is taken.
  bool take(double tokens = 1.0) noexcept {
    if (tokens_ < tokens) return false;
    tokens_ -= tokens;
    return true;
  }

 private:
  Rate rate_;
  double tokens_;
  std::chrono::nanoseconds refilled_{};
};

/// Limits how many reports, such as log lines, get through, and counts the ones left out.
class CountingLimit {
 public:
  /// Starts with a full burst.
  explicit CountingLimit(TokenBucket::Rate rate) noexcept : bucket_(rate) {}

  /// @param now as in TokenBucket::refill()
  /// @return how many reports were left out since the last one that passed; nothing if this one
  ///         must be left out too.
  std::optional<std::uint64_t> pass(std::chrono::nanoseconds now) noexcept {
    bucket_.refill(now);
    if (!bucket_.take()) {
      leave_out();
      return std::nullopt;
    }
    return std::exchange(left_out_, 0);
  }

  /// Counts a report that the caller left out for its own reason.
  void leave_out() noexcept { ++left_out_; }

  /// @return how many reports were left out since the last one that passed.
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }

 private:
  TokenBucket bucket_;
  std::uint64_t left_out_ = 0;
};

}  // namespace vdrive
