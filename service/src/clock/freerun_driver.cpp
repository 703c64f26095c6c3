// SPDX-License-Identifier: Apache-2.0
#include "clock/freerun_driver.hpp"

namespace vdrive::service {

FreerunDriver::FreerunDriver(BenchEngine& engine, Inbox& inbox, Outbox& outbox, CycleTimer& timer)
    : engine_(engine), inbox_(inbox), outbox_(outbox), timer_(timer) {}

void FreerunDriver::cycle() noexcept {  // NOLINT(bugprone-exception-escape)
  handle_arrivals();
  engine_.step();
  if (const auto now = timer_.monotonic_now(); now >= next_status_) {
    if (outbox_.status.size() == 0) engine_.queue_status();
    next_status_ = now + kStatusInterval;
  }
}

/// Ticks are so short that requests may arrive faster than replies leave: requests that cannot be
/// answered wait in the inbox.
void FreerunDriver::handle_arrivals() {
  Arrival* arrival = inbox_.front();
  while (arrival != nullptr && engine_.can_answer()) {
    engine_.handle(*arrival);
    inbox_.pop();
    arrival = inbox_.front();
  }
}

}  // namespace vdrive::service
