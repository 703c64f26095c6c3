// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

namespace vdrive::bridge {

/// Follows the axes of a bench tick by tick, and starts again after the bench was lost. Time is
/// passed as an argument; only the functions of types Open and Next wait. For one thread.
class BenchFollower {
 public:
  using Clock = std::chrono::steady_clock;

  /// Waits for a sample, at most for the given time.
  using Next = std::function<client::Result<client::Observation>(std::chrono::milliseconds)>;

  /// Starts following.
  using Open = std::function<client::Result<Next>()>;

  /// Pause after a failure before the next attempt.
  static constexpr std::chrono::milliseconds kRetry{200};

  explicit BenchFollower(Open open) : open_(std::move(open)) {}

  /// Starts following, unless it already does or an attempt failed less than kRetry before `now`.
  /// @return whether this call has started it.
  bool open(Clock::time_point now);

  [[nodiscard]] bool is_open() const noexcept { return static_cast<bool>(next_); }

  void close() { next_ = {}; }

  /// @return the next sample; nothing if none arrived in time, or if the bench was lost: then
  ///         is_open() is false.
  std::optional<client::Observation> next(std::chrono::milliseconds patience);

  /// Waits for a sample and skips those for which a newer one has already arrived.
  /// @return as next()
  std::optional<client::Observation> newest(std::chrono::milliseconds patience);

 private:
  Open open_;
  Next next_;
  Clock::time_point due_{};
};

/// @return the axes of a bench, in their order.
[[nodiscard]] std::vector<client::AxisId> ids_of(const client::BenchInfo& info);

/// @param session must outlive the returned function
/// @return a function that follows these axes and never advances their clock.
[[nodiscard]] BenchFollower::Open follow_axes(client::Session& session,
                                              std::vector<client::AxisId> axes);

/// Waits for `duration`, or until a stop is requested.
void rest(std::chrono::milliseconds duration, const std::stop_token& stop);

}  // namespace vdrive::bridge
