// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace vdrive::python {

/// Ends a wait of the main thread when a signal arrives that Python handles, such as Ctrl-C.
///
/// The interpreter writes the number of each such signal to the file set with signal.set_wakeup_fd;
/// a thread waits for that and ends the wait. The wait itself stays on the calling thread, at no
/// extra cost. On other threads a watch does nothing: Python runs signal handlers on the main
/// thread only.
class SignalWatch {
 public:
  using Call = std::function<void()>;

  /// Needs the interpreter lock.
  /// @param end_wait called on another thread, must neither wait nor throw
  /// @param wait_again called by end() after `end_wait`, must not throw
  SignalWatch(Call end_wait, Call wait_again);

  /// Needs the interpreter lock.
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  /// Ends the watch. Needs the interpreter lock.
  void end();

  /// The wait being watched, as seen by the thread that waits for signals.
  struct Wait {
    Call end;
    Wait* outer = nullptr;  ///< the wait in whose callback this one runs
    std::string signals;    ///< numbers of the signals that have arrived, one byte each
    bool has_ended = false;
  };

 private:
  Wait wait_;
  Call wait_again_;
  int outer_file_ = -1;
  bool is_inner_ = false;  ///< in a callback of a wait that is being watched
  bool is_on_ = false;
};

/// To be called in a forked process, so that its signals do not reach the parent. Needs the
/// interpreter lock.
void forget_signals_of_parent();

}  // namespace vdrive::python
