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

/// Checks each arriving request, has the handler of its kind carry it out once, however often it
/// arrives, and answers it.
class Requests {
 public:
  Requests(const RequestParts& parts, const BenchBrake& brake, RequestAnswers& answers);

  void handle(const Arrival& arrival);

  /// Notes a request. If it has arrived before and is not in progress, resends its answer.
  /// @return whether it has arrived before and so needs no further work
  [[nodiscard]] bool answer_repeat(const Arrival& arrival);

  /// Makes the checks that apply to every request. @return REASON_NONE, or why it is refused
  [[nodiscard]] Reason check(const Arrival& arrival) const;

  /// Makes the checks that depend on the kind, after check(): the kind exists, the clock mode
  /// allows it, and the request has a session if the kind needs one.
  /// @return REASON_NONE, or why it is refused
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
