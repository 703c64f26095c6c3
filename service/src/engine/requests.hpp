// SPDX-License-Identifier: Apache-2.0
#pragma once

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
  static constexpr std::uint64_t kMaxTicksPerStep = 1'000'000;

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

  /// Checks a request about the steps of a lock-step bench. @return REASON_NONE or why it is
  /// refused.
  [[nodiscard]] std::uint32_t check_step(const Arrival& arrival) const;

  /// Answers a checked request of that kind, with the status of the axes that it names when
  /// `reason` is REASON_NONE or REASON_MISSING_STEPPER.
  /// @param missing_stepper the session whose grant is missing
  void answer_step(const Arrival& arrival, std::uint32_t reason, std::uint64_t missing_stepper);

 private:
  [[nodiscard]] std::uint32_t check(const Arrival& arrival) const;
  [[nodiscard]] std::uint32_t carry_out(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] std::uint32_t set_rate(const msg::Request& request);

  BenchClock& clock_;
  MasterWatch& watch_;
  const BenchBrake& brake_;
  Parts parts_;
  RequestAnswers& answers_;
  BenchEvents& events_;
};

}  // namespace vdrive::service
