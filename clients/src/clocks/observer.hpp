// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clocks/bench_clocks.hpp"
#include "exchange/bench_links.hpp"
#include "exchange/exchange.hpp"
#include "presence/target.hpp"
#include "streams/status_stream.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <cstdint>
#include <span>

namespace vdrive::client {

/// Reads the present state and tick of axes, by the means that the clock of their bench and the
/// permissions of this session allow. Stateless. Thread-safe.
class Observer {
 public:
  Observer(const Discovery& discovery, BenchLinks& links, Exchange& exchange, BenchClocks& clocks,
           StatusStream& stream);

  /// The present state of `axes`.
  Result<Observation> observe(const Target& target, std::span<const std::uint16_t> axes);

  /// As above, from the next sample of a feed; for a bench that is not in lock-step.
  Result<Observation> observe(const Target& target, std::span<const std::uint16_t> axes,
                              StatusFeed& feed);

  /// The newest tick of the bench.
  Result<std::uint64_t> present_tick(const Target& target, Silence silence = Silence::ends_call);

  /// The last tick that the bench has completed when it answers: samples of this tick or a later
  /// one are not older than the call. 0 for a session that may not send requests.
  /// @param axis any axis of the bench
  Result<std::uint64_t> completed_tick(const Target& target, std::uint16_t axis);

  /// @return the tick from which reports begin: the newest tick received. A bench that may be far
  ///         ahead of that is asked instead.
  std::uint64_t first_tick_of_stream(const Target& target, std::uint16_t axis);

  /// Waits until the bench has reached `tick`, or has jumped over it; in lock-step, steps to it.
  /// @return the tick reached.
  Result<std::uint64_t> wait_for_tick(const Target& target, std::uint64_t tick);

  /// Waits until the bench has run that many ticks from now on, however far the tick number jumps;
  /// in lock-step, steps.
  /// @return the tick reached.
  Result<std::uint64_t> wait_for_ticks(const Target& target, std::uint64_t ticks);

 private:
  Result<Observation> observe_at_rest(const Target& target, std::span<const std::uint16_t> axes);
  Result<Observation> read_status(const Target& target, std::span<const std::uint16_t> axes);

  const Discovery& discovery_;
  BenchLinks& links_;
  Exchange& exchange_;
  BenchClocks& clocks_;
  StatusStream& stream_;
};

}  // namespace vdrive::client
