// SPDX-License-Identifier: Apache-2.0
#include "engine/requests.hpp"

#include "vdrive/wire/request_kinds.hpp"

namespace vdrive::service {
namespace {

Reason check_clock(wire::RequestClock needed, const BenchClock& clock) {
  switch (needed) {
    case wire::RequestClock::lockstep:
      return clock.mode() == ClockMode::lockstep ? msg::Reason::none
                                                 : msg::Reason::wrong_clock_mode;
    case wire::RequestClock::realtime:
      return clock.mode() == ClockMode::realtime ? msg::Reason::none
                                                 : msg::Reason::wrong_clock_mode;
    case wire::RequestClock::standing:
      return clock.time_stands() ? msg::Reason::none : msg::Reason::time_passes;
    default:
      return msg::Reason::none;
  }
}

/// @return whether requests of this kind ask about the past.
bool is_about_history(msg::RequestKind kind) {
  return kind == msg::RequestKind::read_writes || kind == msg::RequestKind::next_window ||
         kind == msg::RequestKind::read_window;
}

}  // namespace

Requests::Requests(const RequestParts& parts, const BenchBrake& brake, RequestAnswers& answers)
    : parts_(parts),
      clock_(std::get<BenchClock&>(parts)),
      masters_(std::get<Masters&>(parts)),
      stores_(std::get<StoreRequests&>(parts)),
      brake_(brake),
      answers_(answers) {}

void Requests::handle(const Arrival& arrival) {
  OutgoingReply* const outgoing = answers_.open();
  if (outgoing == nullptr) return;  // what cannot be answered is not carried out
  if (answer_repeat(arrival)) return;
  answers_.begin(arrival, *outgoing);
  const msg::Request& request = arrival.request;
  Reason reason = check(arrival);
  stores_.begin_request();
  if (reason == msg::Reason::none) reason = carry_out(request, outgoing->reply);
  if (stores_.has_ordered()) {
    stores_.wait(request.session, reason, *outgoing);
    return;
  }
  const bool is_history = is_about_history(request.kind);
  answers_.finish(request.session, reason, outgoing->reply,
                  is_history ? RequestAnswers::Objects::history : RequestAnswers::Objects::results);
  outgoing->page = std::get<Windows&>(parts_).take_page();
  answers_.push();
}

bool Requests::answer_repeat(const Arrival& arrival) {
  const auto& request = arrival.request;
  if (request.client == 0 || !answers_.is_of_this_run(request)) return false;  // check() refuses it
  const Fate fate = answers_.fate_of(request);
  // Pages are not kept; reading one again gives the same page.
  if (fate == Fate::answered && request.kind == msg::RequestKind::read_window) return false;
  if (fate == Fate::unknown) {
    answers_.take(request);
    return false;
  }
  if (arrival.refusal == msg::Reason::none) masters_.note_message(request.session);
  const bool is_in_progress =
      fate == Fate::taken || (fate == Fate::forgotten && stores_.is_waiting(request));
  if (!is_in_progress) answers_.repeat(arrival);
  return true;
}

Reason Requests::check(const Arrival& arrival) const {
  const auto& request = arrival.request;
  if (request.client == 0) return msg::Reason::bad_session;
  if (!answers_.is_of_this_run(request)) return msg::Reason::wrong_incarnation;
  const bool only_reads = request.kind == msg::RequestKind::read || is_about_history(request.kind);
  if (brake_.is_engaged() && !only_reads) return msg::Reason::shutting_down;
  return arrival.refusal;
}

Reason Requests::check_kind(const msg::Request& request) const {
  const wire::RequestKindRow* const row = wire::request_kind_row(request.kind);
  if (row == nullptr) return msg::Reason::unknown_kind;
  if (const Reason reason = check_clock(row->clock, clock_); reason != msg::Reason::none) {
    return reason;
  }
  const bool needs_session = row->caller == wire::RequestCaller::session;
  return needs_session && request.session == 0 ? msg::Reason::bad_session : msg::Reason::none;
}

Reason Requests::carry_out(const msg::Request& request, msg::Reply& reply) {
  masters_.note_message(request.session);
  if (const Reason reason = check_kind(request); reason != msg::Reason::none) return reason;
  const BenchAxes::Authorship author(
      std::get<BenchAxes&>(parts_),
      {.means = JournalAuthor::Means::request, .session = request.session});
  const RequestHandler handler = handler_of(request.kind);
  // In lock-step, requests without a handler go to StepRequests and never get here.
  return handler == nullptr ? msg::Reason::wrong_clock_mode : handler(parts_, request, reply);
}

}  // namespace vdrive::service
