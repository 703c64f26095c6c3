// SPDX-License-Identifier: Apache-2.0
#include "presence.hpp"

#include <algorithm>

namespace vdrive::python {
namespace {

/// Every session that Python has. Guarded by the interpreter lock, which whoever forks holds.
std::vector<std::weak_ptr<Presence>>& registry() {
  static std::vector<std::weak_ptr<Presence>> presences;
  return presences;
}

}  // namespace

SharedPresence open_presence(const client::SessionOptions& options) {
  SharedPresence presence = made_here<Presence>(options);
  const py::gil_scoped_acquire locked;
  std::erase_if(registry(), [](const auto& other) {
    return other.expired();
  });
  registry().push_back(presence);
  return presence;
}

std::shared_ptr<client::Session> Presence::session() const {
  origin_.require_own("the session");
  const std::scoped_lock lock(mutex_);
  if (!session_) raise(client::Outcome::failed("the session is closed"));
  return session_;
}

bool Presence::is_closed() const {
  if (is_inherited()) return true;
  const std::scoped_lock lock(mutex_);
  return session_ == nullptr;
}

void Presence::adopt(const std::shared_ptr<Dependent>& dependent) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(dependents_, [](const auto& other) {
    return other.expired();
  });
  dependents_.push_back(dependent);
}

void Presence::close() noexcept {
  if (is_inherited()) return;
  std::shared_ptr<client::Session> session;
  std::vector<std::weak_ptr<Dependent>> dependents;
  {
    const std::scoped_lock lock(mutex_);
    session.swap(session_);
    dependents.swap(dependents_);
  }
  if (!session) return;
  session->interrupt();
  for (const auto& weak : dependents) {
    if (const auto dependent = weak.lock()) dependent->close();
  }
  // What gives the axes back is no call that waits for motion; a call of another thread has ended
  // by now, or ends the session with it.
  session->end_interrupt();
}

void close_all_sessions() {
  std::vector<SharedPresence> presences;
  for (const auto& weak : registry()) {
    if (auto presence = weak.lock()) presences.push_back(std::move(presence));
  }
  const py::gil_scoped_release unlocked;
  for (const SharedPresence& presence : presences) presence->close();
}

}  // namespace vdrive::python
