// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"

#include <optional>

/// The interpreter lock, also while the interpreter ends. From that moment on CPython ends each
/// thread that asks for its lock, inside of the call that asks: it unwinds the stack of C++, which
/// ends the process. Only daemon threads are left then. So from end_calls() on they never ask
/// again: their call ends, and they rest until the process ends. A callback that Python runs in
/// such a call, and that does not return within some seconds, is left to CPython.
namespace vdrive::python {

/// Gives the interpreter lock up while it lives.
class Unlocked {
 public:
  /// With the lock.
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

/// Takes the interpreter lock while it lives, in a thread that gave it up.
class Locked {
 public:
  Locked();

  /// @return false when the interpreter ends: this thread has no lock, and must not run Python.
  explicit operator bool() const noexcept { return lock_.has_value(); }

 private:
  std::optional<py::gil_scoped_acquire> lock_;
};

/// @return whether the interpreter ends, and this thread with it. Any thread.
[[nodiscard]] bool is_late() noexcept;

/// Never returns in a thread that is_late() and in no other call. With the lock.
void stop_late_thread();

/// What Python does at its exit: ends every session, and the calls of the threads that are left.
void end_calls();

/// Forgets the calls of the threads of the parent. In a forked process, with the lock.
void forget_calls_of_parent() noexcept;

}  // namespace vdrive::python
