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

/// Which silence of a bench ends what waits for it.
enum class Silence : std::uint8_t {
  ends_call,   ///< one of SessionOptions::silence
  is_bridged,  ///< one of SessionOptions::patience: what follows a bench continues after a gap
};

/// Which benches and axes are there: receives what benches publish about themselves, and answers
/// questions by that and by the presence of their participants. Thread-safe; while its lock is held
/// only that of the presence is taken.
class Discovery {
 public:
  using Clock = Directory::Clock;

  Discovery(wire::Participant& participant, SessionOptions options, Wakeup& wakeup);

  /// Before any lock of the session is taken.
  /// @return lost in a process that was forked from the one of this session.
  [[nodiscard]] Outcome check_process() const;

  // ---- waiting for a bench

  std::vector<PresentBench> find_benches();
  Result<PresentBench> find_bench(std::optional<std::uint32_t> number);

  /// @return not_found with what the newest search has seen.
  [[nodiscard]] Outcome no_bench_found() const;

  /// @return what is in the way of finding benches now.
  [[nodiscard]] std::vector<std::string> network_troubles() const;

  /// An axis by address or name.
  Result<AxisInfo> find_axis(std::string_view text);

  // ---- what other messages show

  /// @return whether this session sees that bench.
  [[nodiscard]] bool sees(std::uint32_t bench) const;

  /// A live sample of this run that carries no tick. `source` is its sender from now on.
  void note_sender(const BenchKey& key, const wire::Source& source);

  /// A live sample of this run, a status frame or an answer.
  void note_sample(const BenchKey& key, std::uint64_t tick, const wire::Source& source);

  /// A status frame of this run.
  void note_frame(const BenchKey& key, const RunTime& time, const wire::Source& source);

  /// This run answered that it has another rate, before its state shows it.
  void set_rate(const BenchKey& key, double rate);

  // ---- questions that do not wait

  /// @return the benches whose samples arrive, by number.
  [[nodiscard]] std::vector<PresentBench> present() const;

  /// @return the participant that sends for this run; nothing before its description or its
  ///         first live sample.
  [[nodiscard]] std::optional<wire::Source> source_of(const BenchKey& key) const;

  /// @return whether this run has been silent for less than `patience` and has not gone offline.
  [[nodiscard]] bool is_alive(const BenchKey& key, std::chrono::milliseconds patience) const;

  /// @return lost when this run of the service was silent for silence(), ended, or was replaced.
  [[nodiscard]] Outcome check_presence(const Target& target) const;

  /// @return the same for what waits: the run of a service that was replaced continues as long as
  ///         its samples arrive, and `silence` may be bridged.
  [[nodiscard]] Outcome check_samples(const Target& target, Silence silence) const;

  /// @return the same for the run of the bench that was seen last.
  [[nodiscard]] Outcome check_last_run(std::uint32_t bench) const;

  /// @return the run of the bench that is there now; nothing when none is.
  [[nodiscard]] std::optional<Target> present_target(std::uint32_t bench) const;

  /// @return the same as long as it continues `run`: a service that restarts does; what comes with
  ///         the number of a bench that cannot return is another bench.
  /// @param run incarnation 0 = none yet: any continues it
  [[nodiscard]] std::optional<Target> continuation_of(const BenchKey& run) const;

  /// @return why nothing comes from a bench that has no run now.
  /// @param key a run of it; incarnation 0 = the one that was seen last
  [[nodiscard]] Outcome loss_of(const BenchKey& key) const;

  /// @return whether a bench with this number is there, or may be.
  [[nodiscard]] bool may_be_there(std::uint32_t bench) const;

  /// @return the unit of an axis by the newest description of its bench; vdrive::user_unit() where
  ///         there is none.
  [[nodiscard]] Unit unit_of(const AxisId& axis) const;

  /// @return for how long this program did not run since it has this object, as far as that makes
  ///         benches appear silent.
  [[nodiscard]] Clock::duration own_pauses() const;

  /// @return the time without these pauses.
  [[nodiscard]] Clock::time_point running_time() const;

  /// @return whether a state of this run after `since` shows that its drive time stands still.
  /// @param since a running_time
  [[nodiscard]] bool is_paused(const BenchKey& key, Clock::time_point since = {}) const;

