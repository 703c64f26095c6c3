// SPDX-License-Identifier: Apache-2.0
#include "service_calls.hpp"

#include "vdrive/text.hpp"

#include <string>
#include <utility>

namespace vdrive::gateway {
namespace {

using client::Outcome;

/// The request of a service, an object; an empty payload stands for an empty object.
Json parse_request(const CallService& call) {
  if (call.encoding != "json") {
    throw ProtocolError("the encoding " + in_quotes(call.encoding) + R"( is not "json")");
  }
  if (call.payload.empty()) return Json::object();
  Json request = Json::parse(call.payload, nullptr, false);
  if (!request.is_object()) throw ProtocolError("the request is not a JSON object");
  return request;
}

const ServiceRow& row_of(const CallService& call) {
  if (call.service == 0 || call.service > services().size()) {
    throw ProtocolError("service " + std::to_string(call.service) + " does not exist");
  }
  return services()[call.service - 1];
}

}  // namespace

void ServiceCalls::handle(ConnectionId id, const CallService& call) {
  const Answer answer = [this, id, service = call.service,
                         number = call.call](const CallAnswer& answered) {
    if (!clients_.contains(id)) return;
    server_.send_answer(id, response_frame(service, number, answer_text(answered)), false);
  };
  try {
    const ServiceRow& row = row_of(call);
    Json request = parse_request(call);
    // Checked before the members are read: a client without the right learns only that.
    if (Outcome right = control_.check(id, row.right); !right) {
      return answer({.outcome = std::move(right)});
    }
    route(id, row, std::move(request), answer);
  } catch (const ProtocolError& error) {
    server_.send_text(id, call_failure_text(call.service, call.call, error.what()));
  }
}

void ServiceCalls::route(ConnectionId id, const ServiceRow& row, Json request,
                         const Answer& answer) {
  switch (row.right) {
    case Right::take_control:
      return control_.take(id, request, answer);
    case Right::release_control:
      control_.release(id);
      return answer({});
    case Right::jog:
      return jog(request, answer);
    case Right::none:
    case Right::events:
    case Right::judge:
    case Right::stop:
    case Right::command:
      return carry_out(id, row, std::move(request), answer);
  }
}

void ServiceCalls::jog(const Json& request, const Answer& answer) {
  try {
    control_.jog(jog_of(request), Jogs::Clock::now(), [this, answer](const CallAnswer& answered) {
      server_.post([answer, answered] {
        answer(answered);
      });
    });
  } catch (const ProtocolError& error) {
    answer({.outcome = Outcome::failed(error.what())});
  }
}

void ServiceCalls::carry_out(ConnectionId id, const ServiceRow& row, Json request,
                             const Answer& answer) {
  // Uses the present session, so that the call ends with it if control changes before the answer.
  auto job = [this, &row, request = std::move(request), own = control_.session_of(id), answer] {
    CallAnswer answered;
    try {
      answered = access_.call(row, own, request);
    } catch (const ProtocolError& error) {
      answered.outcome = Outcome::failed(error.what());
    }
    server_.post([answer, answered = std::move(answered)] {
      answer(answered);
    });
  };
  // A stop does not wait for other calls of this client.
  const bool is_posted =
      row.right == Right::stop ? stops_.post(std::move(job)) : clients_.post(id, std::move(job));
  if (!is_posted) {
    answer({.outcome = Outcome::failed("too many calls are waiting: this one was dropped")});
  }
}

}  // namespace vdrive::gateway
