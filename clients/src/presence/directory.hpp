// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"
#include "vdrive/wire/presence.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::client {

/// A tick of a run of a service, with the number of ticks jumped over until then, as status frames
/// and states report them.
struct RunTime {
  std::uint64_t tick = 0;
  std::uint32_t skipped_ticks = 0;  ///< modulo 2^32
};

/// @return the number of ticks run between `from` and `to`, which must not be earlier. Exact below
///         2^32 run ticks; the tick number may jump by more.
[[nodiscard]] constexpr std::uint64_t ticks_run(const RunTime& from, const RunTime& to) noexcept {
  const auto passed = static_cast<std::uint32_t>(to.tick - from.tick);
  return static_cast<std::uint32_t>(passed - (to.skipped_ticks - from.skipped_ticks));
}

/// @return the number of ticks that the tick number jumped over in between.
[[nodiscard]] constexpr std::uint64_t ticks_skipped(const RunTime& from,
                                                    const RunTime& to) noexcept {
  return to.tick - from.tick - ticks_run(from, to);
}

/// A bench whose samples are older than this is absent.
inline constexpr std::chrono::milliseconds kPresence{300};

/// Maximum number of runs and of description parts that a directory keeps. When it is full, a new
/// run replaces the run that has been silent longest, if that silence is at least kForgetAfter;
/// otherwise the new run is ignored.
inline constexpr std::size_t kMostRuns = 1'024;
inline constexpr std::size_t kMostParts = 4'096;
inline constexpr std::chrono::seconds kForgetAfter{60};

/// Identifies a run of a service; changes with every restart.
struct BenchKey {
  std::uint32_t number = 0;
  std::uint64_t incarnation = 0;

  friend auto operator<=>(const BenchKey&, const BenchKey&) = default;
};

/// A bench whose samples arrive, and the participant that sends them.
struct PresentBench {
  BenchInfo info;
  wire::Source source;

  [[nodiscard]] BenchKey key() const { return {info.number, info.incarnation}; }
};

/// A run of a service, judged by its samples.
struct SeenRun {
  BenchKey key;
  std::chrono::nanoseconds age{};  ///< of the newest sign of life
  bool is_offline = false;
  bool is_streaming = false;  ///< its ticks pass and are published
};

/// The known benches: their own descriptions, and whether they are present. A description may come
/// from the DDS history and does not show that the service is still running. Time is passed as an
/// argument: Presence::running_time. Not thread-safe.
class Directory {
 public:
  using Clock = wire::Presence::Clock;

  explicit Directory(const wire::Presence& presence) : presence_(presence) {}

  void on_description(const msg::BenchDescription& message, const wire::Source& source,
                      Clock::time_point now);
  void on_state(const msg::BenchState& message, Clock::time_point now);

  /// Records another live sample of this run: a status frame or an answer.
  void note_sample(const BenchKey& key, std::uint64_t tick, Clock::time_point now);

  /// Records the tick of a status frame or a state of this run. Ticks not later than the last one
  /// are ignored.
  void note_time(const BenchKey& key, const RunTime& time);

  /// Records that this participant sent a live sample of the run, and is its sender from now on.
  /// When the wire process of a service restarts, a new participant continues the run.
  void note_sender(const BenchKey& key, const wire::Source& source);

  /// @return the participant that sends for this run; nothing before its description or first live
  ///         sample.
  [[nodiscard]] std::optional<wire::Source> source_of(const BenchKey& key) const;

  /// @return the benches with a complete description that are not offline and have been silent for
  ///         less than kPresence, by number. If two have the same number, only the one with the
  ///         lower incarnation: the services decide in the same way.
  [[nodiscard]] std::vector<PresentBench> present(Clock::time_point now) const;

  /// @return the number of benches in present().
  [[nodiscard]] std::size_t count_present(Clock::time_point now) const;

  /// @return the bench `number` if it is there.
  [[nodiscard]] std::optional<PresentBench> find(std::uint32_t number, Clock::time_point now) const;

  /// @return as find(), without the axes, of which a bench may have thousands.
  [[nodiscard]] std::optional<PresentBench> find_without_axes(std::uint32_t number,
                                                              Clock::time_point now) const;

  /// @return the number of runs whose description has arrived.
  [[nodiscard]] std::size_t described() const;

  /// @return whether the bench of this participant is present or has gone offline.
  [[nodiscard]] bool has_shown_itself(const wire::Source& source, Clock::time_point now) const;

