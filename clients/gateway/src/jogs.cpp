// SPDX-License-Identifier: Apache-2.0
#include "jogs.hpp"

#include "vdrive/client/axis.hpp"
#include "vdrive/wording.hpp"

#include <utility>

namespace vdrive::gateway {
namespace {

using client::Outcome;

/// Jogs an axis until `held_until`, and answers as soon as it runs or is refused.
void jog(client::Session& session, const JogRequest& request,
         const std::atomic<Jogs::Clock::time_point>& held_until, const Jogs::Answer& answer) {
  auto axis = session.axis(request.axis);
  if (!axis) {
    answer({.outcome = axis.outcome()});
    return;
  }
  bool has_begun = false;
  const Outcome outcome = axis->jog(
      request.velocity,
      [&](const client::AxisSnapshot&) {
        if (!std::exchange(has_begun, true)) answer({});
        return Jogs::Clock::now() < held_until.load();
      },
      jog_options());
  // A later end, such as a fault, is visible in the status and the events.
  if (!has_begun) answer({.outcome = outcome});
}

}  // namespace

Jogs::~Jogs() {
  // Lets go of all axes before it waits for any, so that they brake at the same time.
  for (auto& [name, jog] : jogs_) let_go(jog);
}

// The jog checks held_until between two ticks and brakes by itself, so this thread does not wait.
void Jogs::let_go(Jog& jog) {
  if (jog.held_until) *jog.held_until = Clock::time_point::min();
}

bool Jogs::is_running(const Jog& jog, Clock::time_point now) {
  return jog.held_until && jog.calls != 0 && now < jog.held_until->load();
}

template <typename Call>
void Jogs::post(Jog& jog, const Answer& answer, Call call) {
  ++jog.calls;  // before post(): the worker may be done before it returns
  const bool is_posted = jog.worker.post([&jog, call = std::move(call)] {
    call();
    --jog.calls;
  });
  if (is_posted) return;
  --jog.calls;
  answer({.outcome = Outcome::failed("too many calls are waiting: this one was dropped")});
}

void Jogs::request(const JogRequest& request, Clock::time_point now, const Answer& answer) {
  if (jogs_.size() >= kMostAxes && !jogs_.contains(request.axis)) {
    // Axes that are no longer requested, but were never released, give up their places.
    std::erase_if(jogs_, [now](const auto& entry) {
      return entry.second.calls == 0 && now - entry.second.asked > kHeldTime;
    });
  }
  if (jogs_.size() >= kMostAxes && !jogs_.contains(request.axis)) {
    answer({.outcome =
                Outcome::failed(counted(kMostAxes, "axis is", "axes are") +
                                " already being jogged, which is the limit: release one first")});
    return;
  }
  Jog& jog = jogs_[request.axis];
  jog.asked = now;
  const bool is_press = request.velocity != 0;
  const bool continues = is_press && is_running(jog, now);
  if (continues && jog.velocity == request.velocity) {
    *jog.held_until = now + kHeldTime;
    answer({});
    return;
  }
  if (is_press && jog.is_pressed && !continues) {
    answer({.outcome = Outcome::failed("the jog of axis " + request.axis +
                                       " has ended: release (velocity 0), then press again")});
    return;
  }
  let_go(jog);
  jog.is_pressed = is_press;
  if (!is_press) {
    post(jog, answer, [answer] {
      answer({});  // after the previous jog, so the axis is at standstill
    });
    return;
  }
  jog.velocity = request.velocity;
  jog.held_until = std::make_shared<Hold>(now + kHeldTime);
  post(jog, answer, [session = session_, request, held_until = jog.held_until, answer] {
    gateway::jog(*session, request, *held_until, answer);
  });
}

void Jogs::forget_ended() {
  std::erase_if(jogs_, [](const auto& entry) {
    return entry.second.calls == 0 && !entry.second.is_pressed;
  });
}

}  // namespace vdrive::gateway
