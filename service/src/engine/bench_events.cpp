// SPDX-License-Identifier: Apache-2.0
#include "engine/bench_events.hpp"

#include "vdrive_messages.hpp"

namespace vdrive::service {

BenchEvents::BenchEvents(const BenchClock& clock, BlackBox& black_box, Ring<EventRecord>& queue,
                         Counters& counters)
    : clock_(clock), black_box_(black_box), queue_(queue), counters_(counters) {}

void BenchEvents::report(EventRecord event) {
  event.tick = clock_.tick();
  black_box_.record_event(event);
  if (EventRecord* const slot = queue_.free_slot(); slot != nullptr) {
    *slot = event;
    queue_.push();
  } else {
    counters_.queue_overflows.add();
  }
}

void BenchEvents::report_overflows() {
  const std::uint64_t overflows = counters_.queue_overflows.get();
  if (overflows == reported_overflows_ || !has_room()) return;
  report(
      {.kind = msg::EventKind::queue_overflow, .detail = Count{overflows - reported_overflows_}});
  reported_overflows_ = overflows;
}

}  // namespace vdrive::service
