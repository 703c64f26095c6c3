// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clock/cycle_timer.hpp"
#include "clock/overrun_tally.hpp"
#include "clock/tick_clock.hpp"
#include "engine/bench_engine.hpp"
#include "seam/queues.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// Runs a bench by the wall clock. `cycle` takes no lock and makes no system call except its wait.
/// Only some requests allocate.
class RealtimeDriver {
 public:
  /// The maximum number of arrivals handled in one tick; the others wait for the next tick.
  static constexpr std::size_t kArrivalsPerTick = 256;

  /// The interval at which the status is repeated while paused.
  static constexpr std::chrono::milliseconds kRepeatInterval{20};

  /// Sets the last completed tick of the engine from the wall clock; the first cycle runs the next
  /// one.
  RealtimeDriver(const Configuration& configuration, BenchEngine& engine, Inbox& inbox,
                 Counters& counters, CycleTimer& timer);

  /// Waits for the next tick and runs it. While paused, only handles arrivals.
  void cycle() noexcept;

  /// @return the monotonic time of the next cycle, for threads that follow this one.
  [[nodiscard]] std::chrono::nanoseconds next_cycle() const noexcept {
    return std::chrono::nanoseconds{next_cycle_.load(std::memory_order_relaxed)};
  }

 private:
  void change_rate() noexcept;
  void tick() noexcept;
  void follow_wall_clock() noexcept;
  void idle() noexcept;
  void handle_arrivals();

  BenchEngine& engine_;
  Inbox& inbox_;
  Counters& counters_;
  CycleTimer& timer_;
  std::chrono::microseconds period_;
  std::uint32_t status_every_;
  WallStepPolicy wall_step_policy_;
  double rate_;
  std::optional<TickClock> clock_;  ///< nullopt = paused
  OverrunTally overruns_;
  std::chrono::nanoseconds next_repeat_{0};
  std::atomic<std::int64_t> next_cycle_{0};
};

}  // namespace vdrive::service
