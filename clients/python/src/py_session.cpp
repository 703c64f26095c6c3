// SPDX-License-Identifier: Apache-2.0
#include "py_session.hpp"

#include <algorithm>

namespace vdrive::python {
namespace {

/// Every session that Python has. Guarded by the interpreter lock, which whoever forks holds.
std::vector<std::weak_ptr<PySession>>& registry() {
  static std::vector<std::weak_ptr<PySession>> sessions;
  return sessions;
}

}  // namespace

SharedPySession open_py_session(const client::SessionOptions& options) {
  SharedPySession py_session = made_here<PySession>(options);
  const py::gil_scoped_acquire locked;
  std::erase_if(registry(), [](const auto& other) {
    return other.expired();
  });
  registry().push_back(py_session);
  return py_session;
}

std::shared_ptr<client::Session> PySession::session() const {
  origin_.require_own("the session");
  const std::scoped_lock lock(mutex_);
  if (!session_) raise(client::Outcome::failed("the session is closed"));
  return session_;
}

bool PySession::is_closed() const {
  if (is_inherited()) return true;
  const std::scoped_lock lock(mutex_);
  return session_ == nullptr;
}

void PySession::adopt(const std::shared_ptr<Dependent>& dependent) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(dependents_, [](const auto& other) {
    return other.expired();
  });
  dependents_.push_back(dependent);
}

void PySession::close() noexcept {
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
  std::vector<SharedPySession> sessions;
  for (const auto& weak : registry()) {
    if (auto py_session = weak.lock()) sessions.push_back(std::move(py_session));
  }
  const py::gil_scoped_release unlocked;
  for (const SharedPySession& py_session : sessions) py_session->close();
}

}  // namespace vdrive::python
