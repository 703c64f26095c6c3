// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"

#include <chrono>
#include <cstdint>
#include <map>

namespace vdrive::ros2 {

/// When the joint states of benches are published. In lock-step a state is published after each
/// period of drive time and where a step ends, else at the rate in wall time. While no tick passes
/// the state is repeated once a second. Time is an argument.
class StateTimes {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param rate states a second
  explicit StateTimes(double rate)
      : rate_(rate),
        period_(std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(1.0 / rate))) {}

  /// @param tick of the newest state of the bench
  /// @return whether that state is due; then it counts as published.
  [[nodiscard]] bool take(const client::BenchInfo& bench, std::uint64_t tick,
                          Clock::time_point now);

  /// @return when take() has to be asked again, where nobody tells of a new state.
  [[nodiscard]] Clock::time_point next(Clock::time_point now) const;

 private:
  /// What was published of a bench.
  struct Published {
    std::uint64_t incarnation = 0;
    std::uint64_t tick = 0;
    Clock::time_point taken{};  ///< when it was published
    Clock::time_point due{};
    std::uint64_t waiting = 0;  ///< tick that was not published at once
    Clock::time_point waiting_since{};
  };

  [[nodiscard]] bool is_due(Published& published, const client::BenchInfo& bench,
                            std::uint64_t tick, Clock::time_point now) const;
  [[nodiscard]] bool is_due_at_rate(Published& published, Clock::time_point now) const;
  [[nodiscard]] bool is_due_in_lockstep(Published& published, const client::BenchInfo& bench,
                                        std::uint64_t tick, Clock::time_point now) const;

  const double rate_;
  const Clock::duration period_;
  std::map<std::uint32_t, Published> published_;
};

}  // namespace vdrive::ros2
