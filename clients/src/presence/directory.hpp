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

/// A tick of a run of a service and how many ticks its number has jumped over until then, as status
/// frames and states show it.
struct RunTime {
  std::uint64_t tick = 0;
  std::uint32_t skipped_ticks = 0;  ///< modulo 2^32
};

/// @return how many ticks were run from `from` to `to`, which is not earlier. Exact below 2^32 of
///         them: the number may jump by more.
[[nodiscard]] constexpr std::uint64_t ticks_run(const RunTime& from, const RunTime& to) noexcept {
  const auto passed = static_cast<std::uint32_t>(to.tick - from.tick);
  return static_cast<std::uint32_t>(passed - (to.skipped_ticks - from.skipped_ticks));
}

/// @return how many ticks the number jumped over meanwhile.
[[nodiscard]] constexpr std::uint64_t ticks_skipped(const RunTime& from,
                                                    const RunTime& to) noexcept {
  return to.tick - from.tick - ticks_run(from, to);
}

/// A bench whose samples are older is not there.
inline constexpr std::chrono::milliseconds kPresence{300};

/// Runs and parts of descriptions that a directory keeps. When it is full, the run that was silent
/// longest is forgotten if that was kForgetAfter or longer; otherwise a new run is left out.
inline constexpr std::size_t kMostRuns = 1'024;
inline constexpr std::size_t kMostParts = 4'096;
inline constexpr std::chrono::seconds kForgetAfter{60};

/// A run of a service; another one after a restart.
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

/// A run of a service, as its samples show it.
struct SeenRun {
  BenchKey key;
  std::chrono::nanoseconds age{};  ///< of the newest sign that it is there
  bool is_offline = false;
  bool is_streaming = false;  ///< its ticks pass and are published
};

/// Which benches exist: what they publish about themselves, and whether they are there. A
/// description comes from the history and does not show that the service still runs. Time is an
/// argument: Presence::running_time. Not thread-safe.
class Directory {
 public:
  using Clock = wire::Presence::Clock;

  explicit Directory(const wire::Presence& presence) : presence_(presence) {}

  void on_description(const msg::BenchDescription& message, const wire::Source& source,
                      Clock::time_point now);
  void on_state(const msg::BenchState& message, Clock::time_point now);

  /// Another live sample of this run: a status frame or an answer.
  void note_sample(const BenchKey& key, std::uint64_t tick, Clock::time_point now);

  /// A status frame or a state of this run. Of those that come out of order the newest counts.
  void note_time(const BenchKey& key, const RunTime& time);

  /// This participant sent a live sample of the run and is its sender from now on. A service whose
  /// network process restarts has a new participant and continues its run.
  void note_sender(const BenchKey& key, const wire::Source& source);

  /// @return the participant that sends for this run; nothing before its description or its
  ///         first live sample.
  [[nodiscard]] std::optional<wire::Source> source_of(const BenchKey& key) const;

  /// @return the benches with a complete description that are not offline and have been silent for
  ///         less than kPresence, by number. Of two with one number the lower incarnation, as the
  ///         services agree.
  [[nodiscard]] std::vector<PresentBench> present(Clock::time_point now) const;

  /// @return how many benches present() has.
  [[nodiscard]] std::size_t count_present(Clock::time_point now) const;

  /// @return the bench `number` if it is there.
  [[nodiscard]] std::optional<PresentBench> find(std::uint32_t number, Clock::time_point now) const;

  /// @return the same without its axes, of which a bench may have thousands.
  [[nodiscard]] std::optional<PresentBench> find_without_axes(std::uint32_t number,
                                                              Clock::time_point now) const;

  /// @return of how many runs a description has arrived.
  [[nodiscard]] std::size_t described() const;

  /// @return whether the bench of this participant is there, or has gone offline.
  [[nodiscard]] bool has_shown_itself(const wire::Source& source, Clock::time_point now) const;

  /// @return whether a bench has begun to show itself: part of its description or its first sample
  ///         is still missing.
  [[nodiscard]] bool expects_more(Clock::time_point now) const;

  /// @return whether this run has been silent for less than `patience` and has not gone offline.
  [[nodiscard]] bool is_alive(const BenchKey& key, std::chrono::milliseconds patience,
                              Clock::time_point now) const;

