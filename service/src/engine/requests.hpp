// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/reason.hpp"
#include "engine/bench_brake.hpp"
#include "engine/bench_clock.hpp"
#include "engine/masters.hpp"
#include "engine/request_answers.hpp"
#include "engine/request_handlers.hpp"
#include "engine/store_requests.hpp"
#include "seam/queues.hpp"
#include "vdrive_messages.hpp"

namespace vdrive::service {

/// The requests that arrive: checks each, has it carried out by the handler of its kind, and
/// answers it once, however often it arrives.
class Requests {
 public:
  Requests(const RequestParts& parts, const BenchBrake& brake, RequestAnswers& answers);

  void handle(const Arrival& arrival);

  /// Notes a request, and answers it again when it has arrived before and is not in progress.
  /// @return whether it has arrived before: it needs no further work.
  [[nodiscard]] bool answer_repeat(const Arrival& arrival);

  /// Checks what every request needs. @return REASON_NONE or why it is refused.
  [[nodiscard]] Reason check(const Arrival& arrival) const;

  /// Checks, after that, what the row of its kind needs: that there is one, the mode of the clock,
  /// a session. @return REASON_NONE or why it is refused.
  [[nodiscard]] Reason check_kind(const msg::Request& request) const;

 private:
  [[nodiscard]] Reason carry_out(const msg::Request& request, msg::Reply& reply);

  RequestParts parts_;
  const BenchClock& clock_;
  Masters& masters_;
  StoreRequests& stores_;
  const BenchBrake& brake_;
  RequestAnswers& answers_;
};

}  // namespace vdrive::service
