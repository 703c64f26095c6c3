// SPDX-License-Identifier: Apache-2.0
#include "held_session.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace vdrive::gateway {

HeldSession open_held_session(const client::SessionOptions& options) {
  // A client commands a bench that its page shows: this gateway has found it. The holder's session
  // is a new participant, which a busy machine may keep from finding it for longer than a search.
  constexpr std::chrono::seconds kFindTimeout{5};
  client::SessionOptions own = options;
  own.find_timeout = std::max<std::chrono::milliseconds>(own.find_timeout, kFindTimeout);
  auto session = std::make_shared<client::Session>(own);
  return {.id = session->id(), .session = session, .jogs = std::make_shared<Jogs>(session)};
}

void end_held_session(HeldSession held, bool is_graceful, bridge::Worker& worker) {
  // At once: a worker of the connection may be in a call of this session.
  if (!is_graceful) held.session->abandon();
  // A full queue drops it, which ends jogs and session too: here, and then this thread waits.
  (void)worker.post([held = std::move(held), is_graceful]() mutable {
    held.jogs.reset();  // what it jogs stands, before its axes are given back
    if (is_graceful) {
      held.session->interrupt();
      (void)held.session->release();
    }
    held.session.reset();
  });
}

}  // namespace vdrive::gateway