  /// @return whether a bench has started to appear: part of its description or its first sample is
  ///         still missing.
  [[nodiscard]] bool expects_more(Clock::time_point now) const;

  /// @return whether this run has been silent for less than `patience` and has not gone offline.
  [[nodiscard]] bool is_alive(const BenchKey& key, std::chrono::milliseconds patience,
                              Clock::time_point now) const;

  /// @return how long this run has been silent; nothing if it is not present.
  [[nodiscard]] std::optional<std::chrono::milliseconds> age(const BenchKey& key,
                                                             Clock::time_point now) const;

  /// @return the run of the bench that has sent the newest message; incarnation 0 if there is none.
  [[nodiscard]] BenchKey newest_run(std::uint32_t number) const;

  /// @return the last bench that has announced its end; nothing if none has.
  [[nodiscard]] std::optional<std::uint32_t> ended_bench() const;

  /// @return the unit of an axis from the newest description of its bench; nothing without one.
  [[nodiscard]] std::optional<Unit> unit_of(const AxisId& axis) const;

  /// @return whether this run has announced its end.
  [[nodiscard]] bool is_offline(const BenchKey& key) const;

  /// @return every run that has a description and was present, by bench, the newest run of a bench
  ///         last.
  [[nodiscard]] std::vector<SeenRun> seen_runs(Clock::time_point now) const;

  /// Records the rate from an answer of this run, before its state shows it.
  void set_rate(const BenchKey& key, double rate);

  /// @return whether a state of this run after `since` shows that its drive time stands still:
  ///         realtime at rate 0.
  [[nodiscard]] bool is_paused(const BenchKey& key, Clock::time_point since) const;

  /// @return the number of steppers on the clock according to the newest state.
  [[nodiscard]] std::uint32_t steppers(const BenchKey& key) const;

  /// @return the stepper that time waits for according to the newest state, 0 = none.
  [[nodiscard]] std::uint64_t slowest_stepper(const BenchKey& key) const;

  /// @return whether another run now has the bench number.
  [[nodiscard]] bool is_restarted(const BenchKey& key, Clock::time_point now) const;

  /// @return the newest tick received, 0 if none.
  [[nodiscard]] std::uint64_t tick(const BenchKey& key) const;

  /// @return the newest tick from a status frame or a state, minus the ticks that the tick number
  ///         has jumped over since the first of them; nothing before the first one.
  [[nodiscard]] std::optional<std::uint64_t> driven_tick(const BenchKey& key) const;

 private:
  struct Entry {
    BenchInfo info;
    wire::Source source;
    std::map<std::uint16_t, std::vector<AxisInfo>> parts;
    std::uint16_t part_count = 0;
    bool offline = false;
    std::optional<Clock::time_point> newest_sample;
    Clock::time_point newest;  ///< time of the last message of any kind
    std::optional<Clock::time_point> rate_time;
    std::uint32_t steppers = 0;
    std::uint64_t slowest_stepper = 0;
    std::optional<RunTime> time;  ///< newest
    std::uint64_t skipped = 0;    ///< ticks skipped since the first `time`
  };

  /// @return how long this run has been silent; nothing if it is not present.
  [[nodiscard]] std::optional<Clock::duration> silence_of(const Entry& entry,
                                                          Clock::time_point now) const;
  [[nodiscard]] bool is_heard(const Entry& entry, std::chrono::milliseconds patience,
                              Clock::time_point now) const;
  [[nodiscard]] bool is_present(const Entry& entry, Clock::time_point now) const;

  /// Calls `visit(run)` with the item of `entries_` of each present bench, by number.
  template <typename Visit>
  void for_each_present(Clock::time_point now, const Visit& visit) const;
  /// @return the item of the bench `number`, or nullptr.
  [[nodiscard]] const std::pair<const BenchKey, Entry>* find_run(std::uint32_t number,
                                                                 Clock::time_point now) const;
  /// The bench with the axes of all parts. Copy them only where needed, because a bench may have
  /// thousands.
  [[nodiscard]] PresentBench whole(const Entry& entry, Clock::time_point now) const;

  /// @return the entry of this run, created if there is room; nullptr if there is no room.
  Entry* entry_of(const BenchKey& key, Clock::time_point now);
  bool has_room_for_part(Clock::time_point now);
  /// Forgets the run that has been silent longest, unless it has been silent for less than
  /// kForgetAfter.
  /// @return whether a run was forgotten.
  bool forget_the_most_silent(Clock::time_point now);

  const wire::Presence& presence_;
  std::map<BenchKey, Entry> entries_;
};

}  // namespace vdrive::client
