// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "vdrive/wire/origin.hpp"

#include <deque>
#include <exception>
#include <mutex>
#include <utility>

namespace vdrive::client {

/// Exceptions that observers of the program have thrown in threads of the session. Later calls of
/// the session rethrow them to the program, one per call. Thread-safe.
class ObserverFailure {
 public:
  explicit ObserverFailure(const Wakeup& wakeup) : wakeup_(wakeup) {}

  /// Calls `report`.
  /// @return false if it threw.
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

  /// Rethrows the oldest exception not yet rethrown. Does nothing in a call that stops axes,
  /// because that call must get through; in a call from another observer, which is not responsible
  /// for the failure; or in a forked process.
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
  /// The object whose report is running on this thread.
  static const ObserverFailure*& reporting() noexcept {
    thread_local const ObserverFailure* failure = nullptr;
    return failure;
  }

  const wire::Origin origin_;
  const Wakeup& wakeup_;
  std::mutex mutex_;
  std::deque<std::exception_ptr> thrown_;  ///< at most one per observer that was started
};

}  // namespace vdrive::client
