// SPDX-License-Identifier: Apache-2.0
#include "control_desk.hpp"

#include "descriptions.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/text.hpp"
#include "wall_time.hpp"

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>

namespace vdrive::gateway {
namespace {

using client::Outcome;

// A lost network is noticed early: axes must not run on for 10 s without their master.
constexpr std::chrono::milliseconds kMachineOfHolder{2000};
// All clients show the name on one line.
constexpr std::size_t kLongestName = 64;  // [characters]
// The drive's code when another session holds an axis.
constexpr std::uint32_t kControlled = wire_code(AbortCode::refused_local_control);

// A program may be late: on a busy machine the browser may freeze for some seconds, and so may a
// hidden tab. The client that commands chooses how long that may last.
Patience patience_of_holder(std::chrono::milliseconds silence) {
  return {.program = silence, .machine = std::min(kMachineOfHolder, silence)};
}

}  // namespace

ControlDesk::ControlDesk(bool is_enabled, BenchAccess& access, HubServer& server,
                         ClientTable& clients)
    : is_enabled_(is_enabled),
      access_(access),
      server_(server),
      clients_(clients),
      channel_(std::make_shared<Channel>(control_channel())) {}

ControlDesk::~ControlDesk() {
  end(true);
}

Outcome ControlDesk::check(ConnectionId id, Right right) const {
  if (right == Right::none || right == Right::events || right == Right::judge) return {};
  if (!is_enabled_) {
    return Outcome::refused(kControlled,
                            "this gateway is view-only: start it with --control to command axes");
  }
  const bool needs_control = right == Right::command || right == Right::jog;
  if (!needs_control || is_holder(id)) return {};
  if (holder_) return held_outcome();
  return Outcome::refused(kControlled, "take control first, with /take_control");
}

Outcome ControlDesk::held_outcome() const {
  return Outcome::refused(kControlled, "control is held by " +
                                           in_quotes(clients_.name(holder_->id)) +
                                           ": call /take_control with force to take it over");
}

SessionPointer ControlDesk::session_of(ConnectionId id) const {
  return is_holder(id) ? holder_->session.session : nullptr;
}

void ControlDesk::jog(const JogRequest& request, Jogs::Clock::time_point now,
                      const Answer& answer) {
  ensure(holder_.has_value(), "only the holder of control has the right to jog");
  holder_->session.jogs->request(request, now, answer);
}

ControlDesk::Taking ControlDesk::taking_of(const Json& request) {
  Taking taking{.name = escaped(optional_text(request, "name").value_or(""), kLongestName),
                .by_force = flag_of(request, "force")};
  const auto silence =
      optional_integer(request, "silence_ms",
                       {.lowest = kShortestSilence.count(), .highest = kLongestSilence.count()});
  if (silence) taking.silence = std::chrono::milliseconds(*silence);
  return taking;
}

void ControlDesk::take(ConnectionId id, const Json& request, const Answer& answer) {
  Taking taking = taking_of(request);
  if (is_other_holder(id) && !taking.by_force) return answer({.outcome = held_outcome()});
  if (is_holder(id)) {
    change(std::move(taking));
    return answer({});
  }
  const bool is_posted = clients_.post(id, [this, id, taking = std::move(taking), answer] {
    try {
      server_.post([this, id, taking, answer, session = access_.open()] {
        if (!clients_.contains(id)) return;  // it was closed; the session holds no axes yet
        // Another connection may have taken control while the session was opened.
        if (is_other_holder(id) && !taking.by_force) return answer({.outcome = held_outcome()});
        on_session(id, taking, session);
        answer({});
      });
    } catch (const std::exception& failure) {
      server_.post([answer, outcome = Outcome::failed(failure.what())] {
        answer({.outcome = outcome});
      });
    }
  });
  if (!is_posted) answer({.outcome = Outcome::failed("too many calls are waiting")});
}

void ControlDesk::change(Taking taking) {
  ensure(holder_.has_value(), "only a holder changes its name and its limit");
  if (!taking.name.empty()) clients_.rename(holder_->id, std::move(taking.name));
  holder_->silence = taking.silence.value_or(holder_->silence);
  server_.set_patience(holder_->id, patience_of_holder(holder_->silence));
  send_to_all();
}

void ControlDesk::on_session(ConnectionId id, const Taking& taking, const HeldSession& session) {
  if (!taking.name.empty()) clients_.rename(id, taking.name);
  if (is_other_holder(id)) {
    server_.set_patience(holder_->id, WebServer::kPatience);
    server_.send_status(holder_->id, Level::warning,
                        "control was taken over by " + in_quotes(clients_.name(id)));
  }
  // One session at a time: the previous holder's axes become free for this one.
  end(true);
  holder_ = Holder{.id = id,
                   .taken_at = static_cast<std::uint64_t>(bridge::wall_time()),
                   .silence = taking.silence.value_or(kLongestSilence),
                   .session = session};
  server_.set_patience(id, patience_of_holder(holder_->silence));
  send_to_all();
}

void ControlDesk::release(ConnectionId id) {
  if (!is_holder(id)) return;
  end(true);
  server_.set_patience(id, WebServer::kPatience);
  send_to_all();
}

void ControlDesk::close(ConnectionId id, bool is_graceful) {
  if (!is_holder(id)) return;
  end(is_graceful);
  send_to_all();
}

void ControlDesk::end(bool is_graceful) {
  if (!holder_) return;
  // Keeps no reference, so that access_.end() decides in which thread the session is destroyed.
  Holder ended = *std::exchange(holder_, std::nullopt);
  access_.end(std::move(ended.session), is_graceful);
}

void ControlDesk::send_to_all() const {
  for (const Receiver& receiver : channel_->receivers) {
    send_to(receiver.connection, receiver.subscription);
  }
}

void ControlDesk::send_to(ConnectionId id, std::uint32_t subscription) const {
  ControlState state{.is_enabled = is_enabled_};
  if (holder_) {
    state.holder = clients_.name(holder_->id);
    state.session = holder_->session.id;
    state.taken_at = holder_->taken_at;
    state.silence = holder_->silence;
  }
  const auto now = static_cast<std::uint64_t>(bridge::wall_time());
  const std::string text = control_text(state, clients_.name(id), is_holder(id));
  server_.send_answer(id, message_frame(subscription, now, share(text)), false);
}

void ControlDesk::forget_ended_jogs() {
  if (holder_) holder_->session.jogs->forget_ended();
}

}  // namespace vdrive::gateway
