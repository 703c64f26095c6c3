// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace vdrive::python {

/// Ends a wait of the main thread when a signal arrives that Python handles, such as Ctrl-C.
///
/// The interpreter writes the number of each such signal into a file while it is set to
/// (signal.set_wakeup_fd); a thread waits for that and ends the wait. The wait itself stays in the
/// thread that calls, and costs nothing more. In other threads a watch does nothing: Python runs
/// handlers in the main thread only.
class SignalWatch {
 public:
  /// Needs the interpreter lock.
  /// @param end_wait called in another thread, must neither wait nor throw
  explicit SignalWatch(std::function<void()> end_wait);

  /// Needs the interpreter lock.
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  /// Ends the watch. @return whether `end_wait` was called.
  bool end();

 private:
  std::function<void()> outer_;  ///< of the wait in whose callback this one is
  int outer_file_ = -1;
  bool is_on_ = false;
};

}  // namespace vdrive::python
