// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/event_record.hpp"
#include "base/ring.hpp"
#include "engine/bench_clock.hpp"
#include "journal/black_box.hpp"

#include <cstdint>

namespace vdrive::service {

/// The events of a bench on their way to the thread that publishes them.
class BenchEvents {
 public:
  BenchEvents(const BenchClock& clock, BlackBox& black_box, Ring<EventRecord>& queue,
              Counters& counters);

  /// Puts the event into the black box and the queue, with the present tick. If the queue is full,
  /// the overflow is counted.
  void report(EventRecord event);

  /// Reports overflows of the queues of all threads, as soon as there is room for the event.
  void report_overflows();

  [[nodiscard]] bool has_room() const noexcept { return queue_.size() < queue_.capacity(); }

 private:
  const BenchClock& clock_;
  BlackBox& black_box_;
  Ring<EventRecord>& queue_;
  Counters& counters_;
  std::uint64_t reported_overflows_ = 0;
};

}  // namespace vdrive::service