  /// @return for how long this run has been silent; nothing when it is not there.
  [[nodiscard]] std::optional<std::chrono::milliseconds> age(const BenchKey& key,
                                                             Clock::time_point now) const;

  /// @return the run of the bench that was heard last; one without an incarnation when none was.
  [[nodiscard]] BenchKey newest_run(std::uint32_t number) const;

  /// @return the bench whose run has announced its end, of several the last; nothing when none has.
  [[nodiscard]] std::optional<std::uint32_t> ended_bench() const;

  /// @return the unit of an axis by the newest description of its bench; nothing without one.
  [[nodiscard]] std::optional<Unit> unit_of(const AxisId& axis) const;

  /// @return whether this run has announced its end.
  [[nodiscard]] bool is_offline(const BenchKey& key) const;

  /// @return every run that has a description and was there, by bench; of one the newest last.
  [[nodiscard]] std::vector<SeenRun> seen_runs(Clock::time_point now) const;

  /// This run answered that it has another rate, before its state shows it.
  void set_rate(const BenchKey& key, double rate);

  /// @return whether a state of this run after `since` shows that its drive time stands still:
  ///         realtime at rate 0.
  [[nodiscard]] bool is_paused(const BenchKey& key, Clock::time_point since) const;

  /// @return how many have joined the clock by the newest state.
  [[nodiscard]] std::uint32_t steppers(const BenchKey& key) const;

  /// @return the stepper that time waits for by the newest state, 0 = none.
  [[nodiscard]] std::uint64_t slowest_stepper(const BenchKey& key) const;

  /// @return whether another run has the bench number now.
  [[nodiscard]] bool is_restarted(const BenchKey& key, Clock::time_point now) const;

  /// @return the newest tick received, 0 when none was.
  [[nodiscard]] std::uint64_t tick(const BenchKey& key) const;

  /// @return the newest tick that a status frame or a state has shown, without the ticks that the
  ///         number has jumped over since the first of them; nothing before that one.
  [[nodiscard]] std::optional<std::uint64_t> driven_tick(const BenchKey& key) const;

 private:
  struct Entry {
    BenchInfo info;
    wire::Source source;
    std::map<std::uint16_t, std::vector<AxisInfo>> parts;
    std::uint16_t part_count = 0;
    bool offline = false;
    std::optional<Clock::time_point> newest_sample;
    Clock::time_point newest;  ///< message of any kind
    std::optional<Clock::time_point> rate_time;
    std::uint32_t steppers = 0;
    std::uint64_t slowest_stepper = 0;
    std::optional<RunTime> time;  ///< newest
    std::uint64_t skipped = 0;    ///< ticks since the first one
  };

  /// @return for how long this run has been silent; nothing when it is not there.
  [[nodiscard]] std::optional<Clock::duration> silence_of(const Entry& entry,
                                                          Clock::time_point now) const;
  [[nodiscard]] bool is_heard(const Entry& entry, std::chrono::milliseconds patience,
                              Clock::time_point now) const;
  [[nodiscard]] bool is_present(const Entry& entry, Clock::time_point now) const;

  /// Calls `visit(run)` with the item of `entries_` of each bench that is there, by number.
  template <typename Visit>
  void for_each_present(Clock::time_point now, const Visit& visit) const;
  /// @return the item of the bench `number`, or nullptr.
  [[nodiscard]] const std::pair<const BenchKey, Entry>* find_run(std::uint32_t number,
                                                                 Clock::time_point now) const;
  /// With the axes of all parts: copied only where they are needed, a bench may have thousands.
  [[nodiscard]] PresentBench whole(const Entry& entry, Clock::time_point now) const;

  /// @return the entry of this run, made if there is room; nullptr if there is none.
  Entry* entry_of(const BenchKey& key, Clock::time_point now);
  bool has_room_for_part(Clock::time_point now);
  /// @return whether one was silent for long enough.
  bool forget_the_most_silent(Clock::time_point now);

  const wire::Presence& presence_;
  std::map<BenchKey, Entry> entries_;
};

}  // namespace vdrive::client
