// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

namespace vdrive::service {

/// One instant on both clocks.
struct Instant {
  std::chrono::nanoseconds monotonic{0};
  std::chrono::nanoseconds wall{0};  ///< since the epoch
};

/// When which tick is due in realtime mode.
///
/// Tick n begins at the wall time n x period, so that benches with synchronised clocks agree. From
/// the first tick on, deadlines are monotonic; at rate 1 their distance is steered towards the wall
/// clock by at most 500 ppm. Up to 100 late ticks are caught up; beyond that the number jumps. At
/// other rates the distance is period / rate and nothing is steered.
///
/// After a pause or a change of the rate the number goes on from where it was: tick n then begins
/// at reference + n x period, and the reference is no longer the epoch.
class TickClock {
 public:
  static constexpr double kMaxSteering = 500e-6;
  static constexpr std::uint64_t kMaxBacklog = 100;

  /// @param rate above 0
  TickClock(std::chrono::microseconds period, double rate, const Instant& now) noexcept;

  /// After a pause: tick `next_tick` is due one interval from now.
  TickClock(std::chrono::microseconds period, double rate, const Instant& now,
            std::uint64_t next_tick) noexcept;

  /// From now on at another rate, above 0; the drive time that is left until the next tick stays.
  void set_rate(double rate, const Instant& now) noexcept;

  /// Number of the next tick.
  [[nodiscard]] std::uint64_t next_tick() const noexcept { return next_tick_; }

  /// Monotonic time at which the next tick is due.
  [[nodiscard]] std::chrono::nanoseconds deadline() const noexcept {
    return std::chrono::nanoseconds{static_cast<std::int64_t>(deadline_)};
  }

  /// @return how many ticks to leave out now: 0 unless the backlog is above 100. They are left out
  ///         by this call.
  [[nodiscard]] std::uint64_t skip_backlog(std::chrono::nanoseconds monotonic_now) noexcept;

  /// The next tick was run; plans the one after it.
  void advance(const Instant& now) noexcept;

 private:
  void rebase(const Instant& now) noexcept;

  double period_;    ///< [ns] of drive time
  double interval_;  ///< [ns] between deadlines before steering
  bool steered_;
  std::uint64_t next_tick_;
  double deadline_;             ///< [ns] monotonic
  std::int64_t reference_ = 0;  ///< wall time of tick 0 [ns]
};

}  // namespace vdrive::service
