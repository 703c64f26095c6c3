// SPDX-License-Identifier: Apache-2.0
#include "exchange/requests.hpp"

#include <optional>
#include <utility>

namespace vdrive::client {

Requests::Requests(std::uint64_t session, BenchLinks& links, UnansweredRequests& unanswered,
                   Waiter& waiter)
    : session_(session), links_(links), unanswered_(unanswered), waiter_(waiter) {}

Result<std::uint64_t> Requests::send(const Target& target, msg::Request request,
                                     std::chrono::milliseconds patience) {
  const auto link = links_.open(target, "requests", patience);
  if (!link) return link.outcome();
  const std::uint64_t number = ++last_number_;
  request.client = session_;
  request.request_id = number;
  request.bench = target.key.number;
  request.incarnation = target.key.incarnation;
  request.session = session_;
  // Kept before it is sent: the reply may arrive first.
  const msg::Request& kept = unanswered_.add(number, target.key, std::move(request));
  if (links_.send(*link, kept)) return number;
  (void)unanswered_.take(number);
  return Outcome::lost(name_of(target) + " accepts no more requests");
}

Result<RequestAnswer> Requests::await(const Target& target, std::uint64_t number,
                                      const Patience& patience) {
  Outcome outcome = waiter_.wait(target, patience, [&] {
    return unanswered_.is_answered(number);
  });
  std::optional<RequestAnswer> reply = unanswered_.take(number);
  if (!outcome) return outcome;
  return std::move(*reply);
}

Result<RequestAnswer> Requests::exchange(const Target& target, msg::Request request,
                                         std::string_view what, Silence silence) {
  const auto number = send(target, std::move(request));
  if (!number) return number.outcome();
  Patience patience = kAnswer;
  patience.silence = silence;
  auto reply = await(target, *number, patience);
  if (!reply) return reply;
  if (reply->reason != msg::Reason::none) return refusal_of(target, *reply, what);
  return reply;
}

Result<std::vector<RequestAnswer>> Requests::exchange_all(const Target& target,
                                                          std::vector<msg::Request> requests,
                                                          std::string_view what) {
  Outcome outcome;
  std::vector<std::uint64_t> numbers;
  for (msg::Request& request : requests) {
    const auto number = send(target, std::move(request));
    if (!number) {
      outcome = number.outcome();
      break;
    }
    numbers.push_back(*number);
  }
  std::vector<RequestAnswer> replies;
  for (const std::uint64_t number : numbers) {
    if (!outcome) {
      (void)unanswered_.take(number);
      continue;
    }
    auto reply = await(target, number, kAnswer);
    if (!reply) {
      outcome = reply.outcome();
    } else if (reply->reason != msg::Reason::none) {
      outcome = refusal_of(target, *reply, what);
    } else {
      replies.push_back(std::move(*reply));
    }
  }
  if (!outcome) return outcome;
  return replies;
}

}  // namespace vdrive::client
