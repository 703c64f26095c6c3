// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace vdrive::python {

/// Ends a wait of the main thread when a signal arrives that Python handles, such as Ctrl-C.
///
/// The interpreter writes the number of each such signal into a file while it is set to
/// (signal.set_wakeup_fd); a thread waits for that and ends the wait. The wait itself stays in the
/// thread that calls, and costs nothing more. In other threads a watch does nothing: Python runs
/// handlers in the main thread only.
class SignalWatch {
 public:
  using Call = std::function<void()>;

  /// Needs the interpreter lock.
  /// @param end_wait called in another thread, must neither wait nor throw
  /// @param wait_again called by end() after `end_wait`, must not throw
  SignalWatch(Call end_wait, Call wait_again);

  /// Needs the interpreter lock.
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  /// Ends the watch. Needs the interpreter lock.
  void end();

  /// What is watched, as the thread that waits for signals sees it.
  struct Wait {
    Call end;
    Wait* outer = nullptr;  ///< the one in whose callback this one is
    std::string signals;    ///< numbers, one byte each, of those that have come
    bool has_ended = false;
  };

 private:
  Wait wait_;
  Call wait_again_;
  int outer_file_ = -1;
  bool is_inner_ = false;  ///< in a callback of a wait that is watched
  bool is_on_ = false;
};

/// In a forked process: its signals are not for its parent. Needs the interpreter lock.
void forget_signals_of_parent();

}  // namespace vdrive::python
