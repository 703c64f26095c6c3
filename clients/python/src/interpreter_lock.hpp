// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"

#include <optional>

/// The interpreter lock, usable also while the interpreter is being finalised. When a thread asks
/// for the lock during finalisation, CPython ends the thread by unwinding its C++ stack, which
/// terminates the process. Only daemon threads are left at that time. So after end_calls() they
/// never ask for the lock again: their call ends, and they block until the process ends. Exception:
/// if a Python callback within their call does not return within some seconds, it is left to
/// CPython.
namespace vdrive::python {

/// Releases the interpreter lock for its lifetime.
class Unlocked {
 public:
  /// Call with the lock.
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

/// Acquires the interpreter lock for its lifetime, on a thread that had released it.
class Locked {
 public:
  Locked();

  /// @return false while the interpreter is being finalised: this thread has no lock and must not
  ///         run Python.
  explicit operator bool() const noexcept { return lock_.has_value(); }

 private:
  std::optional<py::gil_scoped_acquire> lock_;
};

/// @return whether the interpreter, and with it this thread, is ending. Any thread.
[[nodiscard]] bool is_late() noexcept;

/// Never returns on a thread that is_late() and is not within another call. Call with the lock.
void stop_late_thread();

/// Called by Python at exit: ends every session, and the calls of the remaining threads.
void end_calls();

/// Forgets the calls of the parent's threads. For a forked process, with the lock.
void forget_calls_of_parent() noexcept;

}  // namespace vdrive::python