  /// @return how many have joined the clock by the newest state.
  [[nodiscard]] std::uint32_t steppers(const BenchKey& key) const;

  /// @return the stepper that time waits for by the newest state, 0 = none.
  [[nodiscard]] std::uint64_t slowest_stepper(const BenchKey& key) const;

  /// @return the newest tick received, 0 when none was.
  [[nodiscard]] std::uint64_t tick(const BenchKey& key) const;

  /// @return whether the run may be far ahead of the newest tick received: it is there for certain,
  ///         whether it sends something or not.
  [[nodiscard]] bool may_be_ahead(const BenchKey& key) const;

  /// @return the newest tick that a status frame or a state has shown, without the ticks that the
  ///         number has jumped over since the first of them; nothing before that one.
  [[nodiscard]] std::optional<std::uint64_t> driven_tick(const BenchKey& key) const;

  /// @return what has changed since the last call with `watch`.
  [[nodiscard]] std::vector<ServiceChange> changes(ServiceWatch& watch) const;

  /// Wall time without a sample after which a service counts as lost.
  [[nodiscard]] std::chrono::milliseconds silence() const noexcept { return options_.silence; }

  /// The same for what follows a bench.
  [[nodiscard]] std::chrono::milliseconds patience() const noexcept {
    return std::max(options_.patience, options_.silence);
  }

  /// How long what follows a bench that has gone waits for a continuation of it.
  [[nodiscard]] std::chrono::milliseconds time_to_return() const noexcept {
    return presence_.may_return() ? patience() : std::chrono::milliseconds(0);
  }

 private:
  /// The participants of services, by the number of their bench.
  using Services = std::map<std::uint32_t, wire::Source>;

  void on_description(const msg::BenchDescription& message, const wire::Source& source);
  void on_state(const msg::BenchState& message, const wire::Source& source);
  /// What is not found is lost when it was there: this session has met it, and it has ended.
  /// @param bench none = any
  [[nodiscard]] Outcome not_found(std::optional<std::uint32_t> bench, std::string text) const;
  Result<AxisInfo> find_name(std::string_view name);
  Result<AxisInfo> find_on_bench(std::uint32_t bench, std::string_view axis);
  [[nodiscard]] bool expects_more() const;
  [[nodiscard]] Sight look(std::optional<std::uint32_t> number) const;
  /// @return where this session looks, such as " on domain 3".
  [[nodiscard]] std::string place() const;
  /// @return what the newest search has seen, in brackets.
  [[nodiscard]] std::string seen() const;
  [[nodiscard]] std::string with_advice(const std::string& text) const;
  [[nodiscard]] Services services() const;
  [[nodiscard]] Services others_announced() const;
  /// @return the end of the message of a search that found nothing: which benches there are, what
  ///         the search has seen, and where there is no bench the next step.
  [[nodiscard]] std::string what_is_there() const;
  /// Until `condition` holds, called with what is seen, or for the time of a search.
  /// @param number of the only bench that is looked for
  template <typename Condition>
  /// @param settling of a search that ends with it
  void search(std::optional<std::uint32_t> number, const Condition& condition,
              const Settling* settling = nullptr);
  /// With the lock. @return why a bench that sends nothing is lost.
  [[nodiscard]] Outcome lost_in_silence(const Target& target, Clock::time_point now,
                                        std::chrono::milliseconds limit) const;

  /// With the lock: a pause counts in the order of what arrives. @return the running_time.
  [[nodiscard]] Clock::time_point now() const { return presence_.running_time(Clock::now()); }

  const wire::Origin origin_;
  wire::Participant& participant_;
  wire::Presence& presence_;
  const SessionOptions options_;
  Wakeup& wakeup_;
  mutable std::mutex mutex_;  ///< guards the directory and what was seen
  Directory directory_;
  std::string seen_ = text_of({}, {});
  wire::Subscription<msg::BenchState> state_subscription_;
  wire::Subscription<msg::BenchDescription> description_subscription_;
  PeriodicThread pulse_;  ///< shows that the program runs, where that matters
};

}  // namespace vdrive::client
