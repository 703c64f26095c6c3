// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "exchange/bench_links.hpp"
#include "presence/discovery.hpp"
#include "presence/target.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

namespace vdrive::client {

/// How long a wait may take; times when this program does not run do not count. An interrupt does
/// not end the wait for the answer to a request: the interrupted call still has to clean up.
struct Patience {
  std::chrono::milliseconds timeout;
  bool may_interrupt;
  bool needs_drive_time = false;  ///< what is awaited never comes while the bench is paused
  Silence silence = Silence::ends_call;
};

/// A service whose samples arrive answers within this time, or it never answers.
inline constexpr Patience kAnswer{std::chrono::milliseconds(10'000), false};

/// Waits for what a bench sends. Meanwhile it repairs the link to it, and it ends the wait when the
/// bench will not send any more. The caller holds no lock of a state.
class Waiter {
 public:
  Waiter(Wakeup& wakeup, const Discovery& discovery, BenchLinks& links)
      : wakeup_(wakeup), discovery_(discovery), links_(links) {}

  /// Waits until `condition` holds; it is called after each change, without a lock.
  template <typename Condition>
  Outcome wait(const Target& target, const Patience& patience, const Condition& condition) {
    const auto begin = discovery_.running_time();
    while (true) {
      // Before the condition: what changes after it ends the wait at once.
      const std::uint64_t changes = wakeup_.changes();
      if (condition()) return {};
      // On the local bus most waits need no more: the answer comes with the work.
      if (wakeup_.work(changes, target.key.number) && condition()) return {};
      const auto now = Wakeup::Clock::now();
      const bool is_broken = links_.repair(target.key);
      // Again, before any reason to give up: the answer may have arrived during the repair.
      if (condition()) return {};
      if (auto end = end_of_wait(target, patience, begin)) return std::move(*end);
      // Each time anew: a pause of this program moves it.
      const auto deadline = begin + patience.timeout + discovery_.own_pauses();
      if (Wakeup::Clock::now() >= deadline) return timed_out(target);
      wakeup_.work_until(changes, target.key.number,
                         std::min(deadline, now + (is_broken ? kReconnectPeriod : kPeriod)));
    }
  }

 private:
  // A wait checks the presence of the bench at least this often; a broken link more often.
  static constexpr std::chrono::milliseconds kPeriod{50};
  static constexpr std::chrono::milliseconds kReconnectPeriod{5};

  /// @return why a wait that began at the running time `begin` ends without what it waits for;
  ///         nothing = it continues.
  [[nodiscard]] std::optional<Outcome> end_of_wait(const Target& target, const Patience& patience,
                                                   Wakeup::Clock::time_point begin) const;
  [[nodiscard]] static Outcome timed_out(const Target& target);

  Wakeup& wakeup_;
  const Discovery& discovery_;
  BenchLinks& links_;
};

}  // namespace vdrive::client
