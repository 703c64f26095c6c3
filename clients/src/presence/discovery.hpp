// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/periodic_thread.hpp"
#include "base/wakeup.hpp"
#include "presence/directory.hpp"
#include "presence/search.hpp"
#include "presence/service_watch.hpp"
#include "presence/target.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/origin.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/presence.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// How long a bench must be silent before a wait ends.
enum class Silence : std::uint8_t {
  ends_call,   ///< SessionOptions::silence
  is_bridged,  ///< SessionOptions::patience: calls that follow a bench continue after a gap
};

/// The benches and axes that are present: receives the descriptions and states of benches, and uses
/// them and the presence of their participants to answer queries. Thread-safe; under its lock, only
/// the lock of Presence is taken.
class Discovery {
 public:
  using Clock = Directory::Clock;

  Discovery(wire::Participant& participant, SessionOptions options, Wakeup& wakeup);

  /// Call this before taking any lock of the session.
  /// @return lost in a forked child of the session's process.
  [[nodiscard]] Outcome check_process() const;

  // ---- waiting for a bench

  std::vector<PresentBench> find_benches();
  Result<PresentBench> find_bench(std::optional<std::uint32_t> number);

  /// @return not_found, with the findings of the last search.
  [[nodiscard]] Outcome no_bench_found() const;

  /// @return the present obstacles to finding benches.
  [[nodiscard]] std::vector<std::string> network_troubles() const;

  /// Finds an axis by address or name.
  Result<AxisInfo> find_axis(std::string_view text);

  // ---- information from other messages

  /// @return whether this session sees that bench.
  [[nodiscard]] bool sees(std::uint32_t bench) const;

  /// Records a live sample of this run without a tick. `source` is its sender from now on.
  void note_sender(const BenchKey& key, const wire::Source& source);

  /// Records a live sample of this run: a status frame or an answer.
  void note_sample(const BenchKey& key, std::uint64_t tick, const wire::Source& source);

  /// Records a status frame of this run.
  void note_frame(const BenchKey& key, const RunTime& time, const wire::Source& source);

  /// Records the rate from an answer of this run, before its state shows it.
  void set_rate(const BenchKey& key, double rate);

  // ---- queries that do not wait

  /// @return the benches whose samples arrive, by number.
  [[nodiscard]] std::vector<PresentBench> present() const;

  /// @return the participant that sends for this run; nothing before its description or first live
  ///         sample.
  [[nodiscard]] std::optional<wire::Source> source_of(const BenchKey& key) const;

  /// @return whether this run has been silent for less than `patience` and has not gone offline.
  [[nodiscard]] bool is_alive(const BenchKey& key, std::chrono::milliseconds patience) const;

  /// @return lost if this run of the service was silent for silence(), ended, or was replaced.
  [[nodiscard]] Outcome check_presence(const Target& target) const;

  /// @return as check_presence(), for calls that wait: a replaced run counts as present as long as
  ///         its samples arrive, and `silence` may be bridged.
  [[nodiscard]] Outcome check_samples(const Target& target, Silence silence) const;

  /// @return as check_samples(), for the last run of the bench that was seen.
  [[nodiscard]] Outcome check_last_run(std::uint32_t bench) const;

  /// @return the run of the bench that is present now; nothing if there is none.
  [[nodiscard]] std::optional<Target> present_target(std::uint32_t bench) const;

  /// @return as present_target(), but only a run that continues `run`: the same run or, on a
  ///         network, the run of a restarted service. In this process, another run with the same
  ///         number is a different bench.
  /// @param run incarnation 0 = none yet: any run continues it
  [[nodiscard]] std::optional<Target> continuation_of(const BenchKey& run) const;

  /// @return why a bench without a present run sends nothing.
  /// @param key a run of the bench; incarnation 0 = the last one seen
  [[nodiscard]] Outcome loss_of(const BenchKey& key) const;

  /// @return whether a bench with this number is present, or may be.
  [[nodiscard]] bool may_be_there(std::uint32_t bench) const;

  /// @return the unit of an axis from the newest description of its bench; vdrive::user_unit()
  ///         without one.
  [[nodiscard]] Unit unit_of(const AxisId& axis) const;

  /// @return the total time for which this program was stopped since this object was constructed; 0
  ///         if such a pause does not make benches appear silent.
  [[nodiscard]] Clock::duration own_pauses() const;

  /// @return the present time minus own_pauses().
  [[nodiscard]] Clock::time_point running_time() const;

