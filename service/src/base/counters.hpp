// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// A number that only grows: any thread counts up, others read.
class Counter {
 public:
  void add(std::uint64_t amount = 1) noexcept {
    value_.fetch_add(amount, std::memory_order_relaxed);
  }

  [[nodiscard]] std::uint64_t get() const noexcept {
    return value_.load(std::memory_order_relaxed);
  }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// A number that rises and falls: one thread sets it, others read.
template <typename Value = std::uint64_t>
class Gauge {
 public:
  void set(Value value) noexcept { value_.store(value, std::memory_order_relaxed); }

  [[nodiscard]] Value get() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<Value> value_{};
};

/// The number of a tick and how many ticks the number has jumped over until then. One thread sets
/// them, others read both as they belong together.
class TickNumber {
 public:
  struct Reading {
    std::uint64_t tick = 0;
    std::uint64_t skipped = 0;
  };

  void set(std::uint64_t tick) noexcept { tick_.store(tick, std::memory_order_release); }

  /// The number jumps to `tick`. @param skipped all that it has jumped over by now
  void jump(std::uint64_t tick, std::uint64_t skipped) noexcept {
    begun_.store(skipped, std::memory_order_release);
    tick_.store(tick, std::memory_order_release);
    ended_.store(skipped, std::memory_order_release);
  }

  [[nodiscard]] std::uint64_t get() const noexcept { return tick_.load(std::memory_order_acquire); }

  /// In the opposite order of jump(): a jump meanwhile shows two different counts.
  [[nodiscard]] Reading read() const noexcept {
    while (true) {
      const std::uint64_t skipped = ended_.load(std::memory_order_acquire);
      const std::uint64_t tick = tick_.load(std::memory_order_acquire);
      if (begun_.load(std::memory_order_acquire) == skipped) return {tick, skipped};
    }
  }

 private:
  std::atomic<std::uint64_t> begun_{0};
  std::atomic<std::uint64_t> tick_{0};
  std::atomic<std::uint64_t> ended_{0};
};

/// Counts the refusals by reason (REASON_... or a CiA 301 abort code). Bounded: there are more
/// slots than reasons.
class RefusalCounters {
 public:
  struct Count {
    std::uint32_t reason = 0;
    std::uint64_t count = 0;
  };

  void add(std::uint32_t reason) noexcept {
    for (Slot& slot : slots_) {
      std::uint32_t holds = slot.reason.load(std::memory_order_relaxed);
      if (holds == 0 && slot.reason.compare_exchange_strong(holds, reason)) holds = reason;
      if (holds == reason) {
        slot.count.add();
        return;
      }
    }
  }

  /// @return the reasons that were given at least once, the one given first at the front.
  [[nodiscard]] std::vector<Count> counts() const {
    std::vector<Count> counts;
    for (const Slot& slot : slots_) {
      if (const std::uint64_t count = slot.count.get(); count != 0) {
        counts.push_back({slot.reason.load(std::memory_order_relaxed), count});
      }
    }
    return counts;
  }

 private:
  struct Slot {
    std::atomic<std::uint32_t> reason{0};
    Counter count;
  };

  std::array<Slot, 64> slots_;
};

/// What a bench counts and measures from its start on, and shows in bench_state.
struct Counters {
  static constexpr std::size_t kLatenessBins = 32;

  TickNumber tick;  ///< last completed
  Counter ticks_run;
  Counter overruns;
  Counter jumps;
  std::array<Counter, kLatenessBins> lateness;  ///< bin i: below 2^i µs
  Counter lateness_sum_ns;
  Gauge<> pending_frames;
  Counter frames_received;
  Counter frames_refused;
  Counter commands_applied;
  Counter commands_refused;
  RefusalCounters refusals;
  Counter set_points_ignored;
  Counter requests_answered;
  Counter status_frames_sent;
  Counter axis_samples_sent;
  Counter events_sent;
  Counter queue_overflows;
  Counter status_images_lost;   ///< of `queue_overflows`: between the tick and the status thread
  Counter status_samples_lost;  ///< of `queue_overflows`: between engine and wire
  Counter malformed;            ///< samples that arrived and could not be decoded
  Counter wire_starts;          ///< wires started, the first one included
  Gauge<> wire_is_up;           ///< 1 while the wire runs
  Gauge<> wire_resident;        ///< memory of its process [bytes], 0 = it has none of its own
  Counter datagrams_dropped;    ///< datagrams that the guard in front of the DDS library dropped
  Counter master_losses;
  Gauge<> longest_silence_us;  ///< of an owner of axes, in drive time
  Counter saves;               ///< axes whose stored parameters became durable
  Counter save_failures;       ///< axes whose parameters could not be stored
  Gauge<> snapshots;           ///< kept now
  Counter journal_ticks;       ///< written
  Counter journal_losses;      ///< ticks that are missing in the journal
  Gauge<double> rate;          ///< realtime: drive time over wall time, 0 = paused
  Gauge<> steppers;            ///< lock-step: sessions that joined the clock
  Gauge<> slowest_stepper;     ///< session that granted the fewest ticks, 0 = none
  Counter wall_steps;          ///< steps of the wall clock that were seen
  Gauge<double> wall_offset;   ///< of the wall clock ahead of drive time [s]

  /// Counts a tick that started `late` after its time.
  void count_lateness(std::chrono::nanoseconds late) noexcept {
    const auto microseconds =
        late.count() > 0 ? static_cast<std::uint64_t>(late.count()) / 1'000 : 0;
    lateness_sum_ns.add(static_cast<std::uint64_t>(std::max<std::int64_t>(late.count(), 0)));
    const auto bin = static_cast<std::size_t>(std::bit_width(microseconds));
    lateness[bin < kLatenessBins ? bin : kLatenessBins - 1].add();
  }
};

}  // namespace vdrive::service
