// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"

#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// When a wire is to be ended, and when another one is to be started: decisions from what is seen
/// of it, without system calls. Time is an argument.
class WireJudge {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::seconds kLongestStart{10};
  /// Without a round of the pumps it hangs.
  static constexpr std::chrono::seconds kLongestRound{2};
  /// A probe through discovery and data that does not arrive in this time: the wire receives
  /// nothing.
  static constexpr std::chrono::milliseconds kLongestProbe{4'000};
  /// A wire that ran for this long did not end because of how it was started.
  static constexpr std::chrono::seconds kLongRun{1};
  /// One that had to be ended may be no better when it is started anew.
  static constexpr std::chrono::seconds kLongRunOfJudged{60};
  /// Pumps that make no round for this long are late: a round takes 20 ms where nothing is sent.
  /// The process is then examined, and again at this distance.
  static constexpr std::chrono::milliseconds kLateRound{100};
  static constexpr std::chrono::milliseconds kFirstDelay{100};
  static constexpr std::chrono::milliseconds kLongestDelay{5'000};

  /// What is seen of a wire.
  struct Health {
    bool is_running = false;
    std::uint64_t pump_beats = 0;
    std::uint64_t probe_beats = 0;
    std::uint64_t resident = 0;  ///< [bytes]
  };

  explicit WireJudge(std::uint64_t memory_limit) noexcept : memory_limit_(memory_limit) {}

  /// A wire is started.
  void note_start(Time now) noexcept;

  /// @return why the wire has to be ended now; nothing = it may continue.
  [[nodiscard]] std::optional<WireLoss> reason_to_end(const Health& health, Time now) noexcept;

  /// @return whether its process has to be examined now, because nothing was heard of it.
  [[nodiscard]] bool needs_examination(Time now) noexcept;

  /// A wire has ended.
  /// @param was_judged it was ended by this judge
  /// @return when the next one is to be started.
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
