// SPDX-License-Identifier: Apache-2.0
#include "control.hpp"

#include "wall_time.hpp"

#include <utility>

namespace vdrive::gateway {

Control::~Control() {
  release();
}

ControlState Control::state(const std::string& holder_name) const {
  return {.is_enabled = is_enabled_,
          .holder = holder_name,
          .session = session_ ? session_->id() : 0,
          .taken_at = taken_at_};
}

void Control::take(ConnectionId id, SessionPointer session) {
  release();
  holder_ = id;
  session_ = std::move(session);
  jogs_ = std::make_shared<Jogs>(session_);
  taken_at_ = static_cast<std::uint64_t>(bridge::wall_time());
}

void Control::release() {
  end(true);
}

void Control::abandon() {
  end(false);
}

void Control::end(bool is_graceful) {
  if (!holder_) return;
  holder_.reset();
  taken_at_ = 0;
  SessionPointer session = std::exchange(session_, nullptr);
  std::shared_ptr<Jogs> jogs = std::exchange(jogs_, nullptr);
  // At once: a worker of the connection may be in a call of this session.
  if (!is_graceful) session->abandon();
  auto last = [session = std::move(session), jogs = std::move(jogs), is_graceful]() mutable {
    jogs.reset();  // what it jogs stands
    if (is_graceful) {
      session->interrupt();
      (void)session->release();
    }
    session.reset();
  };
  // A full queue drops it, which ends jogs and session too: here, and then this thread waits.
  (void)ends_.post(std::move(last));
}

void Control::jog(const JogRequest& request, Clock::time_point now, const Jogs::Answer& answer) {
  jogs_->request(request, now, answer);
}

void Control::forget_ended() {
  if (jogs_) jogs_->forget_ended();
}

}  // namespace vdrive::gateway
