// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/wall_step_policy.hpp"

#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// One instant on the monotonic and on the wall clock.
struct Instant {
  std::chrono::nanoseconds monotonic{0};
  std::chrono::nanoseconds wall{0};  ///< since 1970
};

/// A step of the wall clock.
struct WallStep {
  std::chrono::nanoseconds offset{0};  ///< wall clock minus drive time
  std::uint64_t jumped = 0;  ///< ticks that the number jumps by; 0 = drive time is steered
};

/// Determines when each tick is due in realtime mode.
///
/// Tick n begins at the wall time n x period, so that benches with synchronised clocks agree. From
/// the first tick on, deadlines are monotonic; at rate 1 their interval is steered towards the wall
/// clock by at most 500 ppm. Up to 100 late ticks are caught up; beyond that the number jumps. At
/// other rates the interval is period / rate and nothing is steered.
///
/// If the offset between wall clock and drive time grows by more than 10 ms, faster than 2,000 ppm,
/// the wall clock was stepped: synchronised clocks agree within 1 ms, and the drift of a crystal
/// and the slewing of a clock together stay below 1,000 ppm. 10 ms is the longest period, so a step
/// is at least one tick, and takes at least 20 s to steer away. Three readings in a row must show
/// the step, because a single one is wrong if the thread is suspended between reading the two
/// clocks.
///
/// After a pause or a change of the rate the number continues from where it was: tick n then begins
/// at reference + n x period, and the reference is no longer the start of 1970.
class TickClock {
 public:
  static constexpr std::uint64_t kMaxBacklog = 100;
  static constexpr std::chrono::milliseconds kStep{10};
  static constexpr double kMaxDrift = 2'000e-6;
  static constexpr int kReadings = 3;

  /// @param rate above 0
  TickClock(std::chrono::microseconds period, double rate, const Instant& now,
            WallStepPolicy policy = WallStepPolicy::steer) noexcept;

  /// For the end of a pause: tick `next_tick` is due one interval from now.
  TickClock(std::chrono::microseconds period, double rate, const Instant& now,
            std::uint64_t next_tick, WallStepPolicy policy = WallStepPolicy::steer) noexcept;

  /// Changes the rate, above 0. The drive time left until the next tick is kept.
  void set_rate(double rate, const Instant& now) noexcept;

  /// @return the number of the next tick.
  [[nodiscard]] std::uint64_t next_tick() const noexcept { return next_tick_; }

  /// @return the monotonic time at which the next tick is due.
  [[nodiscard]] std::chrono::nanoseconds deadline() const noexcept {
    return std::chrono::nanoseconds{static_cast<std::int64_t>(deadline_)};
  }

  /// Skips the late ticks if there are more than 100 of them.
  /// @return how many were skipped
  [[nodiscard]] std::uint64_t skip_backlog(std::chrono::nanoseconds monotonic_now) noexcept;

  /// Call it when the next tick was run: schedules the one after it.
  /// @return the step of the wall clock, if one was detected now
  std::optional<WallStep> advance(const Instant& now) noexcept;

  /// @return how far the wall clock was ahead of drive time in the last tick; 0 at rates other than
  ///         1.
  [[nodiscard]] std::chrono::nanoseconds offset() const noexcept {
    return std::chrono::nanoseconds{static_cast<std::int64_t>(offset_)};
  }

 private:
  [[nodiscard]] double read_offset(const Instant& now) const noexcept;
  [[nodiscard]] bool sees_step() noexcept;
  std::optional<WallStep> watch_wall_clock() noexcept;
  void rebase(const Instant& now) noexcept;

  double period_;    ///< [ns] of drive time
  double interval_;  ///< [ns] between deadlines before steering
  bool steered_;
  WallStepPolicy wall_step_policy_;
  std::uint64_t next_tick_;
  double deadline_;             ///< [ns] monotonic
  std::int64_t reference_ = 0;  ///< wall time of tick 0 [ns]
  double offset_ = 0.0;         ///< wall clock minus drive time [ns]
  double expected_ = 0.0;       ///< the part of the offset that drift explains [ns]
  int deviations_ = 0;          ///< consecutive readings that drift does not explain
};

}  // namespace vdrive::service
