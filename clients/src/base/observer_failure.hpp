// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "vdrive/wire/origin.hpp"

#include <exception>
#include <mutex>
#include <utility>

namespace vdrive::client {

/// What a function of the program has thrown in a thread of the session: the next call of the
/// session throws it to the program. Thread-safe.
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
      if (!thrown_) thrown_ = std::current_exception();
    }
    reporting() = outer;
    return has_returned;
  }

  /// Throws the first exception that was not thrown yet, once. Throws nothing in a call that stops
  /// axes: it has to stop them. Nothing either in a call of another observer, whose failure it is
  /// not, or in a forked process.
  void rethrow() {
    if (origin_.is_inherited() || reporting() == this || wakeup_.is_stopping()) return;
    std::exception_ptr thrown;
    {
      const std::scoped_lock lock(mutex_);
      thrown = std::exchange(thrown_, nullptr);
    }
    if (thrown) std::rethrow_exception(thrown);
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
  std::exception_ptr thrown_;
};

}  // namespace vdrive::client
