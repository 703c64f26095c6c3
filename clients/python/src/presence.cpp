// SPDX-License-Identifier: Apache-2.0
#include "presence.hpp"

#include <algorithm>

namespace vdrive::python {
namespace {

std::mutex& registry_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// Every session that Python has.
std::vector<Presence*>& registry() {
  static std::vector<Presence*> presences;
  return presences;
}

}  // namespace

Presence::Presence(const client::SessionOptions& options)
    : session_(std::make_shared<client::Session>(options)) {
  const std::scoped_lock lock(registry_mutex());
  registry().push_back(this);
}

Presence::~Presence() {
  {
    const std::scoped_lock lock(registry_mutex());
    std::erase(registry(), this);
  }
  close();
}

std::shared_ptr<client::Session> Presence::session() const {
  const std::scoped_lock lock(mutex_);
  if (!session_) raise(client::Outcome::failed("the session is closed"));
  return session_;
}

bool Presence::is_closed() const {
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
  const py::gil_scoped_release unlocked;
  std::vector<Presence*> presences;
  {
    const std::scoped_lock lock(registry_mutex());
    presences = registry();
  }
  for (Presence* const presence : presences) presence->close();
}

}  // namespace vdrive::python