  /// @return whether a state of this run after `since` shows that its drive time stands still.
  /// @param since a running_time
  [[nodiscard]] bool is_paused(const BenchKey& key, Clock::time_point since = {}) const;

  /// @return the number of steppers on the clock according to the newest state.
  [[nodiscard]] std::uint32_t steppers(const BenchKey& key) const;

  /// @return the stepper that time waits for according to the newest state, 0 = none.
  [[nodiscard]] std::uint64_t slowest_stepper(const BenchKey& key) const;

  /// @return the newest tick received, 0 if none.
  [[nodiscard]] std::uint64_t tick(const BenchKey& key) const;

  /// @return whether the run may be far ahead of the newest tick received: in this process, a bench
  ///         is present even when it sends nothing.
  [[nodiscard]] bool may_be_ahead(const BenchKey& key) const;

  /// @return the newest tick from a status frame or a state, minus the ticks that the tick number
  ///         has jumped over since the first of them; nothing before the first one.
  [[nodiscard]] std::optional<std::uint64_t> driven_tick(const BenchKey& key) const;

  /// @return the changes since the last call with `watch`.
  [[nodiscard]] std::vector<ServiceChange> changes(ServiceWatch& watch) const;

  /// Wall time without a sample after which a service counts as lost.
  [[nodiscard]] std::chrono::milliseconds silence() const noexcept { return options_.silence; }

  /// As silence(), for calls that follow a bench.
  [[nodiscard]] std::chrono::milliseconds patience() const noexcept {
    return std::max(options_.patience, options_.silence);
  }

  /// How long calls that follow a bench wait for it to return.
  [[nodiscard]] std::chrono::milliseconds time_to_return() const noexcept {
    return presence_.may_return() ? patience() : std::chrono::milliseconds(0);
  }

 private:
  /// The participants of services, by the number of their bench.
  using Services = std::map<std::uint32_t, wire::Source>;

  void on_description(const msg::BenchDescription& message, const wire::Source& source);
  void on_state(const msg::BenchState& message, const wire::Source& source);
  /// A bench that is not found counts as lost if this session has met it and it has ended.
  /// @param bench none = any
  [[nodiscard]] Outcome not_found(std::optional<std::uint32_t> bench, std::string text) const;
  Result<AxisInfo> find_name(std::string_view name);
  Result<AxisInfo> find_on_bench(std::uint32_t bench, std::string_view axis);
  [[nodiscard]] bool expects_more() const;
  [[nodiscard]] SearchFindings look(std::optional<std::uint32_t> number) const;
  /// @return where this session searches, such as " on domain 3".
  [[nodiscard]] std::string place() const;
  /// @return the findings of the last search, in brackets.
  [[nodiscard]] std::string seen() const;
  [[nodiscard]] std::string with_advice(const std::string& text) const;
  [[nodiscard]] Services services() const;
  [[nodiscard]] Services others_announced() const;
  /// @return the end of the message of an unsuccessful search: the benches that are present, the
  ///         findings of the search, and the next step if there is no bench.
  [[nodiscard]] std::string found_text() const;
  /// Searches until `condition`, called with the present findings, holds, or the time of a search
  /// is up.
  /// @param number if the search is for one bench only
  /// @param completion the search also looks again at its next_end(); nullptr = none
  template <typename Condition>
  void search(std::optional<std::uint32_t> number, const Condition& condition,
              const SearchCompletion* completion = nullptr);
  /// Called with the lock held.
  /// @return why a silent bench is lost.
  [[nodiscard]] Outcome lost_in_silence(const Target& target, Clock::time_point now,
                                        std::chrono::milliseconds limit) const;

  /// Called with the lock held, so that a pause is recorded in order with arriving samples.
  /// @return the running_time.
  [[nodiscard]] Clock::time_point now() const { return presence_.running_time(Clock::now()); }

  const wire::Origin origin_;
  wire::Participant& participant_;
  wire::Presence& presence_;
  const SessionOptions options_;
  Wakeup& wakeup_;
  mutable std::mutex mutex_;  ///< guards the directory and `seen_`
  Directory directory_;
  std::string seen_ = text_of({}, {});
  wire::Subscription<msg::BenchState> state_subscription_;
  wire::Subscription<msg::BenchDescription> description_subscription_;
  PeriodicThread pulse_;  ///< calls own_pauses(), so that a pause is noticed
};

}  // namespace vdrive::client
