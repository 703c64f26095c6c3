// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <mutex>
#include <utility>

namespace vdrive::client {

/// What a function of the program has thrown in a thread of the session: the next call of the
/// session throws it to the program. Thread-safe.
class ObserverFailure {
 public:
  /// Calls `report`. @return false when it threw.
  template <typename Report>
  bool run(const Report& report) {
    try {
      report();
      return true;
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!thrown_) thrown_ = std::current_exception();
      return false;
    }
  }

  /// Throws the first exception that was not thrown yet, once.
  void rethrow() {
    std::exception_ptr thrown;
    {
      const std::scoped_lock lock(mutex_);
      thrown = std::exchange(thrown_, nullptr);
    }
    if (thrown) std::rethrow_exception(thrown);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr thrown_;
};

}  // namespace vdrive::client
