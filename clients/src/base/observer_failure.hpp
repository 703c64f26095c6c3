// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "vdrive/wire/origin.hpp"

#include <deque>
#include <exception>
#include <mutex>
#include <utility>

namespace vdrive::client {

/// What functions of the program have thrown in threads of the session: the next calls of the
/// session throw it to the program, each call one exception. Thread-safe.
class ObserverFailure {
 public:
  explicit ObserverFailure(const Wakeup& wakeup) : wakeup_(wakeup) {}

  /// Calls `report`. @return false when it threw.
  template <typename Report>
  bool run(const Report& report) {
    const ObserverFailure* const outer = std::exchange(reporting(), this);
    bool has_returned = false;
    try {
      report();
      has_returned = true;
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      thrown_.push_back(std::current_exception());
    }
    reporting() = outer;
    return has_returned;
  }

  /// Throws the oldest exception that was not thrown yet, once. Throws nothing in a call that stops
  /// axes: it has to stop them. Nothing either in a call of another observer, whose failure it is
  /// not, or in a forked process.
  void rethrow() {
    if (origin_.is_inherited() || reporting() == this || wakeup_.is_stopping()) return;
    std::exception_ptr thrown;
    {
      const std::scoped_lock lock(mutex_);
      if (thrown_.empty()) return;
      thrown = std::move(thrown_.front());
      thrown_.pop_front();
    }
    std::rethrow_exception(thrown);
  }

 private:
  /// Whose report this thread runs.
  static const ObserverFailure*& reporting() noexcept {
    thread_local const ObserverFailure* failure = nullptr;
    return failure;
  }

  const wire::Origin origin_;
  const Wakeup& wakeup_;
  std::mutex mutex_;
  std::deque<std::exception_ptr> thrown_;  ///< at most one of each observer that was begun
};

}  // namespace vdrive::client
