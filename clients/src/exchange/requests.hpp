// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "exchange/bench_links.hpp"
#include "exchange/unanswered.hpp"
#include "exchange/waiter.hpp"
#include "presence/target.hpp"
#include "vdrive_messages.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::client {

/// Sends requests and awaits their replies. Thread-safe.
class Requests {
 public:
  Requests(std::uint64_t session, BenchLinks& links, UnansweredRequests& unanswered,
           Waiter& waiter);

  /// Sends a request and awaits its reply. Fills in sender and receiver.
  /// @param what names the request in messages, such as "read of axis 1.1"
  Result<RequestAnswer> exchange(const Target& target, msg::Request request, std::string_view what,
                                 Silence silence = Silence::ends_call);

  /// The same for several at once. @return the replies in the same order, or the first refusal.
  Result<std::vector<RequestAnswer>> exchange_all(const Target& target,
                                                  std::vector<msg::Request> requests,
                                                  std::string_view what);

  /// Sends a request. @return its number, for await().
  /// @param patience wall time to wait for the match of a bench that is connected anew
  Result<std::uint64_t> send(const Target& target, msg::Request request,
                             std::chrono::milliseconds patience = kMatch);

  /// Awaits the reply to a request, also a refusal.
  Result<RequestAnswer> await(const Target& target, std::uint64_t number, const Patience& patience);

  /// The axes that an answer shows were read: a next answer takes their memory.
  void reuse(RequestAnswer& answer) { links_.reuse(std::move(answer.axes)); }

 private:
  const std::uint64_t session_;
  BenchLinks& links_;
  UnansweredRequests& unanswered_;
  Waiter& waiter_;
  std::atomic<std::uint64_t> last_number_ = 0;
};

}  // namespace vdrive::client
