// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/reason.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/masters.hpp"
#include "engine/request_answers.hpp"
#include "seam/queues.hpp"
#include "store/parameter_saver.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// Requests that store parameters. Passes orders to the saver, and answers each request when its
/// orders are durable or have failed.
class StoreRequests {
 public:
  StoreRequests(BenchAxes& axes, const BenchClock& clock, const Masters& masters,
                RequestAnswers& answers, BenchEvents& events, Ring<OutgoingReply>& queue,
                Counters& counters);

  /// Stores with `saver`, which outlives this object; without a saver nothing can be stored. Only
  /// before the first request.
  void store_with(ParameterSaver& saver);

  /// Begins a request: the following orders belong to it.
  void begin_request() noexcept { ordered_ = 0; }

  /// Stores or restores the parameters of the axes in the request.
  /// @return REASON_NONE, or why the request is refused
  [[nodiscard]] Reason store_axes(const msg::Request& request, msg::Reply& reply);

  /// Writes 1010h or 1011h.
  /// @param place position of the object in the request
  /// @return REASON_NONE or an abort code
  [[nodiscard]] Reason store_by_write(std::size_t axis, ObjectRow row, std::int64_t value,
                                      std::size_t place);

  /// @return whether the present request has given orders, so that its answer has to wait for them.
  [[nodiscard]] bool has_ordered() const noexcept { return ordered_ > 0; }

  /// Keeps the content of `outgoing`, the answer to the present request, until its orders are done.
  void wait(std::uint64_t session, Reason reason, OutgoingReply& outgoing);

  [[nodiscard]] bool is_waiting(const msg::Request& request) const;

  /// Gives the axes the parameters that have become durable, and answers the requests that wait for
  /// them. @return whether there was anything to do
  bool answer();

 private:
  /// A request that waits until its parameters are durable.
  struct Waiting {
    OutgoingReply outgoing;
    std::uint64_t session = 0;
    Reason reason;           ///< of the orders done so far
    std::size_t orders = 0;  ///< in progress; 0 = the place is free
  };

  void order(std::size_t axis, bool forget, std::size_t object);
  [[nodiscard]] bool answer_order();
  void take_order(const StoreOrder& order, Waiting& waiting);
  void finish(Waiting& waiting);

  BenchAxes& axes_;
  const BenchClock& clock_;
  const Masters& masters_;
  RequestAnswers& answers_;
  BenchEvents& events_;
  Ring<OutgoingReply>& queue_;
  Counters& counters_;
  ParameterSaver* saver_ = nullptr;
  std::vector<Waiting> waiting_;
  std::vector<std::uint32_t> free_places_;  ///< in waiting_
  std::size_t ordered_ = 0;                 ///< orders of the present request
};

}  // namespace vdrive::service
