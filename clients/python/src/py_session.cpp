// SPDX-License-Identifier: Apache-2.0
#include "py_session.hpp"

#include <algorithm>
#include <chrono>

namespace vdrive::python {
namespace {

// How long close() waits for a callback that returns late. A callback that itself waits for close()
// never returns.
constexpr std::chrono::seconds kPatienceOfClose{5};

/// All sessions of Python. Guarded by the interpreter lock, which is also held during a fork.
std::vector<std::weak_ptr<PySession>>& registry() {
  static std::vector<std::weak_ptr<PySession>> sessions;
  return sessions;
}

/// Call without the mutex of the session: creating an exception runs Python and lets other threads
/// run.
[[noreturn]] void raise_closed() {
  raise(client::Outcome::failed("the session is closed"));
}

}  // namespace

SharedPySession open_py_session(const client::SessionOptions& options,
                                std::shared_ptr<void> bench) {
  SharedPySession py_session = made_here<PySession>(options, std::move(bench));
  const Locked locked;
  if (locked) {
    std::erase_if(registry(), [](const auto& other) {
      return other.expired();
    });
    registry().push_back(py_session);
  } else {
    py_session->close();
  }
  return py_session;
}

PySession::Use::Use(PySession& owner) : owner_(&owner) {
  stop_late_thread();
  owner.origin_.require_own("the session");
  {
    const std::scoped_lock lock(owner.mutex_);
    session_ = owner.session_;
    if (session_) owner.callers_.push_back(std::this_thread::get_id());
  }
  if (!session_) raise_closed();
}

PySession::Use::~Use() {
  if (!session_) return;
  if (owner_->is_inherited()) {  // a callback has forked
    leave(std::move(session_));
    return;
  }
  std::shared_ptr<void> bench;  // ends last
  std::unique_lock lock(owner_->mutex_);
  const bool is_last = owner_->callers_.size() == 1 && !owner_->session_;
  if (is_last) bench.swap(owner_->bench_);
  lock.unlock();
  // The interrupt has ended the calls that wait for motion; it must not end the release of the
  // axes.
  if (is_last) session_->end_interrupt();
  session_.reset();
  lock.lock();
  owner_->callers_.erase(std::ranges::find(owner_->callers_, std::this_thread::get_id()));
  lock.unlock();
  owner_->has_ended_.notify_all();
}

std::shared_ptr<client::Session> PySession::session() const {
  stop_late_thread();
  origin_.require_own("the session");
  std::shared_ptr<client::Session> session;
  {
    const std::scoped_lock lock(mutex_);
    session = session_;
  }
  if (!session) raise_closed();
  return session;
}

bool PySession::is_closed() const {
  if (is_inherited()) return true;
  const std::scoped_lock lock(mutex_);
  return session_ == nullptr;
}

void PySession::adopt(const std::shared_ptr<Dependent>& dependent) {
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(dependents_, [](const auto& other) {
      return other.expired();
    });
    if (session_) return dependents_.push_back(dependent);
  }
  dependent->close();
}

void PySession::interrupt() noexcept {
  if (is_inherited()) return;
  const std::scoped_lock lock(mutex_);
  if (session_) session_->interrupt();
}

void PySession::end_interrupt() noexcept {
  if (is_inherited()) return;
  const std::scoped_lock lock(mutex_);
  if (session_) session_->end_interrupt();
}

void PySession::close() noexcept {
  if (is_inherited()) return;
  std::shared_ptr<void> bench;  // ends last
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
  std::unique_lock lock(mutex_);
  has_ended_.wait_for(lock, kPatienceOfClose, [this] {
    return std::ranges::all_of(callers_, [](std::thread::id caller) {
      return caller == std::this_thread::get_id();
    });
  });
  // The interrupt has ended the calls that wait for motion; it must not end the release of the
  // axes.
  if (callers_.empty()) {
    session->end_interrupt();
    bench.swap(bench_);
  }
  lock.unlock();
}

void close_all_sessions() {
  std::vector<SharedPySession> sessions;
  for (const auto& weak : registry()) {
    if (auto py_session = weak.lock()) sessions.push_back(std::move(py_session));
  }
  const Unlocked unlocked;
  // Interrupt all first: a callback of one session may be waiting in a call of another.
  for (const SharedPySession& py_session : sessions) py_session->interrupt();
  for (const SharedPySession& py_session : sessions) py_session->close();
}

}  // namespace vdrive::python
