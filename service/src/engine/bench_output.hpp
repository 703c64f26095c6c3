// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/masters.hpp"
#include "seam/queues.hpp"

namespace vdrive::service {

/// What a bench publishes without a request: status images, changed parameters, and events about
/// its journal and its queues.
class BenchOutput {
 public:
  BenchOutput(const BenchIdentity& identity, const BenchClock& clock, BenchAxes& axes,
              const Masters& masters, BenchEvents& events, Outbox& outbox, Counters& counters);

  /// Puts the status image of the last tick into the outbox.
  /// @param repeated the image was published before; it is sent again for clients that joined later
  void queue_status(bool repeated);

  /// Puts what has changed into the outbox: as many changed parameter sets as fit, events about
  /// full queues, and the state of the journal.
  void queue_changes();

 private:
  void report_journal();

  BenchIdentity identity_;
  const BenchClock& clock_;
  BenchAxes& axes_;
  const Masters& masters_;
  BenchEvents& events_;
  Outbox& outbox_;
  Counters& counters_;
};

}  // namespace vdrive::service
