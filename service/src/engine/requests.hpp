// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/reason.hpp"
#include "engine/axis_requests.hpp"
#include "engine/bench_brake.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/master_watch.hpp"
#include "engine/masters.hpp"
#include "engine/request_answers.hpp"
#include "engine/snapshots.hpp"
#include "engine/store_requests.hpp"
#include "seam/queues.hpp"
#include "vdrive_messages.h"

#include <cstdint>

namespace vdrive::service {

/// The requests that arrive: checks each, has it carried out by the class that it is for, and
/// answers it once, however often it arrives.
class Requests {
 public:
  /// What carries requests out.
  struct Parts {
    AxisRequests& axes;
    Masters& masters;
    StoreRequests& stores;
    Snapshots& snapshots;
  };

  Requests(BenchClock& clock, MasterWatch& watch, const BenchBrake& brake, const Parts& parts,
           RequestAnswers& answers, BenchEvents& events);

  void handle(const Arrival& arrival);

  /// Notes a request, and answers it again when it has arrived before and is not in progress.
  /// @return whether it has arrived before: it needs no further work.
  [[nodiscard]] bool answer_repeat(const Arrival& arrival);

  /// Checks what every request needs. @return REASON_NONE or why it is refused.
  [[nodiscard]] Reason check(const Arrival& arrival) const;

 private:
  [[nodiscard]] Reason carry_out(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] Reason set_rate(const msg::Request& request);

  BenchClock& clock_;
  MasterWatch& watch_;
  const BenchBrake& brake_;
  Parts parts_;
  RequestAnswers& answers_;
  BenchEvents& events_;
};

}  // namespace vdrive::service
