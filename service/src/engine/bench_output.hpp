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

/// The unsolicited output of a bench: status images, changed parameters, and events about its
/// journal and its queues.
class BenchOutput {
 public:
  BenchOutput(const BenchIdentity& identity, const BenchClock& clock, BenchAxes& axes,
              const Masters& masters, BenchEvents& events, Outbox& outbox, Counters& counters);

  /// Puts the status image of the last tick into the outbox.
  /// @param repeated the image was published before and is sent again for clients that joined since
  void queue_status(bool repeated);

  /// Puts changes into the outbox: as many changed parameter sets as fit, events about overflows of
  /// queues, and the state of the journal.
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
