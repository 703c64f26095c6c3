// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messages.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <vector>

namespace vdrive::service {

/// A number that only grows. Any thread may add to it or read it.
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

/// A number that rises and falls. One thread sets it, others read it.
template <typename Value = std::uint64_t>
class Gauge {
 public:
  void set(Value value) noexcept { value_.store(value, std::memory_order_relaxed); }

  [[nodiscard]] Value get() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<Value> value_{};
};

/// The number of a tick, and how many ticks the number has jumped over so far. One thread sets
/// them, others read a consistent pair.
class TickNumber {
 public:
  struct Reading {
    std::uint64_t tick = 0;
    std::uint64_t skipped = 0;
  };

  void set(std::uint64_t tick) noexcept { tick_.store(tick, std::memory_order_release); }

  /// Makes the number jump to `tick`. @param skipped all ticks jumped over so far
  void jump(std::uint64_t tick, std::uint64_t skipped) noexcept {
    begun_.store(skipped, std::memory_order_release);
    tick_.store(tick, std::memory_order_release);
    ended_.store(skipped, std::memory_order_release);
  }

  [[nodiscard]] std::uint64_t get() const noexcept { return tick_.load(std::memory_order_acquire); }

  /// Reads in the reverse order of jump(), so that a jump in between shows as two different counts.
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

/// Counts refusals by reason (REASON_... or a CiA 301 abort code). The number of slots is fixed and
/// larger than the number of reasons.
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

  /// @return the reasons that occurred, in the order of their first occurrence.
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

/// All counters and measurements of a bench since its start. `kCounterRows` publishes them.
struct Counters {
  static constexpr std::size_t kLatenessBins = 32;

  TickNumber tick;  ///< last completed tick
  Counter ticks_run;
  Counter overruns;
  Counter jumps;
  std::array<Counter, kLatenessBins> lateness;  ///< bin i: below 2^i µs
  Counter lateness_sum_ns;
  Gauge<> inbox_depth;
  Gauge<> outbox_depth;
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
  Counter status_images_lost;   ///< part of `queue_overflows`: on the way to the status thread
  Counter status_samples_lost;  ///< part of `queue_overflows`: on the way to the wire
  Counter malformed;            ///< received samples that could not be decoded
  Counter wire_starts;          ///< wires started, including the first one
  Gauge<> wire_is_up;           ///< 1 while the wire runs
  Gauge<> wire_resident;        ///< memory of the wire's process [bytes], 0 = no separate process
  Counter datagrams_dropped;    ///< datagrams that the guard in front of the DDS library dropped
  Counter master_losses;
  Gauge<> longest_silence_us;  ///< of an owner of axes, in drive time
  Counter saves;               ///< axes whose stored parameters became durable
  Counter save_failures;       ///< axes whose parameters could not be stored
  Gauge<> snapshots;           ///< kept at present
  Counter journal_ticks;       ///< written
  Counter journal_losses;      ///< ticks missing from the journal
  Gauge<double> rate;          ///< realtime: drive time over wall time, 0 = paused
  Gauge<> steppers;            ///< lock-step: sessions that joined the clock
  Gauge<> slowest_stepper;     ///< session that granted the fewest ticks, 0 = none
  Counter wall_steps;          ///< steps of the wall clock that were detected
  Gauge<double> wall_offset;   ///< by which the wall clock is ahead of drive time [s]

  /// Counts a tick that started `late` after its due time.
  void count_lateness(std::chrono::nanoseconds late) noexcept {
    const auto microseconds =
        late.count() > 0 ? static_cast<std::uint64_t>(late.count()) / 1'000 : 0;
    lateness_sum_ns.add(static_cast<std::uint64_t>(std::max<std::int64_t>(late.count(), 0)));
    const auto bin = static_cast<std::size_t>(std::bit_width(microseconds));
    lateness[bin < kLatenessBins ? bin : kLatenessBins - 1].add();
  }

