// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"

#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// Decides from observations when a wire must be ended and when the next one is started. Makes no
/// system calls; the caller passes the time.
class WireJudge {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::seconds kLongestStart{10};
  /// A wire whose pumps complete no round in this time hangs.
  static constexpr std::chrono::seconds kLongestRound{2};
  /// A wire that passes no test from outside (WireProbe) in this time counts as deaf.
  static constexpr std::chrono::milliseconds kLongestProbe{4'000};
  /// A wire that ran this long did not fail at its start: the next one starts without delay.
  static constexpr std::chrono::seconds kLongRun{1};
  /// The same for a wire that had to be ended: its successor may well have the same trouble.
  static constexpr std::chrono::seconds kLongRunOfJudged{60};
  /// Pumps that complete no round in this time are late (an idle round takes 20 ms). The process is
  /// then examined, and again at this interval.
  static constexpr std::chrono::milliseconds kLateRound{100};
  static constexpr std::chrono::milliseconds kFirstDelay{100};
  static constexpr std::chrono::milliseconds kLongestDelay{5'000};

  /// The observed state of a wire.
  struct Health {
    bool is_running = false;
    std::uint64_t pump_beats = 0;
    std::uint64_t probe_beats = 0;
    std::uint64_t resident = 0;  ///< [bytes]
  };

  explicit WireJudge(std::uint64_t memory_limit) noexcept : memory_limit_(memory_limit) {}

  /// Notes the start of a wire.
  void note_start(Time now) noexcept;

  /// @return why the wire must be ended now; nullopt = it may continue.
  [[nodiscard]] std::optional<WireLoss> reason_to_end(const Health& health, Time now) noexcept;

  /// @return whether the wire's process must be examined now, because its pumps are late.
  [[nodiscard]] bool needs_examination(Time now) noexcept;

  /// Notes the end of a wire.
  /// @param was_judged it was ended by this judge
  /// @return when the next wire should be started
  [[nodiscard]] Time note_end(Time now, bool was_judged) noexcept;

 private:
  std::uint64_t memory_limit_;
  Time start_{};
  Time judged_{};
  std::optional<Time> running_since_;
  std::uint64_t pump_beats_ = 0;
  std::uint64_t probe_beats_ = 0;
  Time pumped_{};
  Time examined_{};
  Time probed_{};
  std::chrono::milliseconds delay_{0};
};

}  // namespace vdrive::service
