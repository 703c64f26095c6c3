// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clock/cycle_timer.hpp"
#include "engine/bench_engine.hpp"
#include "seam/queues.hpp"

#include <chrono>

namespace vdrive::service {

/// Runs a bench as fast as possible. `cycle` takes no lock and does not wait. Only some requests
/// allocate.
class FreerunDriver {
 public:
  /// The interval of status images in wall time. An image is left out while the previous one waits
  /// for the status thread.
  static constexpr std::chrono::milliseconds kStatusInterval{1};

  FreerunDriver(BenchEngine& engine, Inbox& inbox, Outbox& outbox, CycleTimer& timer);

  /// Handles all arrivals and runs one tick. If memory runs out, the service ends.
  void cycle() noexcept;  // NOLINT(bugprone-exception-escape)

 private:
  void handle_arrivals();

  BenchEngine& engine_;
  Inbox& inbox_;
  Outbox& outbox_;
  CycleTimer& timer_;
  std::chrono::nanoseconds next_status_{0};
};

}  // namespace vdrive::service