  [[nodiscard]] std::uint64_t ticks_skipped() const noexcept { return tick.read().skipped; }
};

/// How /metrics shows a number. Adjacent rows with the same name differ in the label `queue`.
struct MetricText {
  std::string_view name{};  ///< ends in _total for a counter
  std::string_view help{};
  std::string_view queue{};
};

/// A figure of bench_state and the source of its value. Its kind, unit and help come from the IDL,
/// and so does its name in /metrics unless `metric` gives another one.
template <typename Value, typename Source>
struct FigureRow {
  Value msg::BenchState::*figure;
  Source Counters::*source;
  MetricText metric{};
};

template <typename Value, typename Source>
FigureRow(Value msg::BenchState::*, Source Counters::*, MetricText = {})
    -> FigureRow<Value, Source>;

/// A number that is only in /metrics.
template <typename Source>
struct MetricRow {
  Source Counters::*source;
  MetricText metric;
};

template <typename Source>
MetricRow(Source Counters::*, MetricText) -> MetricRow<Source>;

/// In the order of /metrics. Does not compile if a figure of the IDL has no row.
inline constexpr std::tuple kCounterRows{
    MetricRow{&Counters::tick, {"vdrive_tick", "Number of the last completed tick"}},
    MetricRow{&Counters::rate,
              {"vdrive_rate", "Requested ratio of drive time to wall time, 0 = paused"}},
    MetricRow{&Counters::ticks_run, {"vdrive_ticks_total", "Ticks that were run"}},
    FigureRow{&msg::BenchState::overruns, &Counters::overruns, {"vdrive_tick_overruns_total"}},
    FigureRow{&msg::BenchState::jumps, &Counters::jumps, {"vdrive_tick_jumps_total"}},
    MetricRow{&Counters::ticks_skipped,
              {"vdrive_ticks_skipped_total", "Ticks skipped by jumps of the tick number: not run"}},
    MetricRow{&Counters::wall_offset,
              {"vdrive_wall_clock_offset_seconds",
               "Wall clock minus drive time; 0 while drive time does not follow the wall clock"}},
    MetricRow{&Counters::wall_steps,
              {"vdrive_wall_clock_steps_total", "Changes of the wall clock that were detected"}},
    MetricRow{&Counters::lateness,
              {"vdrive_tick_lateness_seconds", "Delay of the start of a tick after its due time"}},
    FigureRow{&msg::BenchState::inbox_depth,
              &Counters::inbox_depth,
              {"vdrive_queue_depth", "Messages waiting in a queue", "inbox"}},
    FigureRow{&msg::BenchState::outbox_depth,
              &Counters::outbox_depth,
              {"vdrive_queue_depth", "", "outbox"}},
    FigureRow{&msg::BenchState::pending_frames,
              &Counters::pending_frames,
              {"vdrive_queue_depth", "", "pending_frames"}},
    FigureRow{&msg::BenchState::queue_overflows, &Counters::queue_overflows},
    MetricRow{&Counters::status_images_lost,
              {"vdrive_status_lost_total",
               "Status that was lost because a queue was full: between tick thread and status "
               "thread (images), between engine and wire (wire)",
               "images"}},
    MetricRow{&Counters::status_samples_lost, {"vdrive_status_lost_total", "", "wire"}},
    MetricRow{&Counters::wire_is_up,
              {"vdrive_wire_up", "1 while the service is on the network, 0 while it is not"}},
    FigureRow{&msg::BenchState::wire_starts, &Counters::wire_starts},
    MetricRow{&Counters::wire_resident,
              {"vdrive_wire_resident_bytes",
               "Memory of the network process; 0 = DDS runs in threads of the service"}},
    MetricRow{&Counters::datagrams_dropped,
              {"vdrive_datagrams_dropped_total",
               "Datagrams that were dropped because no conforming program sends them"}},
    MetricRow{&Counters::malformed,
              {"vdrive_malformed_samples_total",
               "Commands and requests that arrived and could not be decoded"}},
    FigureRow{&msg::BenchState::frames_received, &Counters::frames_received},
    FigureRow{&msg::BenchState::frames_refused, &Counters::frames_refused},
    FigureRow{&msg::BenchState::commands_applied, &Counters::commands_applied},
    FigureRow{&msg::BenchState::commands_refused, &Counters::commands_refused},
    FigureRow{&msg::BenchState::set_points_ignored, &Counters::set_points_ignored},
    FigureRow{&msg::BenchState::requests_answered, &Counters::requests_answered},
    FigureRow{
        &msg::BenchState::master_losses, &Counters::master_losses, {"vdrive_watchdog_trips_total"}},
    FigureRow{&msg::BenchState::longest_silence_us, &Counters::longest_silence_us},
    MetricRow{
        &Counters::refusals,
        {"vdrive_refusals_total", "Refusals of frames, commands and requests by their reason"}},
    FigureRow{&msg::BenchState::status_frames_sent, &Counters::status_frames_sent},
    MetricRow{&Counters::axis_samples_sent,
              {"vdrive_axis_samples_sent_total", "Samples of the topic axis"}},
    MetricRow{&Counters::events_sent, {"vdrive_events_sent_total", "Samples of the topic event"}},
    MetricRow{&Counters::saves,
              {"vdrive_saves_total", "Axes whose stored parameters became durable"}},
    MetricRow{&Counters::save_failures,
              {"vdrive_save_failures_total", "Axes whose parameters could not be stored"}},
    FigureRow{&msg::BenchState::journal_ticks, &Counters::journal_ticks},
    FigureRow{&msg::BenchState::journal_losses, &Counters::journal_losses}};

}  // namespace vdrive::service
